"""joint_trajectory_controller: settings, and the base of controllers with an action."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from bullet_sim.controllers.base import Controller, register_variant
from bullet_sim.controllers.hardware import Hardware
from bullet_sim.controllers.pid import Pid, PidConfig, parse_pid, shortest_distance
from bullet_sim.controllers.segments import (
    GOAL_VIOLATED,
    PATH_VIOLATED,
    SUCCESSFUL,
    Command,
    Course,
    Goal,
    Motion,
    Segment,
    Tolerance,
    Tolerances,
    check,
    hold,
    join,
    motion_at,
    stop,
)
from bullet_sim.controllers.settings import REQUIRED, Settings
from bullet_sim.description.model import ModelDescription
from bullet_sim.errors import ControllerError


@dataclass(frozen=True)
class TrajectoryConfig(PidConfig):
    """Configuration of a trajectory controller.

    Attributes:
        tolerances: Tolerances of goals without their own.
        stop_duration: time in which a cancelled trajectory comes to rest [s]; 0: immediately.
        monitor_rate: of the action's feedback [Hz].
        partial: trajectories may leave joints out.
        feedforward: of each joint's velocity.
    """

    tolerances: Tolerances = REQUIRED
    stop_duration: float = 0.0
    monitor_rate: float = 20.0
    partial: bool = False
    feedforward: tuple[float, ...] = ()


class ActionControl(Controller):
    """Base of controllers that execute the goals of an action, one at a time.

    Attributes:
        goal: that is executed, or None.
        no_result: what its finished() gets after the outcome where there is nothing to report.
    """

    STATE: ClassVar[tuple[str, ...]] = ("goal",)
    periodic = True
    goal: Any = None
    no_result: ClassVar[tuple[Any, ...]]

    @classmethod
    def pid_settings(
        cls, settings: Settings, joints: Sequence[str], warnings: list[str]
    ) -> dict[str, Any]:
        """Values of a PidConfig: the `gains` of each joint; none of position controllers.

        Raises:
            ControllerError: a joint has none, or bad ones.
        """
        settings.ignore("gains")
        if cls.interface == "position":
            return {}
        block = settings.block("gains")
        missing = [joint for joint in joints if joint not in block]
        if missing:
            raise ControllerError(
                f"{settings.label} has no gains of {', '.join(missing)}, which its interface "
                "needs: gains/JOINT with p, i, d"
            )
        gains = (parse_pid(block.get(name), f"{block.label} {name}", warnings) for name in joints)
        return {"gains": tuple(gains), "gain_names": tuple(f"gains/{name}" for name in joints)}

    def stop(self) -> None:
        """Cancel the goal and stop controlling."""
        self._finish("canceled")
        super().stop()

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore; a goal that is not the restored one is cancelled.

        A restored one that has finished since cannot be reported: the motion continues without it.
        """
        present = self.goal
        super().set_state(state)
        if present is not self.goal:
            self.goal = present
            self._finish("canceled")

    def _finish(self, outcome: str, *result: Any) -> None:
        goal, self.goal = self.goal, None
        if goal is not None:
            goal.finished(outcome, *(result or self.no_result))


class TrajectoryControl(ActionControl):
    """Follows the trajectory of the last command or goal; without one it holds the joints.

    Attributes:
        goal: a Goal.
        desired, actual, error: Motions of the last update, at its `time` [s]; None before it.
        clock: function -> ROS time [s], for commands with a stamp.
    """

    STATE = ("desired", "actual", "error", "time", "_next", "_segments", "pids")
    group = True
    no_result = (SUCCESSFUL, "")

    @classmethod
    def configure(
        cls, settings: Settings, joints: tuple[str, ...], description: ModelDescription | None
    ) -> TrajectoryConfig:
        names = settings.joints("joints", joints)
        warnings: list[str] = []
        limits = settings.block("constraints")
        stopped = limits.number("stopped_velocity_tolerance", 0.01)
        path, arrival = [], []
        for name in names:
            own = limits.block(name)
            path.append(Tolerance(own.number("trajectory", 0.0)))
            arrival.append(Tolerance(own.number("goal", 0.0), stopped))
        ahead = settings.block("velocity_ff")
        settings.ignore("verbose")
        return TrajectoryConfig(
            name=settings.name,
            joints=names,
            claims=((cls.interface, names),),
            publish_rate=settings.number("state_publish_rate", 50.0, above=0.0),
            **cls.pid_settings(settings, names, warnings),
            tolerances=Tolerances(tuple(path), tuple(arrival), limits.number("goal_time", 0.0)),
            stop_duration=settings.number("stop_trajectory_duration", 0.0),
            monitor_rate=settings.number("action_monitor_rate", 20.0, above=0.0),
            partial=settings.flag("allow_partial_joints_goal", False),
            feedforward=tuple(ahead.number(name, 0.0) for name in names),
            warnings=tuple(warnings),
        )

    def __init__(self, config: TrajectoryConfig, hardware: Hardware) -> None:
        super().__init__(config, hardware)
        self.pids = tuple(map(Pid, config.gains))
        self._continuous = [joint.limits.kind == "continuous" for joint in self.joints]
        self._prismatic = [joint.limits.kind == "prismatic" for joint in self.joints]
        self.clock: Callable[[], float] = lambda: 0.0
        self.desired: Motion | None = None
        self.actual: Motion | None = None
        self.error: Motion | None = None
        self.time = self._next = 0.0
        self._segments: list[Course] = []

    # life cycle -------------------------------------------------------------------------------
    def start(self, time: float) -> None:
        """Hold the joints where they are."""
        self._finish("canceled")
        self.desired = self.actual = self.error = None
        self._next = self.time = time
        positions = [joint.position for joint in self.joints]
        self._segments = hold(positions, time)
        for pid in self.pids:
            pid.reset()
        values = positions if self.interface == "position" else [0.0] * len(positions)
        self.write(values)

    # commands ---------------------------------------------------------------------------------
    def check(self, command: Command) -> Command:
        """Check a Command; returns it. One without points stops, whatever joints it names."""
        if command.points:
            check(command, self.config.joints, self.config.partial)
        return command

    def command(self, command: Command) -> None:
        """Follow a checked Command; a goal is cancelled.

        Raises:
            CommandError: it lies in the past.
        """
        self._follow(command, None)
        self._finish("canceled")

    def execute(self, command: Command, goal: Goal) -> None:
        """Follow a Command for a Goal; the one before is cancelled.

        Raises:
            CommandError: it cannot be followed; a JointsError where its joints are wrong.
        """
        check(command, self.config.joints, self.config.partial)
        self._follow(command, goal)
        self._finish("canceled")
        self.goal = goal

    def cancel(self, goal: Goal) -> None:
        """Give a goal up and come to rest."""
        if goal is self.goal:
            self.goal = None
            self._rest(None)
            goal.finished("canceled", *self.no_result)

    def _follow(self, command: Command, goal: Goal | None) -> None:
        if not command.points:
            self._rest(goal)
            return
        tolerances = None
        if goal is not None:
            tolerances = self.config.tolerances.updated(
                self.config.joints, goal.path, goal.arrival, goal.goal_time_tolerance
            )
        self._segments = join(
            self._segments,
            command,
            self.config.joints,
            self._next,
            command.stamp - self.clock() if command.stamp else 0.0,
            self._continuous,
            goal,
            tolerances,
        )

    def _rest(self, goal: Goal | None) -> None:
        """Stop: where the joints are, or within the time that is configured."""
        duration, desired = self.config.stop_duration, self.desired
        if duration > 0.0 and desired is not None:
            self._segments = stop(desired.positions, desired.velocities, self._next, duration, goal)
        else:
            self.hardware.read()
            positions = [joint.position for joint in self.joints]
            self._segments = hold(positions, self._next, goal)

    def planned(self, time: float) -> Motion:
        """Motion that is planned for a ROS time [s].

        Raises:
            ControllerError: the trajectory starts later.
        """
        time = self._next + time - self.clock()
        if any(time < course[0].start for course in self._segments):
            raise ControllerError(
                "Requested sample time precedes trajectory start time. It is one of controller "
                f"'{self.config.name}'"
            )
        return motion_at([course.active(time) for course in self._segments], time)

    # every period -----------------------------------------------------------------------------
    def update(self, time: float, period: float) -> None:
        """Compare with the trajectory, evaluate the goal, command the joints."""
        self.time, self._next = time, time + period
        segments = [course.active(time) for course in self._segments]
        self.desired = desired = motion_at(segments, time)
        self.actual = actual = Motion(
            [joint.position for joint in self.joints], [joint.velocity for joint in self.joints]
        )
        self.error = error = Motion(
            [
                target - now if along else shortest_distance(now, target)
                for now, target, along in zip(actual.positions, desired.positions, self._prismatic)
            ],
            [w - v for w, v in zip(desired.velocities, actual.velocities)],
        )
        since = segments[0].from_start
        desired.from_start = since
        actual.from_start = time - segments[0].start + since
        error.from_start = since - actual.from_start
        if self.goal is not None:
            self._evaluate(self.goal, error, segments, time)
        self._write(desired, error, period)

    def _evaluate(
        self, goal: Goal, motion_error: Motion, segments: Sequence[Segment], time: float
    ) -> None:
        """Finish the goal if it is reached or a tolerance violated."""
        for index, (name, segment) in enumerate(zip(self.config.joints, segments)):
            error = motion_error.positions[index]
            errors = error, motion_error.velocities[index]
            if segment.goal is not goal:
                continue
            if time < segment.end:
                if not segment.path.holds(*errors):
                    self._finish("aborted", PATH_VIOLATED, f"{name} path error {error:f}")
                    return
            elif segment is self._segments[index][-1]:
                if segment.arrival.holds(*errors):
                    goal.arrived.add(name)
                elif time >= segment.end + segment.goal_time_tolerance:
                    self._finish("aborted", GOAL_VIOLATED, f"{name} goal error {error:f}")
                    return
        if len(goal.arrived) == len(self.config.joints):
            self._finish("succeeded")

    def _write(self, desired: Motion, error: Motion, period: float) -> None:
        if self.interface == "position":
            self.write(desired.positions)
            return
        outputs = [
            pid.update(deviation, period, rate) + gain * velocity
            for pid, deviation, rate, velocity, gain in zip(
                self.pids,
                error.positions,
                error.velocities,
                desired.velocities,
                self.config.feedforward,
            )
        ]
        self.write(outputs)


for _interface in ("position", "velocity", "effort"):
    register_variant(
        f"{_interface}_controllers/JointTrajectoryController",
        TrajectoryControl,
        interface=_interface,
    )
