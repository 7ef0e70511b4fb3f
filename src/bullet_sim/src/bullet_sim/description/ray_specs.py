"""Specifications of sensors that cast rays but publish no LaserScan."""

from dataclasses import dataclass

from bullet_sim.description.specs import RaySpec


@dataclass(frozen=True)
class CloudSpec(RaySpec):
    """A lidar of one or several layers that publishes points.

    Attributes:
        layers: rays above each other.
        min_elevation, max_elevation: of the lowest and the highest layer [rad], positive up.
        layout: "velodyne": PointCloud2 with x, y, z, intensity, ring, time; "block": PointCloud.
        organized: PointCloud2 of one row a layer, NaN where nothing was hit; else hits only.
    """

    layers: int = 1
    min_elevation: float = 0.0
    max_elevation: float = 0.0
    layout: str = "velodyne"
    organized: bool = False


@dataclass(frozen=True)
class RangeSpec(RaySpec):
    """A sonar or infrared sensor: the nearest hit of a bundle of rays, as sensor_msgs/Range.

    Attributes:
        layers, min_elevation, max_elevation: as CloudSpec's.
        infrared: True: infrared; False: ultrasound.
        field_of_view: written into the message [rad].
    """

    layers: int = 1
    min_elevation: float = 0.0
    max_elevation: float = 0.0
    infrared: bool = False
    field_of_view: float = 0.05
