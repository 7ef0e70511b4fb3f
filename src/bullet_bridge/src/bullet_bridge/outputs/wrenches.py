"""Plugins that measure and apply forces, or put joints somewhere."""

import math

import numpy as np
import rospy
from bullet_sim.errors import SimError
from bullet_sim.pose import Pose
from bullet_sim.sensors.inertial import joint_wrench, net_wrench
from geometry_msgs.msg import Vector3, WrenchStamped
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory

from bullet_bridge.outputs.sensors import DifferenceOutput, Output
from bullet_bridge.transport import conversions


def wrench_message(time, frame, force, torque):
    """geometry_msgs/WrenchStamped of two (3,) [N, N m]."""
    message = WrenchStamped()
    message.header.stamp, message.header.frame_id = conversions.stamp(time), frame
    message.wrench.force = Vector3(*map(float, force))
    message.wrench.torque = Vector3(*map(float, torque))
    return message


class ForceTorqueOutput(Output):
    """geometry_msgs/WrenchStamped of a joint: its child link on its parent, child's axes."""

    message = WrenchStamped

    def update(self, time):
        wrench = joint_wrench(self.model, self.spec.joint)
        if self.spec.noise_stddev:
            wrench = [v + self.rng.normal(0.0, self.spec.noise_stddev, 3) for v in wrench]
        self.publisher.publish(wrench_message(time, self.spec.frame_id, *wrench))


class LinkForceOutput(DifferenceOutput):
    """geometry_msgs/WrenchStamped of the net force on a link, mean over a step, world axes."""

    message = WrenchStamped

    def update(self, time):
        part = self.model.description.links[self.spec.link]
        pose, linear, angular = self.model.link_state(self.spec.link)
        speed = linear + np.cross(angular, pose.matrix @ part.centre)
        before, self._before = self._before, (speed, angular, time)
        if before is None or not time > before[2]:
            return
        inertia = pose.matrix @ part.inertia @ pose.matrix.T
        wrench = net_wrench(part.mass, inertia, before[:2], (speed, angular), time - before[2])
        self.publisher.publish(wrench_message(time, self.spec.frame_id, *wrench))


class HandOfGodOutput(Output):
    """Pulls a link to the frame FRAME_desired by a critically damped spring; sends FRAME_actual."""

    message = TFMessage
    reports = False
    every_step = True

    def __init__(self, world, model, spec, seed):
        super().__init__(world, model, spec, seed)
        index, _ = model.link_in_body(spec.link)
        part = next(p for n, p in model.rigid_parts.items() if model.index(n) == index)
        self._index = index
        self._damping = (
            2.0 * math.sqrt(spec.linear * part.mass),
            2.0 * math.sqrt(spec.angular * part.inertia[0, 0]),
        )
        self._buffer = self._listener = None
        self._missing = False

    def attach(self, arrivals):
        import tf2_ros  # takes a while, and few models need it

        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)

    def has_subscribers(self):
        """True: it pulls with and without subscribers."""
        return True

    def _desired(self):
        """Pose to pull to, or None, said once."""
        from tf2_ros import TransformException

        try:
            found = self._buffer.lookup_transform(
                "world", f"{self.spec.frame}_desired", rospy.Time(0)
            ).transform
        except TransformException as error:
            if not self._missing:
                rospy.logerr("hand of god: %s", error)
            self._missing = True
            return None
        self._missing = False
        p, q = found.translation, found.rotation
        return Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))

    def update(self, time):
        desired = self._desired()
        if desired is None:
            return
        pose, linear, angular = self.model.link_state(self.spec.link)
        away = np.subtract(desired.position, pose.position)
        x, y, z, w = (pose.inverse() * desired).orientation
        sign = -1.0 if w < 0.0 else 1.0
        sine = math.sqrt(x * x + y * y + z * z)
        half = math.atan2(sine, sign * w) / sine if sine > 1e-12 else 1.0
        turn = sign * half * np.array((x, y, z))  # half the rotation vector, as upstream takes it
        force = self.spec.linear * away - self._damping[0] * linear
        torque = pose.matrix @ (self.spec.angular * turn) - self._damping[1] * angular
        self.model.apply_wrench(self._index, force, torque)
        if self.publisher.get_num_connections() > 0:
            actual = f"{self.spec.frame}_actual"
            message = conversions.transform_to_msg(time, "world", actual, pose)
            self.publisher.publish(TFMessage([message]))

    def close(self):
        super().close()
        if self._listener is not None:
            self._listener.unregister()


class JointPosesOutput(Output):
    """Puts joints to the points of a trajectory_msgs/JointTrajectory, one after the other.

    As upstream, each point waits for the time_from_start of the point before it, counted from then.
    """

    message = JointTrajectory
    reports = False
    every_step = True

    def __init__(self, world, model, spec, seed):
        self._subscriber, self._next = None, 0.0
        super().__init__(world, model, spec, seed)
        self.publisher.unregister()  # it only listens

    def attach(self, arrivals):
        self._subscriber = arrivals.subscribe(self.spec.topic, JointTrajectory, self._on_trajectory)

    def restart(self):
        super().restart()
        self._points, self._next = [], 0.0

    def has_subscribers(self):
        """While there are points to come."""
        return bool(self._points)

    def _on_trajectory(self, message):
        known = set(self.model.joints.names)
        points = []
        for point in message.points:
            values = dict(zip(message.joint_names, point.positions))
            if len(point.positions) != len(message.joint_names):
                rospy.logerr(
                    "%s: a point has %d positions, must have %d",
                    self.spec.topic,
                    len(point.positions),
                    len(message.joint_names),
                )
                return
            mine = {name: value for name, value in values.items() if name in known}
            points.append((mine, point.time_from_start.to_sec()))
        self._next = message.header.stamp.to_sec()
        self._points = points

    def update(self, time):
        if not self._points or time < self._next:
            return
        values, wait = self._points.pop(0)
        try:
            self.model.joints.set_positions(values)
        except SimError as error:
            rospy.logerr("%s: %s", self.spec.topic, error)
        self._next = max(time, self._next) + wait

    def close(self):
        if self._subscriber is not None:
            self._subscriber.unregister()
