"""Topics of a trajectory controller: commands, state, the action, and the planned state."""

import rospy
from bullet_sim.controllers.trajectory import Command, Goal, JointsError, Point, Tolerance
from bullet_sim.errors import SimError
from control_msgs.msg import (
    FollowJointTrajectoryAction,
    FollowJointTrajectoryFeedback,
    FollowJointTrajectoryResult,
    JointTrajectoryControllerState,
)
from control_msgs.srv import QueryTrajectoryState, QueryTrajectoryStateResponse
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from bullet_bridge.control.action_topics import Pursuit
from bullet_bridge.control.topics import Commands
from bullet_bridge.transport.conversions import stamp


def command_of(message):
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


def tolerances_of(messages):
    """(joint name, Tolerance) pairs of control_msgs/JointTolerance messages."""
    return tuple((m.name, Tolerance(m.position, m.velocity, m.acceleration)) for m in messages)


def _point(motion):
    return JointTrajectoryPoint(
        positions=list(motion.positions),
        velocities=list(motion.velocities),
        accelerations=list(motion.accelerations),
        time_from_start=rospy.Duration.from_sec(motion.from_start),
    )


class Trajectories(Pursuit, Commands):
    """trajectory_msgs/JointTrajectory on command, control_msgs/FollowJointTrajectory as action."""

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self.controller.clock = lambda: robot.world.time
        self._state = self._publisher(f"{self.name}/state", JointTrajectoryControllerState)
        self._state_schedule = self._every(spec.publish_rate, self._state)
        self._serve("follow_joint_trajectory", FollowJointTrajectoryAction)
        self._feedback_schedule = self._every_while(
            spec.action.monitor_rate,
            lambda: self._handle is not None and self._action.has_subscribers(),
        )
        self._query = rospy.Service(f"{self.name}/query_state", QueryTrajectoryState, self._planned)

    def _kind(self):
        return JointTrajectory

    def _on_command(self, message):
        self._robot.buffer_command(self._spec.name, command_of(message))

    # the action -------------------------------------------------------------------------------
    def _on_goal(self, handle):
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
            self._robot.call(
                lambda: self._pursue(handle, name, command_of(message.trajectory), goal)
            )
        except (SimError, TimeoutError) as error:
            wrong = isinstance(error, JointsError)
            result.error_code = result.INVALID_JOINTS if wrong else result.INVALID_GOAL
            result.error_string = str(error)
            rospy.logerr("%s: goal is rejected: %s", self.name, error)
            handle.set_rejected(result, str(error))

    def _pursue(self, handle, name, command, goal):
        """Check and accept a goal (simulation thread)."""
        self._check_running()
        self.controller.pursue(command, goal)
        self._accept(handle, name, goal)

    # what is published ------------------------------------------------------------------------
    def _planned(self, request):
        try:
            motion = self._robot.call(lambda: self._motion_at(request.time.to_sec()))
        except (SimError, TimeoutError) as error:
            raise rospy.ServiceException(str(error)) from None
        return QueryTrajectoryStateResponse(
            name=list(self._spec.joints),
            position=motion.positions,
            velocity=motion.velocities,
            acceleration=motion.accelerations,
        )

    def _motion_at(self, time):
        self._check_running()
        return self.controller.planned(time)

    def publish(self, step, time):
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
            self._action.say(
                self._handle.publish_feedback, self._filled(FollowJointTrajectoryFeedback(), time)
            )

    def _filled(self, message, time):
        message.header.stamp, message.joint_names = stamp(time), list(self._spec.joints)
        for name in ("desired", "actual", "error"):
            setattr(message, name, _point(getattr(self.controller, name)))
        return message

    def close(self):
        """Unregister the topics and the service."""
        self._query.shutdown("the controller is gone")
        super().close()
