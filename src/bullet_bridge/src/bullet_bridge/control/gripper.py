"""The action of a gripper's controller."""

import rospy
from bullet_sim.controllers.actions.gripper import GripperGoal, check_goal
from bullet_sim.errors import ControllerError, SimError
from control_msgs.msg import GripperCommandAction, GripperCommandResult

from bullet_bridge.control.action_topics import ActionTopics
from bullet_bridge.control.topics import Topics


class Gripper(Topics):
    """control_msgs/GripperCommand as action gripper_cmd."""

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._handle = self._goal = None  # of the goal that is pursued
        self._id = None  # asked of a handle, it would wait for the server's lock
        self._action = ActionTopics(
            f"{self.name}/gripper_cmd", GripperCommandAction, self._on_goal, self._on_cancel
        )
        self._endpoints.append(self._action)

    def _on_goal(self, handle):
        command, name = handle.get_goal().command, handle.get_goal_id().id
        goal = GripperGoal(
            command.position,
            command.max_effort,
            lambda outcome, grip: self._finished(handle, outcome, grip),
        )
        try:
            self._robot.call(lambda: self._pursue(handle, name, goal))
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s: goal is rejected: %s", self.name, error)
            handle.set_rejected(GripperCommandResult(), str(error))

    def _pursue(self, handle, name, goal):
        """Accept a goal (simulation thread, while the server waits for it)."""
        fault = check_goal(goal.position, goal.max_effort)
        if not self._robot.manager.is_running(self._spec.name):
            fault = f"controller '{self._spec.name}' does not run"
        if fault:
            raise ControllerError(fault)
        self.controller.pursue(goal)
        self._handle, self._goal, self._id = handle, goal, name
        self._action.say(handle.set_accepted)

    def _on_cancel(self, handle):
        name = handle.get_goal_id().id
        try:
            self._robot.call(lambda: self._cancel(name))
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s: goal cannot be cancelled: %s", self.name, error)

    def _cancel(self, name):
        if name == self._id:
            self.controller.cancel(self._goal)

    def _finished(self, handle, outcome, grip):
        """Report the end of a goal (simulation thread)."""
        if handle is self._handle:
            self._handle = self._goal = self._id = None
        finish = {
            "succeeded": handle.set_succeeded,
            "aborted": handle.set_aborted,
            "canceled": handle.set_canceled,
        }[outcome]
        self._action.say(finish, GripperCommandResult(**vars(grip)))
