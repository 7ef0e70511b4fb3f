"""The action of a gripper's controller."""

import rospy
from bullet_sim.controllers.gripper import GripperGoal, check_goal
from bullet_sim.errors import ControllerError, SimError
from control_msgs.msg import GripperCommandAction, GripperCommandResult

from bullet_bridge.control.action_topics import Pursuit
from bullet_bridge.control.topics import Topics


class Gripper(Pursuit, Topics):
    """control_msgs/GripperCommand as action gripper_cmd."""

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._serve("gripper_cmd", GripperCommandAction)

    def _on_goal(self, handle):
        command, name = handle.get_goal().command, handle.get_goal_id().id
        goal = GripperGoal(
            command.position,
            command.max_effort,
            lambda outcome, grip: self._finish(handle, outcome, GripperCommandResult(**vars(grip))),
        )
        try:
            self._robot.call(lambda: self._pursue(handle, name, goal))
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s: goal is rejected: %s", self.name, error)
            handle.set_rejected(GripperCommandResult(), str(error))

    def _pursue(self, handle, name, goal):
        """Check and accept a goal (simulation thread)."""
        self._check_running()
        fault = check_goal(goal.position, goal.max_effort)
        if fault:
            raise ControllerError(fault)
        self.controller.pursue(goal)
        self._accept(handle, name, goal)
