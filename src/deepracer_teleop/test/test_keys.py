"""Held keys and the pad: what real key events and Joy messages put on /cmd_vel."""

import math
import threading
import time

import pytest
from deepracer_teleop.hand import RELEASE_MS, Keys, deflection
from PyQt5.QtCore import QEvent, Qt
from PyQt5.QtGui import QKeyEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication, QWidget
from sensor_msgs.msg import Joy

LIMIT = 30.0  # [s] of wall time


@pytest.fixture
def keys(rig):
    """The rig with a window that has the keyboard."""
    rig.build()
    QApplication.setActiveWindow(rig.window)
    QApplication.processEvents()
    rig.take()
    return rig


def target(rig):
    return rig.window.focusWidget() or rig.window


def press(rig, *names):
    for name in names:
        QTest.keyPress(target(rig), name)


def release(rig, *names):
    for name in names:
        QTest.keyRelease(target(rig), name)
        keys, end = rig.window.findChild(Keys), time.monotonic() + LIMIT
        while keys._going and time.monotonic() < end:
            QTest.qWait(5)


def repeat(rig, key, count, told=True):
    """What an X server sends while a key is held: pairs of release and press; told: as such."""
    for _ in range(count):
        for kind in (QEvent.KeyRelease, QEvent.KeyPress):
            event = QKeyEvent(kind, key, Qt.NoModifier, "", told)
            QApplication.sendEvent(target(rig), event)


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


@pytest.mark.parametrize("told", [True, False])
def test_repeats_of_a_held_key_change_nothing(keys, told):
    press(keys, Qt.Key_Up)
    keys.take()
    repeat(keys, Qt.Key_Up, 20, told)
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


def test_space_stops_whatever_has_the_focus_and_holds_until_a_new_press(keys):
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


def test_a_stop_by_mouse_holds_while_the_key_is_down(keys):
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


def test_losing_the_focus_leaves_a_timed_move_and_cruise_alone(keys):
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
    QTest.mouseClick(keys.window.cameraLabel, Qt.LeftButton)  # beside the slider
    press(keys, Qt.Key_Right)
    assert keys.take() == [(0, 2.5)]


def test_cruise_goes_on_when_the_keys_are_released(keys):
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


def test_shortcuts_are_left_alone(keys):
    QTest.keyPress(keys.window, Qt.Key_W, Qt.ControlModifier)
    QTest.keyPress(keys.window, Qt.Key_Tab)
    assert keys.take() == []


def test_keys_in_ackermann_mode(rig):
    rig.build(default_speed=0.3, default_angular_speed=1.0, angular_sign=-1, key_steering=0.8)
    press(rig, Qt.Key_Up, Qt.Key_Left)
    assert rig.take() == [(0.3, 0.0), (0.3, 0.8)]


def joy(rig, *axes, buttons=(0, 0)):
    """Passes a message in as rospy does, and keeps out the check that nobody publishes here."""
    rig.window._health.stop()
    message = Joy(axes=list(axes), buttons=list(buttons))
    thread = threading.Thread(target=rig.window._hand.pad.callback, args=(message,))
    thread.start()
    thread.join()
    QApplication.processEvents()


def test_the_stick_drives(rig):
    rig.build()
    joy(rig, 0.0, 0.0)
    joy(rig, 0.05, -0.09)  # about its middle
    assert rig.take() == []
    joy(rig, 0.0, 1.0)
    joy(rig, -1.0, 0.55)
    assert rig.take() == [(10, 0), (pytest.approx(5), 2.5)]
    joy(rig, 0.0, 0.0)
    assert rig.take() == [(0, 0)]
    joy(rig, 0.0)  # no stick at all
    assert rig.take() == []


def test_a_button_of_the_pad_stops_until_the_stick_was_in_its_middle(rig):
    rig.build()
    joy(rig, 0.0, 1.0)
    rig.take()
    joy(rig, 0.0, 1.0, buttons=(0, 1))
    joy(rig, 0.0, 0.9)
    rig.advance(1.0)
    assert rig.take() == [(0, 0)]
    joy(rig, 0.0, 0.0)
    joy(rig, 0.0, 1.0)
    assert rig.take() == [(10, 0)]


def test_a_pad_that_goes_stops(rig):
    rig.build()
    joy(rig, 0.0, 1.0)
    rig.take()
    rig.window._check_health()  # nobody publishes
    assert rig.take() == [(0, 0)]


def test_messages_that_pile_up_are_one_command(rig):
    rig.build()
    for step in range(1, 101):
        rig.window._hand.pad.callback(Joy(axes=[0.0, step / 100], buttons=[]))
    QApplication.processEvents()
    assert rig.take() == [(10, 0)]


@pytest.mark.parametrize(
    "axis, expected",
    [(0.0, 0.0), (0.1, 0.0), (0.55, 0.5), (-1.0, -1.0), (3.0, 1.0), (math.nan, 0.0),
     (-math.inf, 0.0)],
)  # fmt: skip
def test_the_sticks_way(axis, expected):
    assert deflection(axis) == pytest.approx(expected)
