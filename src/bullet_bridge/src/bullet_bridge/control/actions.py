"""Actions of controllers: follow_joint_trajectory and gripper_cmd.

Action servers of controllers. actionlib's server holds a lock while it calls back, and a callback
waits for the simulation thread. So that thread never calls the server: its calls go
through a queue to a thread that makes them.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable
from typing import Any

import actionlib
import rospy
from bullet_sim.controllers.gripper import GripperControl, GripperGoal, check_goal
from bullet_sim.controllers.segments import Command, Goal, JointsError, Motion, Point, Tolerance
from bullet_sim.controllers.trajectory import TrajectoryControl
from bullet_sim.errors import ControllerError, SimError
from control_msgs.msg import (
    FollowJointTrajectoryAction,
    FollowJointTrajectoryFeedback,
    FollowJointTrajectoryResult,
    GripperCommandAction,
    GripperCommandResult,
    JointTrajectoryControllerState,
)
from control_msgs.srv import QueryTrajectoryState, QueryTrajectoryStateResponse
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from bullet_bridge.control.topics import Commands, Topics, ros_side
from bullet_bridge.transport.conversions import stamp

STATUS_PERIOD = 0.2  # [s] of wall time, as actionlib's without its parameter


class _Server(actionlib.ActionServer):
    """A server without actionlib's timer, whose thread exits when simulated time jumps back."""

    def initialize(self) -> None:
        super().initialize()
        if self.status_timer is not None:
            self.status_timer.shutdown()


class NotRunning(ControllerError):
    """What only a running controller does."""


NO_GOALS = "Can't accept new action goals. Controller is not running."  # as upstream


class GoalTopics(Topics):
    """Topics with an action, and the goal that the controller executes."""

    def _serve(self, name: str, action: type) -> None:
        """Start the action of a name in the controller's namespace; _on_goal gets its goals."""
        self._handle: Any = None  # of the active goal
        self._goal: Any = None
        self._id: str | None = None  # reading it from a handle would wait for the server's lock
        self._action_name = f"{self.name}/{name}"
        self._action = ActionTopics(self._action_name, action, self._on_goal, self._on_cancel)
        self._endpoints.append(self._action)

    def topics_received(self) -> set[str]:
        """With that of its goals."""
        return {*super().topics_received(), rospy.resolve_name(f"{self._action_name}/goal")}

    def _on_goal(self, handle: Any) -> None:
        """Accept or reject the goal of an actionlib.ServerGoalHandle."""
        raise NotImplementedError

    def _check_running(self, otherwise: str) -> None:
        """Raise a NotRunning with a text if the controller does not run."""
        if not self._robot.manager.is_running(self.config.name):
            raise NotRunning(otherwise)

    def _accept(self, handle: Any, name: str, goal: Any) -> None:
        """Accept a goal (simulation thread, while the server waits for it)."""
        self._handle, self._goal, self._id = handle, goal, name
        self._action.post(handle.set_accepted)

    def _on_cancel(self, handle: Any) -> None:
        name = handle.get_goal_id().id
        try:
            self._robot.call(lambda: self._cancel(name))
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s: goal cannot be cancelled: %s", self.name, error)

    def _cancel(self, name: str) -> None:
        if name == self._id:
            self.controller.cancel(self._goal)

    def _finish(self, handle: Any, outcome: str, result: Any) -> None:
        """Report the end of a goal (simulation thread)."""
        if handle is self._handle:
            self._handle = self._goal = self._id = None
        finish = {
            "succeeded": handle.set_succeeded,
            "aborted": handle.set_aborted,
            "canceled": handle.set_canceled,
        }[outcome]
        self._action.post(finish, result)


class ActionTopics:
    """The topics of one action.

    Args:
        name: of the action, resolved.
        on_goal: function of a ServerGoalHandle, which accepts or rejects it.
        on_cancel: function of a ServerGoalHandle.
    """

    def __init__(
        self,
        name: str,
        action: type,
        on_goal: Callable[[Any], None],
        on_cancel: Callable[[Any], None],
    ) -> None:
        self._calls: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._server = _Server(name, action, on_goal, on_cancel, auto_start=False)
        self._server.start()
        self._thread = threading.Thread(target=self._work, name=f"{name} results", daemon=True)
        self._thread.start()

    def has_subscribers(self) -> bool:
        """Whether feedback has subscribers."""
        return self._server.feedback_pub.get_num_connections() > 0

    def post(self, call: Callable[..., Any], *arguments: Any) -> None:
        """Have a method of a goal handle called soon, in order; does not block."""
        self._calls.put((call, arguments))

    def _work(self) -> None:
        while True:
            try:
                entry = self._calls.get(timeout=STATUS_PERIOD)
            except queue.Empty:
                entry = self._server.publish_status_async, (None,)
            if entry is None:
                return
            call, arguments = entry
            try:
                call(*arguments)
            except rospy.ROSException:
                pass  # the topics were just unregistered

    def unregister(self) -> None:
        """Make the queued calls, then close the topics."""
        self._calls.put(None)
        if threading.current_thread() is not self._thread:
            self._thread.join(2.0)
        self._server.stop()


def command_of(message: JointTrajectory) -> Command:
    """Command of a trajectory_msgs/JointTrajectory."""
    points = tuple(
        Point(
            point.time_from_start.to_sec(),
            tuple(point.positions),
            tuple(point.velocities),
            tuple(point.accelerations),
        )
        for point in message.points
    )
    return Command(tuple(message.joint_names), points, message.header.stamp.to_sec())


def tolerances_of(messages: Iterable[Any]) -> tuple[tuple[str, Tolerance], ...]:
    """(joint name, Tolerance) pairs of control_msgs/JointTolerance messages."""
    return tuple((m.name, Tolerance(m.position, m.velocity, m.acceleration)) for m in messages)


def _point(motion: Motion) -> JointTrajectoryPoint:
    return JointTrajectoryPoint(
        positions=list(motion.positions),
        velocities=list(motion.velocities),
        accelerations=list(motion.accelerations),
        time_from_start=rospy.Duration.from_sec(motion.from_start),
    )


@ros_side(TrajectoryControl)
class Trajectories(GoalTopics, Commands):
    """trajectory_msgs/JointTrajectory on command, control_msgs/FollowJointTrajectory as action."""

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        controller.clock = lambda: robot.world.time
        self._state = self.publisher(f"{self.name}/state", JointTrajectoryControllerState)
        self._state_schedule = self._every_published(self.config.publish_rate, self._state)
        self._serve("follow_joint_trajectory", FollowJointTrajectoryAction)
        self._feedback_schedule = self._every_while(
            self.config.monitor_rate,
            lambda: self._handle is not None and self._action.has_subscribers(),
        )
        self._query = rospy.Service(f"{self.name}/query_state", QueryTrajectoryState, self._planned)

    def _message_type(self) -> type:
        return JointTrajectory

    def _on_command(self, message: Any) -> None:
        if not self._robot.manager.is_running(self.config.name):
            rospy.logerr("Can't accept new commands. Controller is not running.")
            return
        self._robot.commands[self.config.name] = command_of(message)

    # the action -------------------------------------------------------------------------------
    def _on_goal(self, handle: Any) -> None:
        message, result = handle.get_goal(), FollowJointTrajectoryResult()
        name = handle.get_goal_id().id
        goal = Goal(
            lambda outcome, code, text: self._finish(
                handle,
                outcome,
                FollowJointTrajectoryResult(error_code=code, error_string=text),
            ),
            tolerances_of(message.path_tolerance),
            tolerances_of(message.goal_tolerance),
            message.goal_time_tolerance.to_sec(),
        )
        try:
            command = command_of(message.trajectory)
            self._robot.call(lambda: self._execute(handle, name, command, goal))
        except (SimError, TimeoutError) as error:
            text, result.error_code = str(error), result.INVALID_GOAL
            if isinstance(error, JointsError):
                text = f"Joints on incoming goal don't match the controller joints. {error}"
                result.error_code = result.INVALID_JOINTS
            elif not isinstance(error, NotRunning):
                result.error_string = text  # of the other two upstream has none
            rospy.logerr("%s", text)
            handle.set_rejected(result)

    def _execute(self, handle: Any, name: str, command: Command, goal: Goal) -> None:
        """Check and accept a goal (simulation thread)."""
        self._check_running(NO_GOALS)
        self.controller.execute(command, goal)
        self._accept(handle, name, goal)

    # published topics ------------------------------------------------------------------------
    def _planned(self, request: Any) -> QueryTrajectoryStateResponse:
        try:
            motion = self._robot.call(lambda: self._motion_at(request.time.to_sec()))
        except (SimError, TimeoutError) as error:
            raise rospy.ServiceException(str(error)) from None
        return QueryTrajectoryStateResponse(
            name=list(self.config.joints),
            position=motion.positions,
            velocity=motion.velocities,
            acceleration=motion.accelerations,
        )

    def _motion_at(self, time: float) -> Motion:
        self._check_running("Can't sample trajectory. Controller is not running.")
        return self.controller.planned(time)

    def publish(self, step: int, time: float) -> None:
        """Publish the last update, stamped with its time, as state and as feedback."""
        controller = self.controller
        state_due, feedback_due = (
            schedule.due(step) for schedule in (self._state_schedule, self._feedback_schedule)
        )
        if controller.desired is None or not (state_due or feedback_due):
            return
        time -= self._robot.manager.time - controller.time
        if state_due:
            self._state.publish(self._filled(JointTrajectoryControllerState(), time))
        if feedback_due and self._handle is not None:
            self._action.post(
                self._handle.publish_feedback, self._filled(FollowJointTrajectoryFeedback(), time)
            )

    def _filled(self, message: Any, time: float) -> Any:
        message.header.stamp, message.joint_names = stamp(time), list(self.config.joints)
        for name in ("desired", "actual", "error"):
            setattr(message, name, _point(getattr(self.controller, name)))
        return message

    def close(self) -> None:
        """Unregister the topics and the service."""
        self._query.shutdown("the controller is unloaded")
        super().close()


@ros_side(GripperControl)
class Gripper(GoalTopics):
    """control_msgs/GripperCommand as action gripper_cmd."""

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        self._serve("gripper_cmd", GripperCommandAction)

    def _on_goal(self, handle: Any) -> None:
        command, name = handle.get_goal().command, handle.get_goal_id().id
        goal = GripperGoal(
            command.position,
            command.max_effort,
            lambda outcome, grip: self._finish(handle, outcome, GripperCommandResult(**vars(grip))),
        )
        try:
            self._robot.call(lambda: self._execute(handle, name, goal))
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s", error)
            handle.set_rejected(GripperCommandResult())

    def _execute(self, handle: Any, name: str, goal: GripperGoal) -> None:
        """Check and accept a goal (simulation thread)."""
        self._check_running(NO_GOALS)
        problem = check_goal(goal.position, goal.max_effort)
        if problem:
            raise ControllerError(problem)
        self.controller.execute(goal)
        self._accept(handle, name, goal)
