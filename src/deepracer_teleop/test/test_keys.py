"""Held keys and the pad: what real key events and Joy messages put on /cmd_vel."""

import math
import threading
import time

import pytest
from deepracer_teleop.input_devices import RELEASE_MS, Keys, deflection
from PyQt5.QtCore import QEvent, Qt
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QWidget
from sensor_msgs.msg import Joy

LIMIT = 30.0  # [s] of wall time


@pytest.fixture
def keys(teleop):
    """A window that has the keyboard focus."""
    teleop.build()
    QApplication.setActiveWindow(teleop.window)
    QApplication.processEvents()
    teleop.take()
    return teleop


def target(teleop):
    return teleop.window.focusWidget() or teleop.window


def press(teleop, *names):
    for name in names:
        QTest.keyPress(target(teleop), name)


def release(teleop, *names):
    for name in names:
        QTest.keyRelease(target(teleop), name)
        keys, end = teleop.window.findChild(Keys), time.monotonic() + LIMIT
        while keys._releases and time.monotonic() < end:
            QTest.qWait(5)


def repeat(teleop, key, count, auto_repeat=True):
    """Sends an X server's events of a held key: pairs of release and press; auto_repeat: flag."""
    for _ in range(count):
        for event_type in (QEvent.KeyRelease, QEvent.KeyPress):
            event = QKeyEvent(event_type, key, Qt.NoModifier, "", auto_repeat)
            QApplication.sendEvent(target(teleop), event)


@pytest.mark.parametrize(
    "key, command",
    [
        (Qt.Key_Up, (10, 0)),
        (Qt.Key_W, (10, 0)),
        (Qt.Key_Down, (-10, 0)),
        (Qt.Key_S, (-10, 0)),
        (Qt.Key_Left, (0, -2.5)),
        (Qt.Key_A, (0, -2.5)),
        (Qt.Key_Right, (0, 2.5)),
        (Qt.Key_D, (0, 2.5)),
    ],
)
def test_a_key_drives_while_it_is_held(keys, key, command):
    press(keys, key)
    assert keys.take() == [command]
    keys.advance(5.0)  # longer than any timed move
    assert set(keys.take()) == ({command} if command[0] else set())
    release(keys, key)
    assert keys.take() == [(0, 0)]
    keys.advance(1.0)
    assert keys.take() == []


@pytest.mark.parametrize("auto_repeat", [True, False])
def test_repeats_of_a_held_key_change_nothing(keys, auto_repeat):
    press(keys, Qt.Key_Up)
    keys.take()
    repeat(keys, Qt.Key_Up, 20, auto_repeat)
    QTest.qWait(2 * RELEASE_MS)
    assert keys.take() == []
    release(keys, Qt.Key_Up)
    assert keys.take() == [(0, 0)]


def test_two_keys_drive_a_curve(keys):
    press(keys, Qt.Key_W, Qt.Key_A)
    release(keys, Qt.Key_W)
    release(keys, Qt.Key_A)
    assert keys.take() == [(10, 0), (10, -2.5), (0, -2.5), (0, 0)]


def test_opposite_keys_cancel_and_doubles_count_once(keys):
    press(keys, Qt.Key_Up, Qt.Key_W)
    assert keys.take() == [(10, 0)]
    press(keys, Qt.Key_S)
    assert keys.take() == [(0, 0)]
    release(keys, Qt.Key_S)
    release(keys, Qt.Key_Up)
    assert keys.take() == [(10, 0)]


def test_space_stops_whatever_has_the_focus_and_lasts_until_a_new_press(keys):
    for widget in (keys.window, keys.window.buttons["Forward"], keys.window.slider):
        widget.setFocus()
        press(keys, Qt.Key_W)
        keys.take()
        press(keys, Qt.Key_Space)
        repeat(keys, Qt.Key_W, 3)
        release(keys, Qt.Key_Space, Qt.Key_W)
        keys.advance(1.0)
        assert keys.take() == [(0, 0)]
        assert not keys.window.isMoving()


def test_space_stops_a_timed_move(keys):
    keys.click("Left")
    keys.advance(0.2)
    keys.take()
    press(keys, Qt.Key_Space)
    keys.advance(1.0)
    assert keys.take() == [(0, 0)]


def test_a_stop_by_mouse_lasts_while_the_key_is_down(keys):
    press(keys, Qt.Key_Up)
    keys.take()
    keys.click("Stop")
    release(keys, Qt.Key_Up)
    keys.advance(1.0)
    assert keys.take() == [(0, 0)]


def test_losing_the_focus_stops(keys):
    press(keys, Qt.Key_Up, Qt.Key_Right)
    keys.take()
    other = QWidget()
    other.show()
    QApplication.setActiveWindow(other)
    QApplication.processEvents()
    assert keys.take() == [(0, 0)]
    QApplication.setActiveWindow(keys.window)
    QApplication.processEvents()
    release(keys, Qt.Key_Up, Qt.Key_Right)
    assert keys.take() == []
    other.close()


def test_losing_the_focus_does_not_stop_a_timed_move_or_cruise(keys):
    keys.click("Forward")
    keys.take()
    QApplication.sendEvent(keys.window, QEvent(QEvent.WindowDeactivate))
    assert keys.take() == [] and keys.window.isMoving()


def test_a_hidden_window_stops(keys):
    press(keys, Qt.Key_Up)
    keys.take()
    keys.window.hide()
    assert keys.take() == [(0, 0)]


def test_a_slider_with_the_focus_keeps_its_arrows_but_not_wasd(keys):
    keys.window.slider.setFocus()
    press(keys, Qt.Key_Right)
    assert keys.take() == [(0, 0.1)] and keys.window.slider.value() == 1
    press(keys, Qt.Key_W)
    assert keys.take() == [(10, 0)]
    release(keys, Qt.Key_W)
    assert keys.take() == [(0, 0)]
    QTest.mouseClick(keys.window.cameraLabel, Qt.LeftButton)  # next to the slider
    press(keys, Qt.Key_Right)
    assert keys.take() == [(0, 2.5)]


def test_cruise_continues_when_the_keys_are_released(keys):
    keys.toggle_cruise()
    keys.window.slider.setValue(10)
    keys.take()
    press(keys, Qt.Key_Left)
    release(keys, Qt.Key_Left)
    press(keys, Qt.Key_Down)
    release(keys, Qt.Key_Down)
    assert keys.take() == [(10, -2.5), (10, 1), (-10, 1), (10, 1)]


def test_enter_clicks_what_space_does_not(keys):
    keys.window.buttons["Right"].setFocus()
    press(keys, Qt.Key_Return)
    assert keys.take() == [(10, 5)]
    keys.window.cruise.setFocus()
    press(keys, Qt.Key_Return)
    assert keys.window.cruise.isChecked()


def test_shortcuts_are_ignored(keys):
    QTest.keyPress(keys.window, Qt.Key_W, Qt.ControlModifier)
    QTest.keyPress(keys.window, Qt.Key_Tab)
    assert keys.take() == []


def test_keys_in_ackermann_mode(teleop):
    teleop.build(default_speed=0.3, default_angular_speed=1.0, angular_sign=-1, key_steering=0.8)
    press(teleop, Qt.Key_Up, Qt.Key_Left)
    assert teleop.take() == [(0.3, 0.0), (0.3, 0.8)]


def joy(teleop, *axes, buttons=(0, 0)):
    """Passes a message as rospy does; disables the check for publishers."""
    teleop.window._health.stop()
    message = Joy(axes=list(axes), buttons=list(buttons))
    thread = threading.Thread(target=teleop.window._inputs.pad.callback, args=(message,))
    thread.start()
    thread.join()
    QApplication.processEvents()


def test_the_stick_drives(teleop):
    teleop.build()
    joy(teleop, 0.0, 0.0)
    joy(teleop, 0.05, -0.09)  # near its center
    assert teleop.take() == []
    joy(teleop, 0.0, 1.0)
    joy(teleop, -1.0, 0.55)
    assert teleop.take() == [(10, 0), (pytest.approx(5), 2.5)]
    joy(teleop, 0.0, 0.0)
    assert teleop.take() == [(0, 0)]
    joy(teleop, 0.0)  # no stick at all
    assert teleop.take() == []


def test_a_button_of_the_pad_stops_until_the_stick_was_in_its_center(teleop):
    teleop.build()
    joy(teleop, 0.0, 1.0)
    teleop.take()
    joy(teleop, 0.0, 1.0, buttons=(0, 1))
    joy(teleop, 0.0, 0.9)
    teleop.advance(1.0)
    assert teleop.take() == [(0, 0)]
    joy(teleop, 0.0, 0.0)
    joy(teleop, 0.0, 1.0)
    assert teleop.take() == [(10, 0)]


def test_the_car_stops_when_the_pad_disconnects(teleop):
    teleop.build()
    joy(teleop, 0.0, 1.0)
    teleop.take()
    teleop.window._check_health()  # no publisher
    assert teleop.take() == [(0, 0)]


def test_messages_that_pile_up_are_one_command(teleop):
    teleop.build()
    teleop.window._health.stop()  # it would find that this pad has no publisher
    for step in range(1, 101):
        teleop.window._inputs.pad.callback(Joy(axes=[0.0, step / 100], buttons=[]))
    QApplication.processEvents()
    assert teleop.take() == [(10, 0)]


@pytest.mark.parametrize(
    "axis, expected",
    [(0.0, 0.0), (0.1, 0.0), (0.55, 0.5), (-1.0, -1.0), (3.0, 1.0), (math.nan, 0.0),
     (-math.inf, 0.0)],
)  # fmt: skip
def test_deflection_of_an_axis(axis, expected):
    assert deflection(axis) == pytest.approx(expected)
