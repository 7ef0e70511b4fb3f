"""Configuration of diff_drive_controller and ackermann_steering_controller."""

from dataclasses import dataclass

from bullet_sim.controllers.drive.geometry import joint_position, wheel_radius
from bullet_sim.controllers.drive.speed_limiter import SpeedLimiter, parse_limiter
from bullet_sim.controllers.settings import as_number
from bullet_sim.errors import ControllerError

_WITHOUT_EFFECT = (
    "publish_wheel_joint_controller_state",
    "preserve_turning_radius",
    "publish_joint_trajectory_controller_state",
)


@dataclass(frozen=True, kw_only=True)
class BaseConfig:
    """Configuration that all kinds of bases share.

    Attributes:
        linear, angular: SpeedLimiters of the command.
        timeout: age [s] at which a command counts as 0.
        open_loop: odometry from the commands instead of from the joints.
        window: periods over which the odometry's velocity is averaged.
        base_frame, odom_frame: frame names.
        publish_tf: odometry also as a transform.
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
    """

    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    radii: tuple[float, float]
    steer_multiplier: float = 1.0


def common(settings):
    """Values of a BaseConfig, and notes about keys without effect."""
    values = {
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
    notes = tuple(
        f"{settings.what}: {key} has no effect here" for key in settings.ignore(*_WITHOUT_EFFECT)
    )
    return values, notes


def _diagonal(settings, key):
    value = settings.get(key, [0.0] * 6)
    numbers = [as_number(v) for v in value] if isinstance(value, list) else []
    if len(numbers) != 6 or any(number is None or number < 0 for number in numbers):
        raise ControllerError(
            f"{settings.what} has {key} {value!r}, must be six numbers, none below 0"
        )
    return tuple(numbers)


def wheel_names(settings, key):
    """Joint names: a list, or one name alone."""
    value = settings.get(key)
    names = value if isinstance(value, list) else [value]
    if not names or not all(isinstance(name, str) and name for name in names):
        raise ControllerError(
            f"{settings.what} has {key} {value!r}, must be a joint name or a list of them"
        )
    return tuple(names)


def size(settings, key, measure):
    """A length [m] from the settings, or as measured in the URDF."""
    value = settings.number(key, None, above=0.0)
    if value is not None:
        return value
    try:
        return measure()
    except ControllerError as error:
        raise ControllerError(f"{settings.what} has no {key}, and {error}") from None


def parse_diff(settings, description):
    """Configuration of a diff_drive_controller.

    Args:
        settings: Settings of the entry.
        description: ModelDescription or None.

    Returns:
        DriveConfig, claims as (interface, joint names) pairs, notes.

    Raises:
        ControllerError: names the key, the value and what is valid.
    """
    left, right = wheel_names(settings, "left_wheel"), wheel_names(settings, "right_wheel")
    if len(left) != len(right):
        raise ControllerError(
            f"{settings.what} has {len(left)} left and {len(right)} right wheels, must be as many"
        )
    both = settings.number("wheel_radius_multiplier", 1.0, above=0.0)
    radius = size(settings, "wheel_radius", lambda: wheel_radius(description, left[0]))
    separation = size(
        settings, "wheel_separation", lambda: _distance(description, left[0], right[0])
    )
    values, notes = common(settings)
    drive = DriveConfig(
        left,
        right,
        separation * settings.number("wheel_separation_multiplier", 1.0, above=0.0),
        tuple(
            radius * settings.number(f"{side}_wheel_radius_multiplier", both, above=0.0)
            for side in ("left", "right")
        ),
        **values,
    )
    return drive, (("velocity", left + right),), notes


def parse_ackermann(settings, description):
    """Configuration of an ackermann_steering_controller; see parse_diff."""
    rear = settings.text("rear_wheel", "rear_wheel_joint")
    front = settings.text("front_steer", "front_steer_joint")
    radius = size(settings, "wheel_radius", lambda: wheel_radius(description, rear))
    separation = size(
        settings,
        "wheel_separation_h",
        lambda: abs(joint_position(description, front)[0] - joint_position(description, rear)[0]),
    )
    values, notes = common(settings)
    drive = DriveConfig(
        (rear,),
        (front,),
        separation * settings.number("wheel_separation_h_multiplier", 1.0, above=0.0),
        (radius * settings.number("wheel_radius_multiplier", 1.0, above=0.0), radius),
        steer_multiplier=settings.number("steer_pos_multiplier", 1.0),
        **values,
    )
    if not drive.separation > 0:
        raise ControllerError(
            f"{settings.what} has wheel_separation_h {separation}, must be above 0 [m]"
        )
    return drive, (("velocity", (rear,)), ("position", (front,))), notes


def _distance(description, first, second):
    a, b = joint_position(description, first), joint_position(description, second)
    distance = sum((p - q) ** 2 for p, q in zip(a, b)) ** 0.5
    if not distance > 0:
        raise ControllerError(f"joints '{first}' and '{second}' are at the same place")
    return distance
