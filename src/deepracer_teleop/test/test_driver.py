"""The window drivers' decisions, with a fake line detector."""

import math

import pytest

from deepracer_teleop import drivers as module


class LineDetector:
    """Detects `goal` in each new image."""

    def __init__(self):
        self.goal, self.new, self.restarts = None, True, 0

    def has_new_image(self):
        return self.new

    def find_goal(self):
        return self.goal

    def restart(self):
        self.restarts += 1


class Mouse:
    """Records the calls."""

    def __init__(self, window):
        self.window, self.done = window, []

    def click(self, name):
        self.done.append(name)

    def toggle_cruise(self):
        self.done.append("cruise")

    def grab_slider(self):
        self.done.append("grab")

    def release_slider(self):
        self.done.append("release")

    def pull_slider(self, value):
        self.done.append(value)
        self.window.slider.number = value

    def slider_value(self, curvature):
        return -10.0 * curvature


class Window:
    """A slider and whether a move runs."""

    class Slider:
        number = 0

        def value(self):
            return self.number

    def __init__(self):
        self.slider, self.moving = self.Slider(), False

    def isMoving(self):
        return self.moving


class DriverFixture:
    """A driver with a clock set by the test."""

    def __init__(self, monkeypatch, driver_type):
        self.now, self.detector, self.parameters = 10.0, LineDetector(), {}
        monkeypatch.setattr(module, "LineDetector", lambda window: self.detector)
        monkeypatch.setattr(module, "Mouse", Mouse)
        monkeypatch.setattr(module.rospy, "get_time", lambda: self.now)
        monkeypatch.setattr(module.rospy, "get_param", lambda name, default: default)
        self.window = Window()
        self.driver = driver_type(self.window)
        self.done = self.driver._mouse.done

    def run(self, seconds):
        for _ in range(round(seconds / 0.02)):
            self.now += 0.02
            self.driver.spin_once()


@pytest.fixture
def slider(monkeypatch):
    return DriverFixture(monkeypatch, module.SliderDriver)


@pytest.fixture
def buttons(monkeypatch):
    return DriverFixture(monkeypatch, module.ButtonsDriver)


def test_slider_changes_at_most_five_times_a_second(slider):
    for k in range(100):
        slider.detector.goal = (1.0, 0.3 * math.sin(k))
        slider.run(0.04)
    values = [item for item in slider.done if not isinstance(item, str)]
    assert slider.done[:2] == ["cruise", "grab"] and 15 <= len(values) <= 21  # in 4 s


def test_slider_stops_when_the_line_is_not_visible(slider):
    slider.detector.goal = (1.0, 0.2)
    slider.run(1.0)
    slider.detector.goal = None
    slider.run(1.0)
    assert "Stop" not in slider.done
    slider.run(1.0)
    assert slider.done[-3:] == ["release", "cruise", "Stop"]


def test_slider_stops_without_new_images(slider):
    slider.detector.goal = (1.0, 0.2)
    slider.run(1.0)
    slider.detector.new = False
    slider.run(2.0)
    assert slider.done[-3:] == ["release", "cruise", "Stop"]


def test_slider_continues_after_a_reset(slider):
    slider.detector.goal = (1.0, 0.2)
    slider.run(1.0)
    slider.now = 0.0
    slider.run(0.5)
    assert slider.detector.restarts == 1 and "Stop" not in slider.done
    slider.detector.goal = (1.0, -0.2)
    slider.run(0.5)
    assert slider.done[-1] > 0


@pytest.mark.parametrize(
    "goal, button",
    [((1.0, 0.1), "Forward"), ((1.0, 0.6), "Left"), ((1.0, -0.6), "Right"), (None, "Backwards")],
)
def test_buttons(buttons, goal, button):
    buttons.detector.goal = goal
    buttons.driver.spin_once()
    assert buttons.done == [button]


def test_buttons_wait_for_the_move_and_for_a_new_image(buttons):
    buttons.detector.goal = (1.0, 0.0)
    buttons.window.moving = True
    buttons.run(0.5)
    assert buttons.done == []
    buttons.window.moving = False
    buttons.detector.new = False
    buttons.run(1.0)
    assert buttons.done == []
    buttons.detector.new = True
    buttons.run(0.1)
    assert buttons.done[0] == "Forward"
