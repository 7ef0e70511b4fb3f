"""Configuration of joint_trajectory_controller."""

from dataclasses import dataclass

from bullet_sim.controllers.actions.tolerances import Tolerance, Tolerances
from bullet_sim.controllers.pid import parse_pid
from bullet_sim.errors import ControllerError


@dataclass(frozen=True)
class TrajectoryConfig:
    """What a trajectory controller needs beside its joints and gains.

    Attributes:
        tolerances: Tolerances of goals that give none.
        stop_duration: time in which a cancelled trajectory comes to rest [s]; 0: at once.
        monitor_rate: of the action's feedback and result [Hz].
        partial: trajectories may leave joints out.
        feedforward: of each joint's velocity.
    """

    tolerances: Tolerances
    stop_duration: float = 0.0
    monitor_rate: float = 20.0
    partial: bool = False
    feedforward: tuple[float, ...] = ()


def parse_trajectory(settings, joints, regulated, warnings):
    """Configuration of a joint_trajectory_controller.

    Args:
        settings: Settings of the entry.
        joints: names of its joints.
        regulated: whether its interface needs gains.
        warnings: list for sentences about ignored keys.

    Returns:
        TrajectoryConfig, a PidGains a joint (none without need), state_publish_rate [Hz].

    Raises:
        ControllerError: names the key, the value and what is valid.
    """
    limits = settings.block("constraints")
    stopped = limits.number("stopped_velocity_tolerance", 0.01)
    path, arrival = [], []
    for joint in joints:
        own = limits.block(joint)
        path.append(Tolerance(own.number("trajectory", 0.0)))
        arrival.append(Tolerance(own.number("goal", 0.0), stopped))
    tolerances = Tolerances(tuple(path), tuple(arrival), limits.number("goal_time", 0.0))
    ahead = settings.block("velocity_ff")
    config = TrajectoryConfig(
        tolerances,
        settings.number("stop_trajectory_duration", 0.0),
        settings.number("action_monitor_rate", 20.0, above=0.0),
        settings.flag("allow_partial_joints_goal", False),
        tuple(ahead.number(joint, 0.0) for joint in joints),
    )
    settings.ignore("verbose", "gains")
    gains = parse_gains(settings, joints, warnings) if regulated else ()
    return config, gains, settings.number("state_publish_rate", 50.0, above=0.0)


def parse_gains(settings, joints, warnings):
    """PidGains of each joint from `gains`.

    Raises:
        ControllerError: a joint has none.
    """
    block = settings.block("gains")
    missing = [joint for joint in joints if joint not in block]
    if missing:
        raise ControllerError(
            f"{settings.what} has no gains of {', '.join(missing)}, which its interface needs: "
            "gains/JOINT with p, i, d"
        )
    return tuple(parse_pid(block.get(joint), f"{block.what} {joint}", warnings) for joint in joints)
