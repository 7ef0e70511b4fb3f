"""Model plugins that report joints or move wheels: joint states, diff drive, skid steer."""

import rospy
from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.controllers.drive.plugin import WheelDrive
from bullet_sim.sensors import ground_truth
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from bullet_bridge.outputs.sensors import Output
from bullet_bridge.transport import conversions
from bullet_bridge.transport.publishing import publisher

PLANAR = (1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3)  # variances of a base's odometry


class JointStatesOutput(Output):
    """sensor_msgs/JointState of the named joints, without efforts."""

    message = JointState

    def update(self, time):
        positions, velocities = self.model.joints.state()
        message = JointState(
            name=list(self.spec.joints),
            position=[positions[name] for name in self.spec.joints],
            velocity=[velocities[name] for name in self.spec.joints],
        )
        message.header.stamp = conversions.stamp(time)
        self.publisher.publish(message)


class WheelDriveOutput(Output):
    """Takes geometry_msgs/Twist, turns the wheels, gives nav_msgs/Odometry and its transform.

    The latest command counts from the next update on and stays until another comes, as in
    Gazebo's plugins.
    """

    message = Odometry

    def __init__(self, world, model, spec, seed):
        self._drive = WheelDrive(spec)
        self._wheels = [
            [model.joints.index(name) for name in names] for names in (spec.left, spec.right)
        ]
        super().__init__(world, model, spec, seed)
        self._transform = publisher("/tf", TFMessage) if spec.publish_tf else None
        self._subscriber = None

    def attach(self, arrivals):
        self._subscriber = arrivals.subscribe(self.spec.command_topic, Twist, self._take)

    def restart(self):
        super().restart()
        self._command, self._before = (0.0, 0.0), None
        self._drive.restart()

    def _take(self, message):
        command = (message.linear.x, message.angular.z)
        if not all(abs(value) <= MAX_COMMAND for value in command):
            rospy.logerr_throttle(
                1.0,
                f"{self.spec.command_topic}: command {command}, must be "
                f"finite numbers, at most {MAX_COMMAND:g} either way; the last "
                "good one stays",
            )
            return
        self._command = command

    def listened(self):
        return True

    def update(self, time):
        elapsed = 0.0 if self._before is None else time - self._before
        self._before = time
        for wheels, speed in zip(self._wheels, self._drive.wheel_speeds(*self._command, elapsed)):
            for joint in wheels:
                self.world.engine.drive_velocity(self.model.body, joint, speed, self.spec.torque)
        if self.spec.from_wheels:
            angles = self.model.joints.positions_of((self.spec.left[0], self.spec.right[0]))
            self._drive.measure(*angles, elapsed)
        wires = [
            wire
            for wire in (self.publisher, self._transform)
            if wire is not None and wire.get_num_connections() > 0
        ]
        if not wires:
            return
        message = self._odometry(time)
        for wire in wires:
            wire.publish(message if wire is self.publisher else _transform(message))

    def _odometry(self, time):
        if self.spec.from_wheels:
            pose, (linear, angular) = self._drive.pose, self._drive.twist
        else:
            pose, linear, angular = self.model.link_state(self.spec.link)
            linear, angular = ground_truth.twist(pose.orientation, linear, angular)
        message = Odometry(child_frame_id=self.spec.child_frame_id)
        message.header.stamp = conversions.stamp(time)
        message.header.frame_id = self.spec.frame_id
        message.pose.pose = conversions.pose_to_msg(pose)
        message.twist.twist = conversions.twist_to_msg(linear, angular)
        for covariance in (message.pose.covariance, message.twist.covariance):
            covariance[::7] = list(PLANAR)
        return message

    def close(self):
        super().close()
        if self._transform is not None:
            self._transform.unregister()
        if self._subscriber is not None:
            self._subscriber.unregister()


def _transform(odometry):
    """tf2_msgs/TFMessage that says the same as an Odometry."""
    message = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    message.transform.rotation = odometry.pose.pose.orientation
    place = odometry.pose.pose.position
    message.transform.translation.x, message.transform.translation.y = place.x, place.y
    message.transform.translation.z = place.z
    return TFMessage([message])
