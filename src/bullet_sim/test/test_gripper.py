"""gripper_action_controller: reaching, stalling, cancelling."""

import pytest
from bullet_sim.controllers.gripper import GripperGoal
from bullet_sim.controllers.manager import Manager
from bullet_sim.description.model import Joint
from bullet_sim.errors import ControllerError
from fake_joints import FakeJoints

STEP = 0.001  # [s]


class Finger(FakeJoints):
    """One sliding joint of 1 kg that efforts move, or that is where it is told."""

    names = ("finger",)
    limits = {"finger": Joint("finger", "prismatic", "a", "b", lower=0.0, upper=1.0)}

    def __init__(self):
        super().__init__()
        self.position = self.velocity = self.effort = 0.0
        self.wall = 1e9  # [m] it cannot pass

    def state(self):
        """Position and velocity."""
        return {"finger": self.position}, {"finger": self.velocity}

    def drive_positions(self, _names, values):
        """Move towards it at 0.5 m/s."""
        way = min(max(values[0] - self.position, -0.5 * STEP), 0.5 * STEP)
        self.velocity = way / STEP

    def apply_efforts(self, handles, computes=False):
        """Accelerate."""
        (finger,) = handles
        self.effort = finger.effort
        self.velocity += (self.effort - 2.0 * self.velocity) * STEP

    def release(self, _names):
        """Nothing holds it."""

    def step(self):
        """Move."""
        self.position += self.velocity * STEP
        if self.position > self.wall:
            self.position, self.velocity = self.wall, 0.0


class Gripper:
    """A manager with the running controller."""

    def __init__(self, kind, **config):
        self.finger, self.outcomes = Finger(), []
        self.manager = Manager(self.finger)
        config = {"type": f"{kind}_controllers/GripperActionController", **config}
        self.manager.load("gripper", {"joint": "finger", **config})
        self.manager.switch(["gripper"], [])
        self.control = self.manager.get("gripper")

    def goal(self, position, max_effort=5.0):
        """Pursue a goal."""
        goal = GripperGoal(position, max_effort, lambda *outcome: self.outcomes.append(outcome))
        self.control.execute(goal)
        return goal

    def run(self, seconds):
        """Simulate."""
        for _ in range(round(seconds / STEP)):
            self.manager.update(STEP)
            self.finger.step()


GAINS = {"gains": {"finger": {"p": 100.0, "d": 18.0}}}


@pytest.mark.parametrize("kind, config", [("position", {}), ("effort", GAINS)])
def test_a_goal_that_is_reached_succeeds(kind, config):
    gripper = Gripper(kind, goal_tolerance=0.02, **config)
    gripper.goal(0.4)
    gripper.run(2.0)
    ((outcome, grip),) = gripper.outcomes
    assert (outcome, grip.reached_goal, grip.stalled) == ("succeeded", True, False)
    assert grip.position == pytest.approx(0.4, abs=0.021)
    assert gripper.finger.position == pytest.approx(0.4, abs=0.01)


def test_a_finger_that_something_holds_stalls_with_its_effort():
    gripper = Gripper("effort", stall_timeout=0.3, **GAINS)
    gripper.finger.wall = 0.1
    gripper.goal(0.4, max_effort=5.0)
    gripper.run(2.0)
    ((outcome, grip),) = gripper.outcomes
    assert (outcome, grip.reached_goal, grip.stalled) == ("aborted", False, True)
    assert (grip.position, grip.effort) == (0.1, 5.0)
    assert gripper.finger.effort == 5.0  # it goes on pressing


def test_without_effort_nothing_moves_and_it_stalls_after_a_second():
    gripper = Gripper("effort", **GAINS)
    gripper.goal(0.4, max_effort=0.0)
    gripper.run(1.0)
    assert gripper.outcomes == [] and gripper.finger.position == 0.0
    gripper.run(0.01)
    assert gripper.outcomes[0][0] == "aborted"


def test_a_new_goal_and_a_cancel_end_the_goal_and_a_cancel_holds_the_finger():
    gripper = Gripper("position")
    gripper.goal(0.4)
    gripper.run(0.1)
    goal = gripper.goal(0.8)
    gripper.run(0.1)
    gripper.control.cancel(goal)
    there = gripper.finger.position
    gripper.run(0.5)
    assert [outcome for outcome, _ in gripper.outcomes] == ["canceled", "canceled"]
    assert gripper.finger.position == pytest.approx(there, abs=1e-3)


def test_efforts_need_gains():
    with pytest.raises(ControllerError, match="no gains of finger"):
        Gripper("effort")
