"""Model plugins that report joints or move wheels: joint states, diff drive, skid steer."""

import rospy
from bullet_sim.controllers import MAX_COMMAND
from bullet_sim.controllers.drive import WheelDrive
from bullet_sim.sensors import inertial
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from paddock_common.odometry import transform_of
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
    """Drives the wheels by geometry_msgs/Twist, publishes nav_msgs/Odometry and its transform.

    A command acts from the next update until the next command, as in Gazebo's plugins.
    """

    message = Odometry

    def __init__(self, world, model, spec, seed):
        self._drive = WheelDrive(spec)
        self._wheels = [
            [model.joints.index(name) for name in names] for names in (spec.left, spec.right)
        ]
        super().__init__(world, model, spec, seed)
        self._transform = publisher("/tf", TFMessage) if spec.publish_tf else None
        topic = spec.wheel_states_topic
        self._wheel_states = publisher(topic, JointState) if topic else None
        self._wheel_frames = publisher("/tf", TFMessage) if spec.wheel_transforms else None
        self._wheel_names = [*spec.left, *spec.right]
        self._subscriber = None

    def attach(self, arrivals):
        self._subscriber = arrivals.subscribe(self.spec.command_topic, Twist, self._on_command)

    def restart(self):
        super().restart()
        self._command, self._before = (0.0, 0.0), None
        self._drive.restart()

    def _on_command(self, message):
        command = command_of(self.spec.command_topic, (message.linear.x, message.angular.z))
        if command is not None:
            self._command = command

    def has_subscribers(self):
        """True: the wheels are driven with and without subscribers."""
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
        self._publish_wheels(time)
        outputs = [
            out
            for out in (self.publisher, self._transform)
            if out is not None and out.get_num_connections() > 0
        ]
        if not outputs:
            return
        message = self._odometry(time)
        for out in outputs:
            transform = out is self._transform
            out.publish(TFMessage([transform_of(message)]) if transform else message)

    def _publish_wheels(self, time):
        """Positions of the wheels, and their frames below the links that carry them."""
        states, frames, names = self._wheel_states, self._wheel_frames, self._wheel_names
        if states is not None and states.get_num_connections() > 0:
            message = JointState(name=names, position=list(self.model.joints.positions_of(names)))
            message.header.stamp = conversions.stamp(time)
            states.publish(message)
        if frames is not None and frames.get_num_connections() > 0:
            frames.publish(TFMessage([self._wheel_transform(name, time) for name in names]))

    def _wheel_transform(self, name, time):
        joint = self.model.description.joints[name]
        parent, child = (self.model.link_state(link)[0] for link in (joint.parent, joint.child))
        pose = parent.inverse() * child
        return conversions.transform_to_msg(time, joint.parent, joint.child, pose)

    def _odometry(self, time):
        if self.spec.from_wheels:
            pose, (linear, angular) = self._drive.pose, self._drive.twist
        else:
            pose, linear, angular = self.model.link_state(self.spec.link)
            linear, angular = inertial.twist(pose.orientation, linear, angular)
        return odometry_message(time, self.spec, pose, linear, angular)

    def close(self):
        super().close()
        for other in (self._transform, self._wheel_states, self._wheel_frames, self._subscriber):
            if other is not None:
                other.unregister()


def command_of(topic, values):
    """Returns a velocity command, or None, logged, where a number is not usable."""
    if all(abs(value) <= MAX_COMMAND for value in values):
        return tuple(values)
    rospy.logerr_throttle(
        1.0,
        f"{topic}: command {tuple(values)}, must be finite numbers, at most {MAX_COMMAND:g} "
        "either way; the last good one stays",
    )
    return None


def odometry_message(time, spec, pose, linear, angular):
    """nav_msgs/Odometry of a base that moves in the plane.

    Args:
        time: simulated [s].
        spec: has frame_id and child_frame_id.
        pose: Pose in frame_id.
        linear, angular: (3,) [m/s, rad/s] in the child frame.
    """
    message = Odometry(child_frame_id=spec.child_frame_id)
    message.header.stamp = conversions.stamp(time)
    message.header.frame_id = spec.frame_id
    message.pose.pose = conversions.pose_to_msg(pose)
    message.twist.twist = conversions.twist_to_msg(linear, angular)
    for covariance in (message.pose.covariance, message.twist.covariance):
        covariance[::7] = list(PLANAR)
    return message
