"""The goal controller on a kinematic truck: every direction, overshoot, life cycle, bad input."""

import math

import pytest
from cybertruck.goal.controller import GoalController, shortest_length
from cybertruck.goal.settings import GoalSettings
from goal_sim import Truck, drive

TOLERANCE = 0.15  # [m]
BOTH = pytest.mark.parametrize("trailer", [False, True], ids=["truck", "trailer"])


def controller(**settings):
    return GoalController(GoalSettings(**settings))


def check(run, truck, trailer):
    assert run.state == "reached"
    assert run.error <= TOLERANCE
    assert run.path <= 1.10 * run.shortest + 0.01
    assert run.sign_changes <= 3
    if trailer:  # the hitch's circle stays larger than the tongue
        assert math.hypot(1.0 / truck.tightest, 0.30) > 0.70
        assert truck.widest_hitch < math.radians(70.0)


def search_shortest(forward, left, radius, count=20000):
    """Finds the shortest turn-line or turn-turn path to a point by trying all first turns [m]."""
    best = math.inf
    for side in (1, -1):
        before = None
        for index in range(count):
            angle = 2.0 * math.pi * index / count
            heading = side * angle
            x, y = radius * math.sin(angle), side * radius * (1.0 - math.cos(angle))
            dx, dy = forward - x, left - y
            ahead = dx * math.cos(heading) + dy * math.sin(heading)
            sideways = dy * math.cos(heading) - dx * math.sin(heading)
            other = math.hypot(ahead, sideways + side * radius) - radius  # opposite turn's circle
            if before is not None:
                if before[0] * sideways <= 0.0 and ahead >= -1e-3:
                    best = min(best, radius * angle + max(ahead, 0.0))
                if before[1] * other <= 0.0:
                    turn = math.atan2(
                        ahead, side * sideways + radius
                    )  # from the circle's near side
                    best = min(best, radius * (angle + turn % (2.0 * math.pi)))
            before = (sideways, other)
    return best


@pytest.mark.parametrize(
    "forward, left",
    [
        (3.0, 0.5),
        (0.0, 3.0),
        (-2.0, 0.7),
        (-3.0, -0.2),
        (1.0, -1.5),
        (0.5, 1.9),  # outside
        (0.3, 0.9),
        (0.0, 0.4),
        (-0.6, 1.0),
        (0.2, -1.5),
        (0.0, -0.05),
    ],
)  # inside a circle
def test_shortest_length_equals_a_search(forward, left):
    expected = search_shortest(forward, left, 1.0)
    assert shortest_length(forward, left, 1.0) == pytest.approx(expected, abs=3e-3)


@pytest.mark.parametrize(
    "forward, left, expected",
    [
        (5.0, 0.0, 5.0),  # straight ahead
        (0.0, 2.0, math.pi),  # half a circle of radius 1
        (1.0, 1.0, math.pi / 2.0),  # a quarter
        (1.0, -3.0, 0.5 * math.pi + 2.0),  # a quarter to the right, then two meters
        (-1.0, 1.0, 1.5 * math.pi),
    ],
)
def test_shortest_length_of_known_paths(forward, left, expected):
    assert shortest_length(forward, left, 1.0) == pytest.approx(expected)


@BOTH
@pytest.mark.parametrize("heading", [0.0, math.pi / 2.0], ids=["along x", "along y"])
def test_there_and_back(trailer, heading):
    truck = Truck(heading=heading)
    driver = controller(trailer=trailer)
    check(drive(driver, truck, (10.0, 10.0)), truck, trailer)
    check(drive(driver, truck, (0.0, 0.0)), truck, trailer)


@BOTH
@pytest.mark.parametrize("degrees", [0, 45, 90, 135, 179.9, 180, -90, -135])
@pytest.mark.parametrize("distance", [2.5, 5.0, 14.0])
def test_goals_off_the_heading(trailer, degrees, distance):
    truck, angle = Truck(heading=0.7), 0.7 + math.radians(degrees)
    goal = (distance * math.cos(angle), distance * math.sin(angle))
    check(drive(controller(trailer=trailer), truck, goal), truck, trailer)


@BOTH
@pytest.mark.parametrize(
    "x, y",
    [
        (0.0, 0.3),
        (0.0, -0.3),
        (0.0, 0.8),
        (0.3, 0.7),
        (-0.3, 0.7),
        (0.1, -1.1),
        (-0.5, -0.6),
        (0.0, 1.5),
        (0.0, -1.5),
    ],
)
def test_goals_to_the_side_inside_its_turning_circle(trailer, x, y):
    truck = Truck()
    check(drive(controller(trailer=trailer), truck, (x, y)), truck, trailer)


@BOTH
@pytest.mark.parametrize("beyond", [0.2, 0.3, 0.6])
def test_recovers_from_an_overshoot(trailer, beyond):
    """The truck rolls over the goal at speed with the wheels turned, and the goal lies behind."""
    truck = Truck(speed=1.5, steering=0.3)
    run = drive(controller(trailer=trailer), truck, (-beyond, 0.05))
    assert (run.state, run.error <= TOLERANCE, run.sign_changes <= 3) == ("reached", True, True)


@BOTH
def test_pushed_off_while_it_drives(trailer):
    """A jump sideways next to the goal puts it inside the turning circle: it comes again."""
    truck, driver = Truck(), controller(trailer=trailer)
    driver.start(5.0, 0.0)
    pushed, state = False, "active"
    while state == "active" and truck.time < 60.0:
        state, *command = driver.update(truck.x, truck.y, truck.heading, truck.time)
        truck.step(*command)
        if not pushed and truck.x > 4.5:
            truck.y, pushed = 0.5, True
    assert state == "reached" and pushed
    assert math.hypot(5.0 - truck.x, truck.y) <= TOLERANCE


def test_the_driven_radius_is_the_configured_one():
    truck = Truck()
    drive(controller(min_radius=1.4), truck, (-8.0, 0.3))
    assert 1.0 / truck.tightest == pytest.approx(1.4, rel=0.02)


@pytest.mark.parametrize("heading", [0.0, math.pi / 2.0])
def test_original_gains_end_in_the_original_box(heading):
    truck, driver = Truck(heading=heading), controller(gains="original")
    for goal in ((10.0, 10.0), (0.0, 0.0)):
        run = drive(driver, truck, goal)
        assert run.state == "reached"
        assert max(abs(goal[0] - truck.x), abs(goal[1] - truck.y)) <= 0.5
        assert run.error > TOLERANCE  # it stops at the box, not at the goal


@pytest.mark.parametrize(
    "pose, expected",
    [
        ((0.0, 0.0, 0.0), (1.5, 0.0)),  # 10 m ahead: 0.8 * 10 / 2.5 = 3.2, cut to 1.5
        ((8.0, 0.0, 0.0), (0.24, 0.0)),  # fine: 0.3 * 2 / 2.5
        ((6.0, 0.0, 0.1), (1.28, -0.096)),  # coarse beyond 3 m: 0.8 * 4 / 2.5, 2.4 * 0.1 / 2.5
        ((8.0, 0.0, -0.2), (0.24, 0.08)),  # fine: 1.0 * 0.2 / 2.5
        ((0.0, 0.0, 1.5), (1.5, -0.7854)),
    ],
)  # turning cut to 0.7854
def test_original_gains(pose, expected):
    driver = controller(gains="original")
    driver.start(10.0, 0.0)
    assert driver.update(*pose, 0.0)[1:] == pytest.approx(expected, abs=1e-9)


def test_a_new_goal_replaces_the_running_one():
    truck, driver = Truck(), controller()
    driver.start(10.0, 0.0)
    for _ in range(300):
        truck.step(*driver.update(truck.x, truck.y, truck.heading, truck.time)[1:])
    speed = truck.speed
    driver.start(truck.x, 5.0)
    assert driver.update(truck.x, truck.y, truck.heading, truck.time)[1] > 0.3 * speed
    assert drive(driver, truck, (truck.x, 5.0)).state == "reached"


def test_arrival_is_reported_once():
    driver = controller()
    driver.start(1.0, 1.0)
    assert driver.update(1.0, 1.02, 0.0, 0.0) == ("reached", 0.0, 0.0)
    assert driver.update(1.0, 1.02, 0.0, 0.008) is None


def test_stopped_goals_command_nothing():
    driver = controller()
    assert driver.update(0.0, 0.0, 0.0, 0.0) is None
    driver.start(5.0, 0.0)
    driver.stop()
    assert driver.update(0.0, 0.0, 0.0, 0.0) is None


@pytest.mark.parametrize("gains, first", [("default", 0.2), ("original", 1.5)])
def test_after_a_cancelled_goal_the_next_one_starts_from_rest(gains, first):
    truck, driver = Truck(), controller(gains=gains)
    driver.start(20.0, 0.0)
    for _ in range(300):
        command = driver.update(truck.x, truck.y, truck.heading, truck.time)[1]
        truck.step(command, 0.0)
    assert command == 1.5
    driver.stop()
    driver.start(20.0, 0.0)
    assert driver.update(truck.x, truck.y, truck.heading, truck.time + 10.0)[1] == first


def test_time_that_goes_back_ends_the_goal_once():
    driver = controller()
    driver.start(10.0, 0.0)
    assert driver.update(1.0, 0.0, 0.0, 50.0)[0] == "active"
    assert driver.update(0.0, 0.0, 0.0, 0.008) == ("reset", 0.0, 0.0)
    assert driver.goal is None and driver.update(0.0, 0.0, 0.0, 0.016) is None
    driver.start(10.0, 0.0)
    assert driver.update(0.0, 0.0, 0.0, 0.024)[0] == "active"


def test_time_that_goes_back_between_goal_and_odometry_ends_it():
    driver = controller()
    assert driver.update(0.0, 0.0, 0.0, 50.0) is None
    driver.start(10.0, 0.0)
    assert driver.update(0.0, 0.0, 0.0, 0.008)[0] == "reset"


def test_time_that_went_back_before_the_goal_does_not_end_it():
    driver = controller()
    assert driver.update(0.0, 0.0, 0.0, 50.0) is None
    assert driver.update(0.0, 0.0, 0.0, 0.008) is None
    driver.start(10.0, 0.0)
    assert driver.update(0.0, 0.0, 0.0, 0.016)[0] == "active"


def test_a_blocked_truck_gives_up():
    driver = controller()
    driver.start(5.0, 0.0)
    states = {}
    for index in range(1000):
        update = driver.update(0.0, 0.0, 0.0, 0.008 * index)
        if update is None:
            break
        states[update[0]] = 0.008 * index
    assert states["stuck"] == pytest.approx(5.0, abs=0.02)


@pytest.mark.parametrize(
    "position, pose, words",
    [
        ((math.nan, 0.0, 0.0), (0.0, 0.0, 0.0), "x of the goal is nan"),
        ((0.0, math.inf, 0.0), (0.0, 0.0, 0.0), "y of the goal is inf"),
        ((0.0, 0.0, math.nan), (0.0, 0.0, 0.0), "z of the goal is nan"),
        ((300.0, 0.0, 0.0), (0.0, 0.0, 0.0), "within 200 m"),
        ((3.0, 0.0, 2.0), (0.0, 0.0, 0.0), "on the ground"),
        ((3.0, 0.0, 0.0), None, "no odometry"),
        ((3.0, 0.0, 0.0), (0.0, 0.0, 0.0), ""),
    ],
)
def test_refusals(position, pose, words):
    reason = controller().refusal(position, pose)
    assert words in reason and bool(reason) == bool(words)


@pytest.mark.parametrize(
    "settings, words",
    [
        ({"gains": "fast"}, "one of default, original"),
        ({"min_radius": 0.3}, "no less than"),
        ({"trailer": True, "trailer_min_radius": 0.6}, "trailer_min_radius is 0.6"),
        ({"tolerance": 0.0}, "tolerance is 0.0"),
        ({"max_linear": float("nan")}, "max_linear is nan"),
        ({"turn_gain": "much"}, "turn_gain is 'much'"),
        ({"trailer": 1}, "true or false"),
    ],
)
def test_bad_settings(settings, words):
    with pytest.raises(ValueError, match=words):
        GoalSettings(**settings)
