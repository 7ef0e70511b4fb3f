"""Lidars of several layers and bundles of rays."""

import numpy as np

from bullet_sim.sensors.lidar import Lidar


class LayeredLidar(Lidar):
    """Rays of a CloudSpec or RangeSpec; `scan` returns (samples * layers,) ranges.

    The layers of one direction follow each other, lowest first.

    Attributes:
        rings: (samples * layers,) number of each ray's layer.

    Raises:
        ValueError: as Lidar; no layer, elevations in the wrong order.
    """

    def __init__(self, spec):
        super().__init__(spec)
        if spec.layers < 1:
            raise ValueError(f"lidar {spec.name}: layers {spec.layers}, at least 1 is expected")
        if not spec.max_elevation >= spec.min_elevation:
            raise ValueError(
                f"lidar {spec.name}: vertical min_angle {spec.min_elevation}, max_angle "
                f"{spec.max_elevation}: min_angle <= max_angle rad is expected"
            )
        elevations = np.linspace(spec.min_elevation, spec.max_elevation, spec.layers)
        azimuth, elevation = (
            a.ravel() for a in np.meshgrid(self.angles, elevations, indexing="ij")
        )
        self.rings = np.tile(np.arange(spec.layers), len(self.angles))
        self.directions = np.column_stack(
            [
                np.cos(elevation) * np.cos(azimuth),
                np.cos(elevation) * np.sin(azimuth),
                np.sin(elevation),
            ]
        )
        self._aim()

    def points(self, ranges):
        """Points (n, 3) float32 [m] in the sensor frame; NaN where nothing was hit."""
        reached = np.where(np.isfinite(ranges), ranges, np.nan)
        return (self.directions * reached[:, None]).astype(np.float32)
