"""Lidars of one layer and of several, by ray casts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.engine.api import Rays
from bullet_sim.pose import Array, Vector, matrix_from_rpy, rotation_matrix
from bullet_sim.sensors.retro import intensities

if TYPE_CHECKING:
    from bullet_sim.engine import Engine
    from bullet_sim.models.model import Model

MAX_RAYS = 1_000_000  # of a scan; it costs some 100 bytes for each


class Lidar:
    """Ray directions of one RaySpec, computed once.

    Rays lie in the x-y plane of the sensor frame, counted from min_angle to max_angle, both
    included (sensor_msgs/LaserScan), which is clockwise where the first is the larger one. As in
    Gazebo a single one points ahead.

    Attributes:
        angles: (n,) [rad].
        angle_increment: [rad]; of a single ray inf or NaN, as in Gazebo.
        directions: (n, 3) unit vectors in the sensor frame.
        hits: of the last scan: where the rays begin (3,) [m], their directions (n, 3) in the world,
            the ranges (n,) [m] without noise.

    Raises:
        ValueError: samples < 1, more than MAX_RAYS, ranges in the wrong order, negative noise.
    """

    def __init__(self, spec: Any) -> None:
        n, noise = spec.samples, spec.noise_stddev
        near, far, rays = spec.range_min, spec.range_max, n * spec.layers
        for holds, text in (
            (int(n) == n and n >= 1, f"samples {n}, a whole number >= 1"),
            (rays <= MAX_RAYS, f"{rays} rays, at most {MAX_RAYS}"),
            (0.0 <= near < far < np.inf, f"range_min {near}, range_max {far}: 0 <= min < max m"),
            (noise >= 0.0, f"noise_stddev {noise}, >= 0 m"),
        ):
            if not holds:
                raise ValueError(f"lidar {spec.name}: {text} expected")
        n = int(n)
        self.spec = spec
        self.angles = np.linspace(spec.min_angle, spec.max_angle, n) if n > 1 else np.zeros(1)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.angle_increment = float(np.divide(spec.max_angle - spec.min_angle, n - 1))
        self.directions = np.column_stack([np.cos(self.angles), np.sin(self.angles), np.zeros(n)])
        self._position = np.asarray(spec.pose[0], dtype=float)  # in the link's frame, as the rays
        self._aim()

    def _aim(self) -> None:
        """Rotate the directions into the link's frame."""
        self._rays = self.directions @ matrix_from_rpy(self.spec.pose[1]).T

    def scan(
        self,
        engine: Engine,
        link_position: Vector,
        link_orientation: Vector,
        rng: Any = None,
        bias: float = 0.0,
    ) -> Array:
        """One sweep, all rays at the same instant.

        Rays begin at range_min and see nothing before it, as in Gazebo; one that begins within a
        shape, such as the sensor's housing, meets it from inside.

        Args:
            engine: casts the rays, see Engine.cast_rays: an engine, or World.visible.
            link_position: (3,) [m], the sensor's link in the world.
            link_orientation: (x, y, z, w), the sensor's link in the world.
            rng: numpy.random.Generator for the noise; needed when noise_stddev > 0.
            bias: added to all ranges [m].

        Returns:
            (n,) float32 [m], min_angle first; inf: nothing up to range_max.
        """
        spec = self.spec
        if spec.noise_stddev > 0.0 and rng is None:
            raise ValueError(
                f"lidar {spec.name}: noise_stddev {spec.noise_stddev} m "
                "needs a random generator (rng)"
            )
        rotation = rotation_matrix(link_orientation)
        position = np.asarray(link_position, dtype=float) + rotation @ self._position
        directions = self._rays @ rotation.T
        ranges = engine.cast_rays(Rays(position, directions, spec.range_min, spec.range_max))
        self.hits = position, directions, ranges
        noise = spec.noise_mean + bias
        if spec.noise_stddev > 0.0:
            noise = noise + rng.normal(0.0, spec.noise_stddev, len(ranges))
        if spec.noise_stddev > 0.0 or noise or spec.precision > 0.0:
            noisy = ranges + noise
            if spec.precision > 0.0:
                noisy = np.round(noisy / spec.precision) * spec.precision
            noisy = np.minimum(np.maximum(noisy, spec.range_min), spec.range_max)
            ranges = np.where(np.isfinite(ranges), noisy, ranges)
        return ranges.astype(np.float32)

    def intensities(self, models: Iterable[Model]) -> Array | None:
        """Intensities (n,) float32 of the last scan; None: no model has a <laser_retro>."""
        models, seen = list(models), "visuals" if self.spec.sees_visuals else "collisions"
        links = (link for model in models for link in model.rigid_parts.values())
        if not any(shape.laser_retro for link in links for shape in getattr(link, seen)):
            return None
        position, directions, ranges = self.hits
        hits = np.where(np.isfinite(ranges), ranges, np.nan)[:, None]
        return intensities(models, position + hits * directions, seen)


class LayeredLidar(Lidar):
    """Rays of a specification with layers; `scan` returns (samples * layers,) ranges.

    The layers of one direction follow each other from min_elevation to max_elevation, as in Gazebo,
    where the first may be above the last; a single one is level.

    Attributes:
        rings: (samples * layers,) index of each ray's layer.

    Raises:
        ValueError: as Lidar; no layer.
    """

    def __init__(self, spec: Any) -> None:
        super().__init__(spec)
        if spec.layers < 1:
            raise ValueError(f"lidar {spec.name}: layers {spec.layers}, at least 1 is expected")
        elevations = np.zeros(1)
        if spec.layers > 1:
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

    def points(self, ranges: Array) -> Array:
        """Points (n, 3) float32 [m] in the sensor frame; NaN where nothing was hit."""
        hits = np.where(np.isfinite(ranges), ranges, np.nan)
        return (self.directions * hits[:, None]).astype(np.float32)


class PatternLidar(Lidar):
    """Rays of a PatternSpec; each scan has the next ones of the pattern.

    Args:
        pattern: (n, 3): time, azimuth and zenith [deg] of all rays.

    Attributes:
        lines: (samples,) of the last scan.
        inside: (samples,) bool: rays of the last scan that are in the fields of view.
    """

    def __init__(self, spec: Any, pattern: Array) -> None:
        super().__init__(spec)
        self._azimuth = np.radians(pattern[:, 1])
        self._tilt = np.radians(pattern[:, 2]) - 0.5 * np.pi  # positive down
        self.next(0)

    def next(self, first: int) -> int:
        """Aim the rays from one of the pattern on; the first one of the next scan."""
        spec, count = self.spec, len(self._azimuth)
        rows = np.arange(first, first + spec.taken, spec.step) % count
        self.lines = rows % 6
        azimuth, tilt = self._azimuth[rows], self._tilt[rows]
        level = np.cos(tilt)
        self.directions = np.column_stack(
            [level * np.cos(azimuth), level * np.sin(azimuth), -np.sin(tilt)]
        )
        self.inside = np.ones(len(rows), bool)
        for angles, (low, step, number) in zip((azimuth, tilt), spec.fields):
            row = np.rint((angles - low) / step)
            self.inside &= (row >= 0) & (row < number)
        self._aim()
        first += spec.taken
        return first - count if first > count else first

    def points(self, ranges: Array) -> tuple[Array, Array]:
        """Points (n, 3) float32 [m] in the sensor frame, and which rays they are of."""
        spec = self.spec
        far = ranges + spec.shift
        hit = self.inside & (far < spec.range_max + spec.shift) & (far > spec.shift)
        rays = np.flatnonzero(hit)
        return (self.directions[rays] * far[rays, None]).astype(np.float32), rays
