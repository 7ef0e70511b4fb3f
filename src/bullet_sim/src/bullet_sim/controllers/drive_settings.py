"""Settings of controllers that drive a base: its measures in the URDF, speed limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Tuple

from bullet_sim.controllers.settings import REQUIRED, ControllerConfig, Settings
from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.errors import ControllerError
from bullet_sim.pose import Pose, Vec3

Claims = Tuple[Tuple[str, Tuple[str, ...]], ...]


def _with_joint(description: ModelDescription | None, name: str) -> ModelDescription:
    if description is None or name not in description.joints:
        raise ControllerError(f"joint '{name}' is not in the robot's description")
    return description


def joint_position(description: ModelDescription | None, name: str) -> Vec3:
    """Position (3,) [m] of a joint in the root link's frame, all joints at 0.

    Raises:
        ControllerError: no such joint.
    """
    description = _with_joint(description, name)
    pose = Pose()
    joint: Joint | None = description.joints[name]
    parents = description.above()
    while joint is not None:
        pose = joint.origin * pose
        joint = parents.get(joint.parent)
    return pose.position


def joint_origin(description: ModelDescription | None, name: str) -> Vec3:
    """Position (3,) [m] of a joint in its parent link's frame, between two of which
    diff_drive_controller and ackermann_steering_controller measure, whatever their parents.

    Raises:
        ControllerError: no such joint.
    """
    return _with_joint(description, name).joints[name].origin.position


ROUND = ("cylinder", "sphere")


def wheel_radius(
    description: ModelDescription | None, name: str, kinds: tuple[str, ...] = ("cylinder",)
) -> float:
    """Radius [m] of the shape with which a joint's child link collides.

    Args:
        kinds: of shapes that count: urdf_geometry_parser takes cylinders, diff_drive_controller
            spheres, too.

    Raises:
        ControllerError: no such joint, or the link has none of them.
    """
    description = _with_joint(description, name)
    link = description.links[description.joints[name].child]
    for shape in link.collisions:
        if shape.geometry.kind in kinds:
            return shape.geometry.size[0]
    raise ControllerError(
        f"link '{link.name}' has no {' or '.join(kinds)} as its collision to take it from"
    )


@dataclass(frozen=True)
class SpeedLimiter:
    """Bounds, each a pair (min, max), or None for no limit.

    Attributes:
        velocity: [m/s, rad/s].
        acceleration: change of velocity per time [m/s^2, rad/s^2].
        jerk: change of acceleration per time [m/s^3, rad/s^3].
    """

    velocity: tuple[float, float] | None = None
    acceleration: tuple[float, float] | None = None
    jerk: tuple[float, float] | None = None

    def limit(self, target: float, last: float, last_but_one: float, period: float) -> float:
        """The target velocity, limited.

        Args:
            last, last_but_one: velocities of the last two periods.
            period: [s].
        """
        value = target
        if self.jerk is not None:
            change = last - last_but_one
            bounds = [2.0 * jerk * period * period for jerk in self.jerk]
            value = last + change + _clamp(value - last - change, bounds)
        if self.acceleration is not None:
            value = last + _clamp(value - last, [a * period for a in self.acceleration])
        if self.velocity is not None:
            value = _clamp(value, self.velocity)
        return value


def _clamp(value: float, bounds: Sequence[float]) -> float:
    return min(max(value, bounds[0]), bounds[1])


def parse_limiter(settings: Settings) -> SpeedLimiter:
    """SpeedLimiter from a `linear/x` or `angular/z` block: a max that is not given is 0, any min is
    taken as it is, as upstream does."""
    pairs = {}
    for quantity in ("velocity", "acceleration", "jerk"):
        high = settings.number(f"max_{quantity}", 0.0)
        low = settings.number(f"min_{quantity}", -high)
        if settings.flag(f"has_{quantity}_limits", False):
            pairs[quantity] = (low, high)
    return SpeedLimiter(**pairs)


WITHOUT_EFFECT = (
    "publish_wheel_joint_controller_state",
    "preserve_turning_radius",
    "publish_joint_trajectory_controller_state",
)


@dataclass(frozen=True)
class BaseConfig(ControllerConfig):
    """Configuration that all types of bases share.

    Attributes:
        timeout: age [s] at which a command counts as 0.
        open_loop: odometry from the commands instead of from the joints.
        window: periods over which the odometry's velocity is averaged.
        publish_command: the limited command as a topic.
        single_publisher: stop when more than one publisher sends commands.
        pose_covariance, twist_covariance: six diagonal elements each.
    """

    linear: SpeedLimiter = SpeedLimiter()
    angular: SpeedLimiter = SpeedLimiter()
    timeout: float = 0.5
    open_loop: bool = False
    window: int = 10
    base_frame: str = "base_link"
    odom_frame: str = "odom"
    publish_tf: bool = True
    publish_command: bool = False
    single_publisher: bool = False
    pose_covariance: tuple[float, ...] = (0.0,) * 6
    twist_covariance: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class DriveConfig(BaseConfig):
    """Configuration of a base with two sides, or with one rear wheel and one steering joint.

    Attributes:
        left, right: wheel joints; of an Ackermann base `left` is the rear wheel and `right` the
            front steering joint.
        separation: between left and right wheels, or between axles [m], with its multiplier.
        radii: of the left and right wheels, or of the rear wheel for odometry and for the
            command [m], with their multipliers.
        steer_multiplier: of the measured steering angle in the odometry.
        sizes: separation and radius without multipliers [m].
        multipliers: of the separation and of the left and the right radius.
        publish_wheels: what the wheels do, as a topic.
    """

    left: tuple[str, ...] = REQUIRED
    right: tuple[str, ...] = REQUIRED
    separation: float = REQUIRED
    radii: tuple[float, float] = REQUIRED
    steer_multiplier: float = 1.0
    sizes: tuple[float, float] = (0.0, 0.0)
    multipliers: tuple[float, float, float] = (1.0, 1.0, 1.0)
    publish_wheels: bool = False


def common(
    settings: Settings, claims: Claims, ignored_keys: Sequence[str] = WITHOUT_EFFECT
) -> dict[str, Any]:
    """Values of a BaseConfig."""
    ignored = settings.ignore(*ignored_keys)
    return {
        "name": settings.name,
        "joints": tuple(joint for _, names in claims for joint in names),
        "claims": claims,
        "publish_rate": settings.rate(),
        "notes": tuple(f"{settings.label}: {key} has no effect here" for key in ignored),
        "linear": parse_limiter(settings.block("linear", "x")),
        "angular": parse_limiter(settings.block("angular", "z")),
        "timeout": settings.number("cmd_vel_timeout", 0.5),
        "open_loop": settings.flag("open_loop", False),
        "window": int(settings.number("velocity_rolling_window_size", 10, above=0)),
        "base_frame": settings.text("base_frame_id", "base_link"),
        "odom_frame": settings.text("odom_frame_id", "odom"),
        "publish_tf": settings.flag("enable_odom_tf", True),
        "publish_command": settings.flag("publish_cmd", False),
        "single_publisher": not settings.flag("allow_multiple_cmd_vel_publishers", True),
        "pose_covariance": _diagonal(settings, "pose_covariance_diagonal"),
        "twist_covariance": _diagonal(settings, "twist_covariance_diagonal"),
    }


def _diagonal(settings: Settings, key: str) -> tuple[float, ...]:
    """Six numbers, as upstream reads them: it needs the list and floats in it, others are 0."""
    value = settings.get(key)
    numbers = value[:6] if isinstance(value, list) else [None]
    if not all(isinstance(number, float) and math.isfinite(number) for number in numbers):
        raise ControllerError(
            f"{settings.label} has {key} {value!r}, must be six numbers, all with a decimal point"
        )
    return (*numbers, *[0.0] * (6 - len(numbers)))


def wheel_names(settings: Settings, key: str) -> tuple[str, ...]:
    """Joint names: a list, or one name alone."""
    value = settings.get(key)
    names = value if isinstance(value, list) else [value]
    if not names or not all(isinstance(name, str) and name for name in names):
        raise ControllerError(
            f"{settings.label} has {key} {value!r}, must be a joint name or a list of them"
        )
    return tuple(names)


def size(settings: Settings, key: str, measure: Callable[[], float]) -> float:
    """A length [m] from the settings, or as measured in the URDF."""
    value = settings.number(key, None, above=0.0)
    if value is not None:
        return value
    try:
        return measure()
    except ControllerError as error:
        raise ControllerError(f"{settings.label} has no {key}, and {error}") from None


def distance_between(description: ModelDescription | None, first: str, second: str) -> float:
    """Distance [m] between the origins of two joints.

    Raises:
        ControllerError: there is no such joint, or they are at the same position.
    """
    a, b = joint_origin(description, first), joint_origin(description, second)
    distance = sum((p - q) ** 2 for p, q in zip(a, b)) ** 0.5
    if not distance > 0:
        raise ControllerError(f"joints '{first}' and '{second}' are at the same position")
    return distance
