"""Trajectory and gripper controllers: topics, service and actions, without a ROS master."""

import threading

import pytest
import rospy
from bot_rig import LINK, Bot, held_robot, transmissions
from bullet_bridge.control import actions
from control_msgs.msg import (
    FollowJointTrajectoryGoal,
    GripperCommandGoal,
    JointTolerance,
    JointTrajectoryControllerState,
)
from control_msgs.srv import QueryTrajectoryStateRequest
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINT = (
    '<joint name="{0}" type="revolute"><origin xyz="0 0 {1}"/><parent link="base"/>'
    '<child link="{0}_link"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" '
    'velocity="9"/></joint>'
)
URDF = held_robot(
    [
        *(LINK.format(f"{n}_link") + JOINT.format(n, at) for n, at in (("a", 0), ("b", 1))),
        transmissions({"a": "Effort Position", "b": "Effort"}),
    ]
)
GAINS = {"p": 200.0, "d": 20.0}
PARAMS = {
    "/bot/arm": {
        "type": "effort_controllers/JointTrajectoryController",
        "joints": ["a", "b"],
        "gains": {"a": GAINS, "b": GAINS},
        "constraints": {"goal_time": 0.5, "a": {"goal": 0.02, "trajectory": 0.5}},
        "state_publish_rate": 100,
    },
    "/bot/hand": {"type": "position_controllers/GripperActionController", "joint": "a"},
}


class Handle:
    """A goal handle that records what becomes of it."""

    def __init__(self, goal, name="goal"):
        self.goal, self.name, self.logged, self.feedback = goal, name, [], []

    def get_goal(self):
        return self.goal

    def get_goal_id(self):
        """Its id; the real one waits for the server's lock, so the simulation must not ask."""
        assert threading.current_thread() is not threading.main_thread()
        return type("GoalID", (), {"id": self.name})

    def publish_feedback(self, feedback):
        self.feedback.append(feedback)

    def _end(self, what, *rest):
        self.logged.append((what, *rest))

    def __getattr__(self, name):
        if not name.startswith("set_"):
            raise AttributeError(name)
        return lambda *rest: self._end(name, *rest)


class Actions:
    """Stands in for ActionTopics: calls immediately."""

    made = {}

    def __init__(self, name, action, on_goal, on_cancel):
        self.name, self.action, self.on_goal, self.on_cancel = name, action, on_goal, on_cancel
        self.closed = False
        Actions.made[name] = self

    def has_subscribers(self):
        return True

    def post(self, call, *arguments):
        call(*arguments)

    def unregister(self):
        self.closed = True


@pytest.fixture(name="bot")
def _bot(monkeypatch):
    monkeypatch.setattr(actions, "ActionTopics", Actions)
    bot = Bot(monkeypatch, URDF, PARAMS)
    yield bot
    bot.world.close()


def message(*points, joints=("a", "b")):
    """A JointTrajectory of (time, positions) points."""
    return JointTrajectory(
        joint_names=list(joints),
        points=[
            JointTrajectoryPoint(positions=p, time_from_start=rospy.Duration(t)) for t, p in points
        ],
    )


def send(bot, name, goal, handle_name="goal"):
    """Send a goal to an action; its handle."""
    handle = Handle(goal, handle_name)
    bot.in_thread(lambda: Actions.made[name].on_goal(handle))
    return handle


ACTION = "/bot/arm/follow_joint_trajectory"


def test_a_command_is_followed_and_the_state_tells_it(bot):
    bot.start("arm")
    bot.endpoints["/bot/arm/command"].call(message((0.5, (0.4, 0.2))))
    bot.run(1000)
    state = bot.endpoints["/bot/arm/state"]
    assert state.kind is JointTrajectoryControllerState and len(state.messages) == 100
    half, last = state.messages[24], state.messages[-1]
    assert half.header.stamp.to_sec() == 0.249 and half.joint_names == ["a", "b"]
    assert half.desired.positions == pytest.approx((0.4 * 0.498, 0.2 * 0.498))
    assert half.desired.velocities == pytest.approx((0.8, 0.4))
    assert half.error.positions[0] == pytest.approx(
        half.desired.positions[0] - half.actual.positions[0]
    )
    assert last.actual.positions == pytest.approx((0.4, 0.2), abs=0.01)
    assert (last.desired.accelerations, len(last.actual.accelerations)) == ([0.0, 0.0], 0)


def test_a_goal_is_accepted_reported_and_succeeds(bot):
    bot.start("arm")
    goal = FollowJointTrajectoryGoal(trajectory=message((0.5, (0.4, 0.2))))
    handle = send(bot, ACTION, goal)
    assert [logged[0] for logged in handle.logged] == ["set_accepted"]
    bot.run(400)
    assert len(handle.feedback) == 8 and handle.feedback[0].joint_names == ["a", "b"]
    bot.run(600)
    assert handle.logged[-1][0] == "set_succeeded" and handle.logged[-1][1].error_code == 0
    assert len(handle.logged) == 2


def test_tolerances_of_the_goal_replace_those_of_the_configuration(bot):
    bot.start("arm")
    goal = FollowJointTrajectoryGoal(trajectory=message((0.05, (1.5, 0.2))))
    assert send(bot, ACTION, goal).logged[0][0] == "set_accepted"
    bot.run(200)
    tight = FollowJointTrajectoryGoal(
        trajectory=message((0.05, (-1.5, 0.2))),
        path_tolerance=[JointTolerance(name="a", position=1e-6)],
    )
    handle = send(bot, ACTION, tight, "tight")
    bot.run(50)
    assert handle.logged[-1][0] == "set_aborted"
    result = handle.logged[-1][1]
    assert result.error_code == -4 and result.error_string.startswith("a path error")


@pytest.mark.parametrize(
    "trajectory_message, code, words, log",
    [
        (
            message((1.0, (1.0,)), joints=("a",)),
            -2,
            "",
            "Joints on incoming goal don't match the controller joints. ",
        ),
        (
            message((1.0, (1.0, 1.0)), (0.5, (1.0, 1.0))),
            -1,
            "Trajectory message contains waypoints that are not strictly increasing in time. ",
            "Trajectory message contains waypoints that are not strictly increasing in time. ",
        ),
    ],
)
def test_goals_that_cannot_be_followed_are_rejected(bot, trajectory_message, code, words, log):
    """In upstream's words, which has none in the result where the joints are wrong."""
    bot.start("arm")
    handle = send(bot, ACTION, FollowJointTrajectoryGoal(trajectory=trajectory_message))
    ((what, result),) = handle.logged
    assert (what, result.error_code) == ("set_rejected", code)
    assert result.error_string.startswith(words) and bool(result.error_string) == bool(words)
    assert bot.log[-1].startswith(log)


def test_a_goal_of_a_stopped_controller_is_rejected_and_a_stop_cancels(bot):
    assert bot.load("arm")
    goal = FollowJointTrajectoryGoal(trajectory=message((5.0, (0.4, 0.2))))
    assert send(bot, ACTION, goal).logged[0][1].error_string == ""
    assert bot.log[-1] == "Can't accept new action goals. Controller is not running."
    bot.command("arm", message((1.0, (1.0, 1.0))))
    assert bot.log[-1] == "Can't accept new commands. Controller is not running."
    assert bot.switch(start=["arm"])
    handle = send(bot, ACTION, goal)
    bot.run(10)
    assert bot.switch(stop=["arm"])
    assert [logged[0] for logged in handle.logged] == ["set_accepted", "set_canceled"]


def test_only_the_active_goal_can_be_cancelled(bot):
    bot.start("arm")
    goal = FollowJointTrajectoryGoal(trajectory=message((5.0, (0.4, 0.2))))
    first, second = send(bot, ACTION, goal, "1"), send(bot, ACTION, goal, "2")
    assert first.logged[-1][0] == "set_canceled"
    bot.in_thread(lambda: Actions.made[ACTION].on_cancel(Handle(goal, "1")))
    assert second.logged[-1][0] == "set_accepted"
    bot.in_thread(lambda: Actions.made[ACTION].on_cancel(Handle(goal, "2")))
    assert second.logged[-1][0] == "set_canceled"


def test_the_planned_state_can_be_queried(bot):
    bot.start("arm")
    bot.endpoints["/bot/arm/command"].call(message((1.0, (0.4, 0.2))))
    bot.run(100)
    ask = bot.endpoints["/bot/arm/query_state"].call
    response = bot.in_thread(lambda: ask(QueryTrajectoryStateRequest(time=rospy.Time(0.5))))
    assert response.name == ["a", "b"]
    assert response.position == pytest.approx([0.2, 0.1])
    assert response.velocity == pytest.approx([0.4, 0.2])


def test_a_wrong_command_is_one_error(bot):
    bot.start("arm")
    bot.endpoints["/bot/arm/command"].call(message((1.0, (0.4,)), joints=("nose",)))
    bot.run(2)
    assert "It is for nose, must be for a, b" in bot.log[-1]


def test_gains_can_be_tuned_and_unloading_ends_the_action(bot):
    assert bot.load("arm")
    assert set(bot.pid_servers) == {"/bot/arm/gains/a", "/bot/arm/gains/b"}
    assert bot.unload("arm")
    assert Actions.made[ACTION].closed and bot.endpoints["/bot/arm/query_state"].closed


def test_a_gripper_reaches_its_goal(bot):
    bot.start("hand")
    goal = GripperCommandGoal()
    goal.command.position, goal.command.max_effort = 0.3, 4.0
    handle = send(bot, "/bot/hand/gripper_cmd", goal)
    bot.run(500)
    assert [logged[0] for logged in handle.logged] == ["set_accepted", "set_succeeded"]
    result = handle.logged[-1][1]
    assert (result.reached_goal, result.stalled, result.effort) == (True, False, 4.0)
    assert result.position == pytest.approx(0.3, abs=0.011)
    goal.command.position = float("nan")
    assert send(bot, "/bot/hand/gripper_cmd", goal).logged[0][0] == "set_rejected"
