"""Follows trajectories of several joints, as joint_trajectory_controller does."""

from dataclasses import dataclass, field

from bullet_sim.controllers.actions import plan
from bullet_sim.controllers.actions.spline import active
from bullet_sim.controllers.angles import shortest_distance
from bullet_sim.controllers.joint_control import Controller
from bullet_sim.controllers.pid import Pid
from bullet_sim.errors import ControllerError

SUCCESSFUL, PATH_VIOLATED, GOAL_VIOLATED = 0, -4, -5  # of control_msgs/FollowJointTrajectoryResult


@dataclass(eq=False)
class Goal:
    """A goal of the action.

    Attributes:
        path, arrival: (joint name, Tolerance) pairs that differ from the configuration.
        patience: goal_time_tolerance [s].
        finished: called once with (outcome, code, text): "succeeded", "aborted" or "canceled".
        arrived: joints that were within their tolerance at the end.
    """

    finished: object
    path: tuple = ()
    arrival: tuple = ()
    patience: float = 0.0
    arrived: set = field(default_factory=set)


@dataclass
class Motion:
    """Positions, velocities, accelerations of all joints, and the time since a segment's start."""

    positions: list
    velocities: list
    accelerations: list = ()
    from_start: float = 0.0


class TrajectoryControl(Controller):
    """Follows the trajectory of the last command or goal; without one it holds the joints.

    Attributes:
        goal: the Goal that is followed, or None.
        desired, actual, error: Motions of the last update, at its `time` [s]; None before it.
        clock: function -> ROS time [s], for commands with a stamp.
        pids: one Pid a joint, where the interface needs them.
    """

    periodic = True

    def __init__(self, spec, hardware):
        super().__init__(spec, hardware)
        self.pids = tuple(Pid(gains) for gains in spec.gains)
        self._continuous = [hardware.limits[name].kind == "continuous" for name in spec.joints]
        self._prismatic = [hardware.limits[name].kind == "prismatic" for name in spec.joints]
        self.clock = lambda: 0.0
        self.goal = self.desired = self.actual = self.error = None
        self.time = 0.0

    # life cycle -------------------------------------------------------------------------------
    def start(self, time):
        """Hold the joints where they are."""
        self._finish("canceled")
        self.desired = self.actual = self.error = None
        self._next = self.time = time
        positions = self.hardware.positions_of(self.spec.joints)
        self._segments = plan.hold(positions, time)
        for pid in self.pids:
            pid.reset()
        if self.spec.kind.interface == "position":
            self.hardware.positions(self.spec.joints, positions)
        else:
            self._write_direct((0.0,) * len(positions))

    def stop(self):
        """Cancel the goal and stop controlling."""
        self._finish("canceled")
        super().stop()

    def _finish(self, outcome, code=SUCCESSFUL, text=""):
        goal, self.goal = self.goal, None
        if goal is not None:
            goal.finished(outcome, code, text)

    # commands ---------------------------------------------------------------------------------
    def check(self, command):
        """Check a plan.Command; returns it."""
        plan.check(command, self.spec.joints, self.spec.action.partial)
        return command

    def command(self, command):
        """Follow a checked plan.Command; a goal is cancelled.

        Raises:
            CommandError: it lies in the past.
        """
        self._follow(command, None)
        self._finish("canceled")

    def pursue(self, command, goal):
        """Follow a plan.Command for a Goal; the one before is cancelled.

        Raises:
            CommandError: it cannot be followed; a JointsError where its joints are wrong.
        """
        self.check(command)
        self._follow(command, goal)
        self._finish("canceled")
        self.goal = goal

    def cancel(self, goal):
        """Give a goal up and come to rest."""
        if goal is self.goal:
            self.goal = None
            self._rest(None)
            goal.finished("canceled", SUCCESSFUL, "")

    def _follow(self, command, goal):
        if not command.points:
            self._rest(goal)
            return
        tolerances = goal and self.spec.action.tolerances.updated(
            self.spec.joints, goal.path, goal.arrival, goal.patience
        )
        self._segments = plan.join(
            self._segments,
            command,
            self.spec.joints,
            self._next,
            command.stamp - self.clock() if command.stamp else 0.0,
            self._continuous,
            goal,
            tolerances,
        )

    def _rest(self, goal):
        """Stop: where the joints are, or within the time that is configured."""
        duration, desired = self.spec.action.stop_duration, self.desired
        if duration > 0.0 and desired is not None:
            self._segments = plan.stop(
                desired.positions, desired.velocities, self._next, duration, goal
            )
        else:
            positions = self.hardware.positions_of(self.spec.joints)
            self._segments = plan.hold(positions, self._next, goal)

    def planned(self, time):
        """Motion that is planned for a ROS time [s].

        Raises:
            ControllerError: the trajectory starts later.
        """
        time = self._next + time - self.clock()
        if any(time < segments[0].start for segments in self._segments):
            raise ControllerError(
                f"controller '{self.spec.name}' has no trajectory for a time before its start"
            )
        columns = zip(*(active(s, time).sample(time) for s in self._segments))
        return Motion(*map(list, columns))

    # every period -----------------------------------------------------------------------------
    def update(self, state, time, period):
        """Compare with the trajectory, judge the goal, command the joints."""
        self.time, self._next = time, time + period
        joints, (positions, velocities) = self.spec.joints, state
        segments = [active(of_joint, time) for of_joint in self._segments]
        self.desired = Motion(*map(list, zip(*(s.sample(time) for s in segments))))
        self.actual = Motion([positions[n] for n in joints], [velocities[n] for n in joints])
        self.error = Motion(
            [
                wanted - now if along else shortest_distance(now, wanted)
                for now, wanted, along in zip(
                    self.actual.positions, self.desired.positions, self._prismatic
                )
            ],
            [w - v for w, v in zip(self.desired.velocities, self.actual.velocities)],
        )
        since = segments[0].from_start
        self.desired.from_start = since
        self.actual.from_start = time - segments[0].start + since
        self.error.from_start = since - self.actual.from_start
        if self.goal is not None:
            self._judge(segments, time)
        self._write(period)

    def _judge(self, segments, time):
        for number, (name, segment) in enumerate(zip(self.spec.joints, segments)):
            error = self.error.positions[number]
            errors = error, self.error.velocities[number]
            if segment.goal is not self.goal:
                continue
            if time < segment.end:
                if not segment.path.holds(*errors):
                    self._finish("aborted", PATH_VIOLATED, f"{name} path error {error:f}")
                    return
            elif segment is self._segments[number][-1]:
                if segment.arrival.holds(*errors):
                    self.goal.arrived.add(name)
                elif time >= segment.end + segment.patience:
                    self._finish("aborted", GOAL_VIOLATED, f"{name} goal error {error:f}")
                    return
        if len(self.goal.arrived) == len(self.spec.joints):
            self._finish("succeeded")

    def _write(self, period):
        kind, joints = self.spec.kind.interface, self.spec.joints
        if kind == "position":
            self.hardware.positions(joints, self.desired.positions)
            return
        rows = zip(
            joints,
            self.pids,
            self.error.positions,
            self.desired.velocities,
            self.actual.velocities,
            self.spec.action.feedforward,
        )
        if kind == "velocity":
            self._write_direct(
                [
                    pid.compute(error, period, wanted - speed) + ahead * wanted
                    for _, pid, error, wanted, speed, ahead in rows
                ]
            )
            return
        for name, pid, error, wanted, speed, ahead in rows:
            self.hardware.regulate(
                name, pid, "position", error, speed, period, wanted, ahead * wanted
            )

    def _write_direct(self, values):
        write = {"velocity": self.hardware.velocities, "effort": self.hardware.efforts}
        write[self.spec.kind.interface](self.spec.joints, values)
