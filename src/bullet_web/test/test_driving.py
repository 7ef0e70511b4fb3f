"""Who drives, and what a page's command is on a topic."""

import math

import pytest
from bullet_web.driving import SAFE_CURVATURE, Drive, Seat, drive_of


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def sent():
    return []


@pytest.fixture
def seat(clock, sent):
    return Seat(lambda *command: sent.append(command), clock, timeout=0.5)


def test_the_first_command_takes_an_empty_seat_and_others_only_look(seat, sent):
    assert not seat.command(1, 0.0, 0.0)
    assert seat.driver is None
    assert seat.command(1, 0.5, -0.25)
    assert not seat.command(2, 1.0, 1.0)
    assert (seat.driver, sent) == (1, [(0.5, -0.25)])


def test_an_end_is_one_zero_and_nothing_after_it(seat, sent):
    seat.command(1, 0.5, 0.0)
    seat.command(1, 0.0, 0.0)
    seat.command(1, 0.0, 0.0)
    seat.release(1)
    assert sent == [(0.5, 0.0), (0.0, 0.0)]
    assert seat.driver is None


def test_taking_over_ends_what_the_other_has_commanded(seat, sent):
    seat.command(1, 0.5, 0.0)
    seat.take(2)
    assert sent == [(0.5, 0.0), (0.0, 0.0)]
    assert not seat.command(1, 0.5, 0.0)
    seat.command(2, -1.0, 0.0)
    seat.release(1)  # it has nothing to release
    assert (seat.driver, sent[-1]) == (2, (-1.0, 0.0))


def test_a_page_that_drives_and_takes_again_goes_on(seat, sent):
    seat.command(1, 0.5, 0.0)
    seat.take(1)
    assert sent == [(0.5, 0.0)]


def test_the_watchdog_stops_once_when_commands_cease(seat, sent, clock):
    seat.command(1, 0.5, 0.0)
    clock.now += 0.4
    assert not seat.check()
    seat.command(1, 0.5, 0.0)
    clock.now += 0.4
    assert not seat.check()
    clock.now += 0.2
    assert seat.check()
    clock.now += 1.0
    assert not seat.check()
    assert sent == [(0.5, 0.0), (0.5, 0.0), (0.0, 0.0)]
    assert seat.driver == 1


def test_steering_alone_counts_as_moving(seat, sent, clock):
    seat.command(1, 0.0, 1.0)
    clock.now += 1.0
    assert seat.check()
    assert sent == [(0.0, 1.0), (0.0, 0.0)]


def test_the_original_steers_right_with_positive_values_in_units_of_15_degrees():
    drive = drive_of("/cmd_vel", {"mode": "original", "wheelbase": 0.164, "max_steering": 0.5236})
    assert drive.twist(0.2, 1.0) == (10.0, 4.0)
    assert drive.unit == "rad/s"


def test_a_car_in_meters_is_commanded_by_its_curvature():
    drive = drive_of("/cmd_vel", {"mode": "ackermann", "wheelbase": 0.164, "max_steering": 0.5236})
    linear, angular = drive.twist(0.5, -1.0)  # to the left
    assert angular / linear == pytest.approx(math.tan(0.5236) / 0.164)
    backwards = drive.twist(-0.5, -1.0)
    assert backwards == (-linear, -angular)  # the wheels stay where they are
    assert drive.twist(0.0, 1.0) == (0.0, 0.0)


def test_the_truck_turns_no_tighter_than_its_trailer_follows():
    parameters = {"wheelbase": 0.508, "max_steering": 0.7854, "max_speed": 3.0}
    drive = drive_of("/cmd_vel", {**parameters, "max_steering_rate": 2.5})
    linear, angular = drive.twist(1.0, -1.0)
    assert (linear, angular) == (3.0, 3.0 * SAFE_CURVATURE)


@pytest.mark.parametrize(
    "parameters", [{}, {"wheelbase": "a"}, {"wheelbase": 0.0, "max_steering": 1.0}]
)
def test_any_other_base_takes_meters_and_radians_a_second(parameters):
    drive = drive_of("/base/cmd_vel", parameters)
    assert drive == Drive("/base/cmd_vel")
    assert drive.twist(1.0, 0.0) == (1.0, 0.0)
    assert drive.twist(0.0, 1.0)[1] < 0.0  # right is clockwise
