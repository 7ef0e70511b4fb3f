"""Settings of the backing node; no ROS."""

import math
from dataclasses import dataclass, fields

from cybertruck.trailer.geometry import Geometry, TrailerError
from cybertruck.trailer.steering import IdealSteering, read_map
from cybertruck.trailer.tracker import Tuning

MAX_START_DISTANCE = 3.0  # from the trailer's axle to the path's first metres [m]
MAX_START_HEADING = math.radians(75.0)  # between trailer and path at the start [rad]


@dataclass(frozen=True)
class NodeSettings:
    """Settings of the node itself.

    Attributes:
        control_period: Simulated time between two commands [s].
        state_timeout: Time without odometry or joint states after which the truck stops [s].
        stuck_time: A goal ends when nothing moved for this time [s].
        odom_frame: Frame of goals' paths.
        hitch_joint: Name in /joint_states.
        steering_map: File of a measured map, or "" for the ideal tan φ / L.
    """

    control_period: float = 0.032
    state_timeout: float = 0.5
    stuck_time: float = 5.0
    odom_frame: str = "odom"
    hitch_joint: str = "hitch_yaw_joint"
    steering_map: str = ""

    def __post_init__(self):
        for name in ("control_period", "state_timeout", "stuck_time"):
            value = getattr(self, name)
            if (
                isinstance(value, bool)
                or not isinstance(value, (int, float))
                or not (math.isfinite(value) and value > 0.0)
            ):
                raise TrailerError(f"{name} is {value!r}; it must be a time above 0 [s]")
        for name in ("odom_frame", "hitch_joint", "steering_map"):
            value = getattr(self, name)
            if not isinstance(value, str) or (not value and name != "steering_map"):
                raise TrailerError(f"{name} is {value!r}; it must be a name")


@dataclass(frozen=True)
class Settings:
    """All settings: geometry, tuning, node, and the steering map."""

    geometry: Geometry
    tuning: Tuning
    node: NodeSettings
    steering: object


def known(kind, data, what):
    """Makes a dataclass from a dict.

    Raises:
        TrailerError: A key that the class does not have, or a value that it refuses.
    """
    if not isinstance(data, dict):
        raise TrailerError(f"{what} is {data!r}; it must be a table of names and values")
    names = [item.name for item in fields(kind)]
    unknown = sorted(str(key) for key in set(data) - set(names))
    if unknown:
        raise TrailerError(f"{what}: unknown {', '.join(unknown)}; there are: {', '.join(names)}")
    return kind(**data)


def settings_from(parameters):
    """Makes Settings from the node's private parameters.

    Args:
        parameters: Dict with truck.yaml's keys, of which the geometry is used, and the tables
            `tuning`, `node` and (optionally) `hitch_stop` [rad].

    Raises:
        TrailerError: Names the parameter, its value and what is valid.
    """
    geometry = Geometry(
        **{item.name: parameters[item.name] for item in fields(Geometry) if item.name in parameters}
    )
    node = known(NodeSettings, parameters.get("node", {}), "node")
    steering = (
        read_map(node.steering_map)
        if node.steering_map
        else IdealSteering(geometry.wheelbase, geometry.max_steering)
    )
    return Settings(geometry, known(Tuning, parameters.get("tuning", {}), "tuning"), node, steering)
