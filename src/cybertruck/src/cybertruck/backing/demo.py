"""The node `back_demo`: backs along a shape by the action, and writes plot, CSV and key figures.

The drive is measured on /ground_truth/odom, not on the controller's odometry.
"""

import json
import math
import os
import sys
import threading

import actionlib
import numpy as np
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from paddock_common.geometry import pose_of

from cybertruck.backing.server import Driver, path_of, settings_from
from cybertruck.backing.state import StateSource
from cybertruck.msg import BackUpAction, BackUpGoal
from cybertruck.trailer.geometry import TrailerError
from cybertruck.trailer.report import summary, table, write_csv, write_figure
from cybertruck.trailer.shapes import SHAPES, make_shape
from paddock_common import nodes

START_LIMIT = 60.0  # wall time until truck and action are up [s]
STEP_LIMIT = 20.0  # wall time without a new state after which the demo fails [s]
SETTLE = 1.0  # simulated time after the start [s]
SWERVE = (0.35, 0.4, 1.6)  # before a line: steering angle [rad], speed [m/s], distance [m]
OFFSET = 0.5  # lateral distance of the line [m]


class Demo:
    """Drives one shape and writes the report.

    Raises:
        TrailerError: The shape does not exist, or a parameter is wrong.
    """

    def __init__(self):
        self._settings = settings_from(rospy.get_param("~", {}))
        self._shape = str(rospy.get_param("~shape", "line"))
        if self._shape not in SHAPES:
            raise TrailerError(f"shape '{self._shape}': there are {', '.join(SHAPES)}")
        self._size = [float(text) for text in str(rospy.get_param("~size", "")).split()]
        make_shape(self._shape, tuple(self._size))
        self._speed = float(rospy.get_param("~speed", 0.0))
        self._out = str(rospy.get_param("~out_dir"))
        self._truth = StateSource("/ground_truth/odom", self._settings.node.hitch_joint)
        self._driver = Driver()
        self._client = actionlib.SimpleActionClient("back_up", BackUpAction)

    def run(self):
        """Drives and reports.

        Returns:
            Whether the action succeeded.

        Raises:
            TrailerError: A topic or the action is missing, or the goal was refused.
        """
        rospy.wait_for_message("/odom", Odometry, START_LIMIT)
        if self._wait(None) is None or not self._client.wait_for_server(
            rospy.Duration(START_LIMIT)
        ):
            raise TrailerError("truck or action are not up")
        rospy.sleep(SETTLE)
        start = self._wait(None).trailer(self._settings.geometry)
        goal = self._goal(start)
        finished, rows = threading.Event(), []
        self._client.send_goal(goal, done_cb=lambda *_: finished.set())
        state = None
        while not finished.is_set():
            state = self._wait(None if state is None else state.stamp + 0.019)
            if state is None and not finished.is_set():
                raise TrailerError(f"no new state for {STEP_LIMIT:g} s")
            if state is not None:
                rows.append(state)
        result = self._client.get_result()
        rospy.loginfo("backing %s: %s", self._shape, result.message)
        if self._client.get_state() == GoalStatus.REJECTED or len(rows) < 2:
            raise TrailerError(f"the goal was not driven: {result.message}")
        self._report(goal, rows, result)
        return result.success

    def _wait(self, after):
        return self._truth.wait(after, START_LIMIT if after is None else STEP_LIMIT)

    def _goal(self, start):
        """Makes the goal; for a line the truck first swerves away from it."""
        goal = BackUpGoal(speed=self._speed)
        if self._shape != "line":
            goal.shape, goal.size = self._shape, self._size
            return goal
        steering, speed, distance = SWERVE
        start_state = self._wait(None)
        state = start_state
        while math.hypot(state.x - start_state.x, state.y - start_state.y) < distance:
            self._driver.send(steering, speed)
            state = self._wait(state.stamp + 0.019)
            if state is None:
                raise TrailerError("the truck does not move")
        self._driver.stop()
        path = self._line(start)
        goal.path.header.frame_id = self._settings.node.odom_frame
        for arc in np.arange(0.0, path.length + 0.05, 0.1):
            x, y, _, _ = path.sample(min(arc, path.length))
            goal.path.poses.append(PoseStamped(pose=pose_of(x, y)))
        return goal

    def _line(self, start):
        """The line, to the left of the truck's start pose."""
        x, y, heading = start
        length = self._size[0] if self._size else 12.0
        x, y = x - OFFSET * math.sin(heading), y + OFFSET * math.cos(heading)
        x, y = x + 1.5 * math.cos(heading), y + 1.5 * math.sin(heading)
        return make_shape("line", (length,)).moved(x, y, heading + math.pi)

    def _report(self, goal, states, result):
        """Writes back_SHAPE.png, .csv and .json."""
        driven = goal.path
        if not driven.poses:
            driven = rospy.wait_for_message("/back_up/path", PathMessage, STEP_LIMIT)
        path = path_of(driven)
        rows = table(
            path,
            [item.stamp for item in states],
            [(item.x, item.y, item.heading, item.hitch_angle) for item in states],
            [item.speed for item in states],
            self._settings.geometry,
        )
        figures = summary(rows, path)
        name = os.path.join(self._out, f"back_{self._shape}")
        os.makedirs(self._out, exist_ok=True)
        write_csv(name + ".csv", rows)
        write_figure(
            name + ".png",
            rows,
            path,
            self._settings.geometry,
            f"backing: {self._shape}, {result.message}",
        )
        about = {"ok": bool(result.success), "shape": self._shape, "message": result.message}
        with open(name + ".json", "w") as stream:
            stream.write(json.dumps({**about, **figures}, indent=2) + "\n")
        for key, value in figures.items():
            if value is not None:
                rospy.loginfo("%s: %.4f", key, value)
        rospy.loginfo("written: %s.png, .csv, .json", name)


def main():
    """Runs the demonstration; exit status 0 if the trailer arrived."""
    nodes.init_interruptible("back_demo")
    try:
        success = Demo().run()
    except (TrailerError, ValueError, KeyError, OSError, rospy.ROSException) as error:
        rospy.logfatal("back_demo: %s", error)
        sys.exit(1)
    sys.exit(0 if success else 1)
