"""Drivers that use the teleop window as a person would: look at the picture, move the mouse.

`slider_driver` holds the steering slider with cruise control on; `buttons_driver` roams with the
five buttons. Both see nothing but the window's camera picture.
"""

import math
import os
import sys
import time

import rospy
from deepracer_control.drivers.line_vision import vision_from
from deepracer_control.drivers.pursuit import towards
from paddock_common.rules import Number
from paddock_common.settings import parameter
from PyQt5.QtCore import QTimer
from sensor_msgs.msg import CameraInfo

from deepracer_teleop.drivers.hands import Hands
from deepracer_teleop.window.window import connect

LOOK_MS = 20  # how often the driver looks whether there is something to do [ms]
PATIENCE = 1.5  # how long the last steering is kept with nothing in sight [s] of ROS time


class Eyes:
    """What the window's picture shows.

    Args:
        window: InterfaceWindow.
    """

    def __init__(self, window):
        self._window = window
        self._vision = vision_from(rospy.get_param, lookahead=0.5)
        self._matrix, self._looked = None, None
        rospy.Subscriber("camera_info", CameraInfo, self._take_info, queue_size=1)

    def _take_info(self, message):
        self._matrix = tuple(message.K)

    def ready(self):
        """Says whether there is a picture to look at."""
        return self._matrix is not None and self._window.lastPicture() is not None

    def news(self):
        """Says whether there is a picture that was not looked at yet."""
        return self.ready() and self._window.pictureTime() != self._looked

    def look(self):
        """Gives the point to steer for (x ahead, y left) [m] in the newest picture, or None."""
        self._looked = self._window.pictureTime()
        return self._vision.look(self._window.lastPicture(), self._matrix)

    def restart(self):
        """Forgets what was seen: the simulation was reset."""
        self._looked = None
        self._vision.restart()


class SliderDriver:
    """Cruise control on, the mouse on the slider, at most five changes a second."""

    name = "slider_driver"

    def __init__(self, window):
        self._window, self._hands, self._eyes = window, Hands(window), Eyes(window)
        rate = Number(above=0.0, most=5.0, unit="1/s")  # as a person's
        self._rate = parameter(rospy.get_param, "changes_per_second", 5.0, rate)
        self._changed = self._seen = -math.inf
        self._driving = False

    def act(self):
        """Moves the slider if it is time and the picture says so."""
        now = rospy.get_time()
        if now < max(self._changed, self._seen):  # the simulation was reset
            self._changed, self._seen = -math.inf, now
            self._eyes.restart()
        if now - self._changed < 1.0 / self._rate:
            return
        goal = self._eyes.look() if self._eyes.news() else None
        if goal is None:
            if self._driving and now - self._seen > PATIENCE:
                print("slider_driver: nothing in sight, stop", file=sys.stderr)
                self.rest()
            return
        self._seen = now
        if not self._driving:
            self._hands.toggle_cruise()
            self._hands.grab_slider()
            self._driving = True
        value = round(self._hands.slider_value(towards(*goal)))
        if value != self._window.slider.value():
            self._hands.pull_slider(value)
            self._changed = now

    def rest(self):
        """Lets go: slider released, cruise control off, Stop."""
        if self._driving:
            self._hands.release_slider()
            self._hands.toggle_cruise()
            self._hands.click("Stop")
            self._driving = False


class ButtonsDriver:
    """Roams with the discrete buttons: one click, then it waits for the move's end."""

    name = "buttons_driver"

    def __init__(self, window):
        self._window, self._hands, self._eyes = window, Hands(window), Eyes(window)
        self._wide = math.radians(
            parameter(rospy.get_param, "wide_angle", 22.0, Number(unit="degrees"))
        )
        self._rest_until = 0.0

    def act(self):
        """Clicks the button that leads towards the line, when the last move is over."""
        now = rospy.get_time()
        if self._window.isMoving():
            self._rest_until = now + 0.3  # the car comes to a stand, the picture is new
            return
        if self._rest_until - 1.0 < now < self._rest_until or not self._eyes.news():
            return
        goal = self._eyes.look()
        if goal is None:
            self._hands.click("Backwards")
            return
        bearing = math.atan2(goal[1], goal[0])
        self._hands.click(
            "Forward" if abs(bearing) < self._wide else "Left" if bearing > 0.0 else "Right"
        )

    def rest(self):
        """Clicks Stop."""
        self._hands.click("Stop")


def run(kind):
    """Runs a driver's node until the window is closed; returns its exit code."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    try:
        window = connect(kind.name)
        driver = kind(window)
    except (ConnectionError, ValueError) as error:
        print(f"{kind.name} cannot start: {error}", file=sys.stderr)
        return 1
    timer = QTimer(window)
    timer.timeout.connect(driver.act)
    timer.start(LOOK_MS)
    code = window.executeInterface()
    timer.stop()
    driver.rest()
    time.sleep(0.1)  # the publisher's queue is emptied by a thread of its own
    rospy.signal_shutdown("the window was closed")
    return code
