"""Trajectories: splines in closed form, commands joined to what runs, goals and tolerances."""

import math

import pytest
from bullet_sim.controllers import segments
from bullet_sim.controllers.manager import Manager
from bullet_sim.controllers.segments import (
    Command,
    End,
    Goal,
    JointsError,
    Point,
    Segment,
    Tolerance,
    check,
    stop,
)
from bullet_sim.description.model import Joint
from bullet_sim.errors import CommandError, ControllerError
from fake_joints import FakeJoints

STEP = 0.001  # [s]
NAMES = ("arm", "wheel", "slide")


# splines ------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "given, polynomial",
    [
        (1, (0.3, -0.7)),
        (2, (0.3, -0.7, 1.1, 0.4)),
        (3, (0.3, -0.7, 1.1, 0.4, -0.9, 0.25)),
    ],
)
def test_a_spline_is_the_polynomial_of_least_degree_through_what_is_given(given, polynomial):
    """Linear, cubic or quintic: the ends' values of a polynomial of that degree give it back."""

    def values(t):
        rows = [polynomial]
        for _ in range(2):
            rows.append([n * c for n, c in enumerate(rows[-1])][1:])
        return [sum(c * t**n for n, c in enumerate(row)) for row in rows]

    first, last = (End(*values(t)[:given]) for t in (0.0, 1.7))
    segment = Segment(10.0, first, 11.7, last)
    for t in (0.0, 0.4, 1.0, 1.7):
        assert segment.sample(10.0 + t) == pytest.approx(values(t), abs=1e-12)


def test_a_segment_is_at_rest_before_and_after_its_time():
    segment = Segment(1.0, End(0.0, 1.0), 2.0, End(3.0, 5.0))
    assert segment.sample(0.5) == (0.0, 0.0, 0.0)
    assert segment.sample(2.5) == (pytest.approx(3.0), 0.0, 0.0)


def test_the_lower_degree_counts_where_an_end_lacks_a_derivative():
    assert Segment(0.0, End(0.0, 9.0, 9.0), 2.0, End(1.0)).sample(0.5)[:2] == (0.25, 0.5)
    cubic = Segment(0.0, End(0.0, 0.0, 9.0), 1.0, End(1.0, 0.0))
    assert cubic.sample(0.25)[0] == pytest.approx(3 * 0.25**2 - 2 * 0.25**3)


def test_stopping_ends_at_rest_after_its_duration():
    """Quintic from v to -v in 2 T, symmetric: it turns after 5/8 v T and rests there."""
    ((segment,),) = stop((1.0,), (2.0,), 5.0, 0.4)
    assert segment.sample(5.0)[:2] == pytest.approx((1.0, 2.0))
    assert segment.sample(5.4)[:2] == pytest.approx((1.0 + 5.0 / 8.0 * 2.0 * 0.4, 0.0), abs=1e-12)


# the controller -----------------------------------------------------------------------------------
class Joints(FakeJoints):
    """Three joints, that can be held."""

    names = NAMES
    limits = {
        "arm": Joint("arm", "revolute", "a", "b", lower=-4.0, upper=4.0),
        "wheel": Joint("wheel", "continuous", "a", "c"),
        "slide": Joint("slide", "prismatic", "a", "d", lower=-9.0, upper=9.0),
    }
    held = False

    def drive_positions(self, names, values):
        """Be there at once, unless held."""
        if not self.held:
            super().drive_positions(names, values)


class Arm:
    """A manager with one running trajectory controller."""

    def __init__(self, kind="position", joints=NAMES, **config):
        self.joints = Joints()
        self.manager = Manager(self.joints)
        config = {"type": f"{kind}_controllers/JointTrajectoryController", **config}
        self.config = self.manager.load("arm", {"joints": list(joints), **config})
        self.manager.switch(["arm"], [])
        self.control = self.manager.get("arm")
        self.control.clock = lambda: self.manager.time + 100.0  # ROS time is another
        self.outcomes = []

    def run(self, seconds):
        """Simulate."""
        for _ in range(round(seconds / STEP)):
            self.manager.update(STEP)
            for name, speed in self.joints.speeds.items():
                self.joints.positions[name] += speed * STEP

    def goal(self, command, **fields):
        """Pursue a goal."""
        goal = Goal(lambda *outcome: self.outcomes.append(outcome), **fields)
        self.control.execute(command, goal)
        return goal


def move(*points, joints=NAMES, stamp=0.0):
    """Command of (time, positions, velocities ...) points."""
    return Command(joints, tuple(Point(*point) for point in points), stamp)


def test_positions_follow_the_points_in_the_messages_order():
    arm = Arm()
    command = move((1.0, (3.0, 2.0, 1.0)), (2.0, (3.0, 0.0, 2.0)), joints=NAMES[::-1])
    arm.manager.command("arm", command)
    arm.run(1.5)
    # the last update was at 1.499 s; the slide comes first in the message
    expected = {"slide": 3.0, "wheel": 2.0 - 2.0 * 0.499, "arm": 1.0 + 0.499}
    assert arm.joints.positions == pytest.approx(expected)
    arm.run(1.0)
    assert arm.joints.positions == pytest.approx({"slide": 3.0, "wheel": 0.0, "arm": 2.0})


def test_a_command_starts_with_the_motion_of_the_one_before():
    arm = Arm(joints=["arm"])
    arm.manager.command("arm", move((2.0, (2.0,), (1.0,)), joints=("arm",)))
    arm.run(1.0)
    planned = arm.control.planned(arm.control.clock())
    arm.manager.command("arm", move((1.0, (0.0,), (0.0,)), joints=("arm",)))
    arm.run(STEP)
    now = arm.control.desired
    assert now.positions == pytest.approx(planned.positions)
    assert now.velocities == pytest.approx(planned.velocities)


def test_a_stamp_delays_the_start_and_points_of_the_past_are_dropped():
    arm = Arm(joints=["arm"])
    arm.manager.command("arm", move((1.0, (1.0,)), joints=("arm",), stamp=100.5))
    arm.run(0.5)
    assert arm.joints.positions["arm"] == 0.0
    arm.run(0.5)
    assert arm.joints.positions["arm"] == pytest.approx(0.499)
    command = move((0.5, (9.0,)), (2.0, (2.0,)), joints=("arm",), stamp=100.5)
    arm.manager.command("arm", command)
    arm.run(1.6)
    assert arm.joints.positions["arm"] == pytest.approx(2.0)
    with pytest.raises(CommandError, match="Dropping all 2 trajectory point"):
        arm.manager.command("arm", command)


def test_a_step_costs_the_same_however_many_points_there_are(monkeypatch):
    """200,000 points ran at 0.17 of real time for their length, and took seconds to begin."""
    made = []
    monkeypatch.setattr(segments, "Segment", lambda *values: made.append(1) or Segment(*values))
    arm, count = Arm(joints=["arm"]), 200_000
    points = [(0.01 * (k + 1), (math.sin(0.01 * k),)) for k in range(count)]
    for at in (0.0, 1.0):  # the second replaces the first
        arm.manager.command("arm", move(*points, joints=("arm",)))
        arm.run(0.5)
        assert len(made) < 150 * (1 + at)
    assert arm.joints.positions["arm"] == pytest.approx(math.sin(0.489), abs=1e-4)


def test_a_continuous_joint_takes_the_shorter_way_and_others_do_not():
    arm = Arm()
    arm.joints.positions.update(arm=3.0, wheel=3.0)
    arm.manager.switch([], ["arm"])
    arm.manager.switch(["arm"], [])
    arm.manager.command("arm", move((1.0, (-3.0, -3.0, 0.0)), (2.0, (-2.0, -2.0, 0.0))))
    arm.run(2.01)
    turn = 2.0 * math.pi
    assert arm.joints.positions == pytest.approx({"arm": -2.0, "wheel": turn - 2.0, "slide": 0.0})


@pytest.mark.parametrize("start, target", [(0.0, math.pi), (0.0, -math.pi), (2.0, 2.0 + math.pi)])
@pytest.mark.parametrize("rounding", [-1e-12, 0.0, 1e-12])
def test_of_two_ways_of_half_a_turn_it_is_that_of_the_commanded_numbers(start, target, rounding):
    arm = Arm(joints=["wheel"])
    arm.joints.positions["wheel"] = start
    arm.manager.switch([], ["arm"])
    arm.manager.switch(["arm"], [])
    arm.manager.command("arm", move((1.0, (target + rounding,)), joints=("wheel",)))
    arm.run(1.01)
    assert arm.joints.positions["wheel"] == pytest.approx(target)


def test_an_empty_trajectory_stops_at_once_or_within_the_duration():
    arm = Arm(joints=["arm"])
    arm.manager.command("arm", move((1.0, (1.0,)), joints=("arm",)))
    arm.run(0.5)
    there = arm.joints.positions["arm"]
    arm.manager.command("arm", move(joints=()))  # whatever joints it names
    arm.run(0.5)
    assert arm.joints.positions["arm"] == there
    with pytest.raises(JointsError):  # of a goal they are checked
        arm.goal(move(joints=()))
    soft = Arm(joints=["arm"], stop_trajectory_duration=0.4)
    soft.manager.command("arm", move((1.0, (1.0,)), joints=("arm",)))
    soft.run(0.5)
    soft.manager.command("arm", move(joints=("arm",)))
    soft.run(0.5)
    assert soft.joints.positions["arm"] == pytest.approx(there + 5.0 / 8.0 * 0.4, abs=2e-3)


def test_partial_trajectories_leave_other_joints_to_what_they_do():
    arm = Arm(allow_partial_joints_goal=True)
    arm.manager.command("arm", move((1.0, (1.0, 1.0, 1.0))))
    arm.run(0.5)
    arm.goal(move((0.2, (0.0,)), joints=("arm",)))
    arm.run(0.6)
    assert arm.joints.positions == pytest.approx({"arm": 0.0, "wheel": 1.0, "slide": 1.0})
    assert arm.outcomes == [("succeeded", 0, "")]


# the other interfaces -----------------------------------------------------------------------------
def test_velocities_are_the_plans_with_what_the_pid_adds():
    gains = {"arm": {"p": 4.0}}
    arm = Arm("velocity", ["arm"], gains=gains, velocity_ff={"arm": 1.0})
    arm.manager.command("arm", move((1.0, (2.0,)), joints=("arm",)))
    arm.run(0.5)
    assert arm.joints.speeds["arm"] == pytest.approx(2.0, rel=0.01)
    arm.joints.positions["arm"] -= 0.1
    arm.run(STEP)
    assert arm.joints.speeds["arm"] == pytest.approx(2.0 + 4.0 * 0.1, rel=0.02)


def test_efforts_are_the_pids_of_both_errors_and_the_feedforward():
    gains = {"arm": {"p": 40.0, "d": 3.0}}
    arm = Arm("effort", ["arm"], gains=gains, velocity_ff={"arm": 0.5})
    arm.manager.command("arm", move((1.0, (2.0,)), joints=("arm",)))
    arm.run(0.2)
    ahead = 2.0 * 0.199  # the joint does not move
    assert arm.joints.applied["arm"] == pytest.approx(40.0 * ahead + 3.0 * 2.0 + 0.5 * 2.0)


# goals --------------------------------------------------------------------------------------------
LINE = ((0.5, (1.0,)),)
BOUNDS = {"goal_time": 0.3, "arm": {"trajectory": 0.2, "goal": 0.05}}


def test_a_goal_succeeds_when_all_joints_are_where_they_should_be():
    arm = Arm(joints=["arm"], constraints=BOUNDS)
    goal = arm.goal(move(*LINE, joints=("arm",)))
    arm.run(0.49)
    assert arm.outcomes == [] and arm.control.goal is goal
    arm.run(0.02)
    assert arm.outcomes == [("succeeded", 0, "")] and arm.control.goal is None


@pytest.mark.parametrize(
    "fields, outcome, after",
    [
        ({}, ("aborted", -4, "arm path error"), 0.1),
        ({"path": (("arm", Tolerance(-1.0)),)}, ("aborted", -5, "arm goal error"), 0.8),
        (
            {"path": (("arm", Tolerance(-1.0)),), "goal_time_tolerance": 1.0},
            ("aborted", -5, "arm goal error"),
            1.5,
        ),
        (
            {"path": (("arm", Tolerance(-1.0)),), "arrival": (("arm", Tolerance(2.0)),)},
            ("succeeded", 0, ""),
            0.5,
        ),
    ],
)
def test_a_joint_that_is_held_violates_its_tolerances(fields, outcome, after):
    """It stays at 0: off by more than 0.2 rad from 0.1 s on, by 1 rad at the end at 0.5 s."""
    arm = Arm(joints=["arm"], constraints=BOUNDS)
    arm.joints.held = True
    arm.goal(move(*LINE, joints=("arm",)), **fields)
    arm.run(after - 2 * STEP)
    assert arm.outcomes == []
    arm.run(5 * STEP)
    assert [(done[0], done[1]) for done in arm.outcomes] == [outcome[:2]]
    assert arm.outcomes[0][2].startswith(outcome[2])


def test_a_new_command_a_cancel_and_a_stop_cancel_the_goal():
    for end in (
        lambda arm, goal: arm.manager.command("arm", move(*LINE, joints=("arm",))),
        lambda arm, goal: arm.goal(move(*LINE, joints=("arm",))),
        lambda arm, goal: arm.control.cancel(goal),
        lambda arm, goal: arm.manager.switch([], ["arm"]),
    ):
        arm = Arm(joints=["arm"])
        goal = arm.goal(move(*LINE, joints=("arm",)))
        arm.run(0.1)
        end(arm, goal)
        assert arm.outcomes[0][0] == "canceled"
        arm.run(0.01)


def test_values_beyond_the_joints_of_a_trajectory_are_not_used():
    arm = Arm(joints=["arm"])
    arm.manager.command("arm", move((1.0, (1.0, 9.0), (0.0, 9.0)), joints=("arm",)))
    arm.run(1.5)
    assert arm.joints.positions["arm"] == pytest.approx(1.0)


# errors -------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "joints, points, words",
    [
        (("arm",), ((1.0, (1.0,)),), "It lacks wheel, slide"),
        (("arm", "nose", "slide"), ((1.0, (1.0,) * 3),), "must be for arm, wheel, slide"),
        (("arm", "arm", "slide"), ((1.0, (1.0,) * 3),), "each once"),
    ],
)
def test_other_joints_are_an_error_of_their_own(joints, points, words):
    with pytest.raises(JointsError, match=words):
        check(move(*points, joints=joints), NAMES, False)


@pytest.mark.parametrize(
    "points, words",
    [
        (((1.0, (1.0,)), (1.0, (2.0,))), "Point #1 is at 1.0 s, must be after 1.0 s"),
        (((1.0, ()),), "Point #0 has 0 positions, must have at least 1"),
        (((1.0, (1.0,), (1.0, 2.0)),), "has 2 velocities, must have 1"),
        (((1.0, (math.nan,)),), "must be finite numbers"),
    ],
)
def test_points_that_cannot_be_are_errors(points, words):
    with pytest.raises(CommandError, match=words):
        check(move(*points, joints=("arm",)), ("arm",), False)


def test_configuration_errors_name_the_key():
    with pytest.raises(ControllerError, match="no gains of wheel, which its interface needs"):
        Arm("effort", ["arm", "wheel"], gains={"arm": {"p": 1.0}})
    with pytest.raises(ControllerError, match="constraints arm has goal 'x'"):
        Arm(constraints={"arm": {"goal": "x"}})
    with pytest.raises(ControllerError, match="action_monitor_rate 0"):
        Arm(action_monitor_rate=0)


def test_planned_motion_of_a_time_before_the_trajectory_is_refused():
    arm = Arm()
    arm.run(0.5)
    with pytest.raises(ControllerError, match="precedes trajectory start time"):
        arm.control.planned(50.0)
