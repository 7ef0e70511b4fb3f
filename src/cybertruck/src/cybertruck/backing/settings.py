"""Settings of the backing node; no ROS."""

import math
from dataclasses import dataclass

from paddock_common.settings import check, from_table, number, read, text

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

    control_period: float = number(0.032, above=0.0, unit="s")
    state_timeout: float = number(0.5, above=0.0, unit="s")
    stuck_time: float = number(5.0, above=0.0, unit="s")
    odom_frame: str = text("odom")
    hitch_joint: str = text("hitch_yaw_joint")
    steering_map: str = text("", empty=True)

    def __post_init__(self):
        check(self, TrailerError)


@dataclass(frozen=True)
class Settings:
    """All settings: geometry, tuning, node, and the steering map."""

    geometry: Geometry
    tuning: Tuning
    node: NodeSettings
    steering: object


def settings_from(parameters):
    """Makes Settings from the node's private parameters.

    Args:
        parameters: Dict with truck.yaml's keys, of which the geometry is used, and the tables
            `tuning`, `node` and (optionally) `hitch_stop` [rad].

    Raises:
        TrailerError: Names the parameter, its value and what is valid.
    """
    geometry = read(Geometry, parameters.get, prefix="")
    node = from_table(NodeSettings, parameters.get("node", {}), "node", TrailerError)
    tuning = from_table(Tuning, parameters.get("tuning", {}), "tuning", TrailerError)
    steering = (
        read_map(node.steering_map)
        if node.steering_map
        else IdealSteering(geometry.wheelbase, geometry.max_steering)
    )
    return Settings(geometry, tuning, node, steering)
