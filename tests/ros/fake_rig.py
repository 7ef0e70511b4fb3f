"""A truck with trailer that exists in kinematics only: /clock, /odom and /joint_states from a test.

It follows /cmd_cyberdrive; a test can make it stop publishing, stand still or publish wrong values.
"""

import math
import threading
import time

import numpy as np
import rospy
from cybertruck.trailer.geometry import Geometry
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from sim_client import wait_connected
from trailer_sim import advance

from cybertruck.msg import CyberDriveStamped

STEP = 0.01  # simulated time of a step [s]
PACE = 0.002  # least wall time of a step while somebody commands it [s]
IDLE = 0.03  # wall time of a step else [s]: a busy machine has three times a time-out
LAG = 10  # steps that it goes on when commands that came fail to come
PATIENCE = 30.0  # wall time for which it then waits [s]


class FakeRig:
    """Publishes in a thread of its own, as fast as whoever drives it sends commands."""

    def __init__(self, hitch_angle=0.0):
        """Starts at the origin with a hitch angle [rad]."""
        self.geometry = Geometry()
        self.odometry_on = self.joints_on = True
        self.brakes_on = False
        self.hitch_offset = 0.0  # added to what is published [rad]
        self.lock = threading.Lock()
        self.time = 10.0
        self.state = np.array((0.0, 0.0, 0.0, hitch_angle))
        self.command = (0.0, 0.0)
        self.commands = []  # (stamp [s], steering [rad], speed [m/s])
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._odometry = rospy.Publisher("/odom", Odometry, queue_size=10)
        self._joints = rospy.Publisher("/joint_states", JointState, queue_size=10)
        self._drive = rospy.Subscriber(
            "/cmd_cyberdrive", CyberDriveStamped, self._on_drive, queue_size=10
        )
        self._made, self._heard = 0, None  # steps; their count at the last command, None: silence
        self._running = True
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def wait(self):
        """Waits until somebody has subscribed."""
        for publisher in (self._odometry, self._joints):
            wait_connected(publisher, "the action's node")

    def close(self):
        """Ends the thread."""
        self._running = False
        self._thread.join()

    def place(self, hitch_angle, time=None):
        """Puts the rig back to the origin with a hitch angle [rad], and sets the time [s]."""
        with self.lock:
            self.state = np.array((0.0, 0.0, 0.0, hitch_angle))
            self.command = (0.0, 0.0)
            self.time = self.time if time is None else time
            self.commands.clear()

    def _on_drive(self, message):
        with self.lock:
            self.command = message.drive.steering_angle, message.drive.speed
            self.commands.append((message.header.stamp.to_sec(), *self.command))
            self._heard = self._made if self.command[1] else None

    def _run(self):
        while self._running:
            with self.lock:
                self.time += STEP
                steering, speed = self.command
                speed = 0.0 if self.brakes_on else speed
                self.state = advance(
                    self.state,
                    speed,
                    math.tan(steering) / self.geometry.wheelbase,
                    STEP,
                    self.geometry,
                )
                self._publish(speed)
                self._made += 1
            time.sleep(IDLE if self._silence() is None else PACE)
            self._wait()

    def _silence(self):
        """Steps since the last command; None while none is to come."""
        heard = self._heard
        is_driven = heard is not None and self.odometry_on and self.joints_on
        return self._made - heard if is_driven else None

    def _wait(self):
        """Waits while commands that came before fail to come: a busy machine is no fault."""
        deadline = time.monotonic() + PATIENCE
        while self._running and (self._silence() or 0) > LAG:
            if time.monotonic() > deadline:
                self._heard = None
            time.sleep(PACE)

    def _publish(self, speed):
        stamp = rospy.Time.from_sec(self.time)
        self._clock.publish(stamp)
        if self.odometry_on:
            message = Odometry()
            message.header.stamp, message.header.frame_id = stamp, "odom"
            pose = message.pose.pose
            pose.position.x, pose.position.y = self.state[:2]
            pose.orientation.z = math.sin(0.5 * self.state[2])
            pose.orientation.w = math.cos(0.5 * self.state[2])
            message.twist.twist.linear.x = speed
            self._odometry.publish(message)
        if self.joints_on:
            message = JointState(
                name=["front_left_steer_joint", "hitch_yaw_joint"],
                position=[0.0, self.state[3] + self.hitch_offset],
            )
            message.header.stamp = stamp
            self._joints.publish(message)
