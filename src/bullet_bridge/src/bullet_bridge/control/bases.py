"""Topics of the controllers of whole bases: velocities in, odometry and its transform out."""

import rospy
from four_wheel_steering_msgs.msg import FourWheelSteering, FourWheelSteeringStamped
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from paddock_common.odometry import transform_of
from tf2_msgs.msg import TFMessage

from bullet_bridge.control import messages as control_messages
from bullet_bridge.control.topics import Commands


class Drive(Commands):
    """geometry_msgs/Twist into the controller of a base, odometry and its transform out."""

    topic = "cmd_vel"

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._odometry = self._publisher(f"{self.name}/odom", Odometry)
        drive = spec.drive
        self._transform = self._publisher("/tf", TFMessage) if drive.publish_tf else None
        self._outputs = [out for out in (self._odometry, self._transform) if out is not None]
        self._schedule = self._every(spec.publish_rate, *self._outputs)
        self._limited = None
        if drive.publish_command:
            self._limited = self._publisher(f"{self.name}/cmd_vel_out", TwistStamped)
            self._limited_schedule = self._every(
                1.0 / robot.manager.control_period(robot.world.time_step), self._limited
            )

    def _kind(self):
        return Twist

    def _on_command(self, message):
        values = (message.linear.x, message.angular.z)
        if self._spec.drive.single_publisher and self._subscriber.get_num_connections() > 1:
            rospy.logerr_throttle(
                1.0,
                f"{self.name}/{self.topic} has more than one publisher, "
                "which allow_multiple_cmd_vel_publishers forbids; it brakes",
            )
            values = (0.0, 0.0)
        self._robot.buffer_command(self._spec.name, values)

    def publish(self, step, time):
        """Publish the odometry of this step and the limited command."""
        if self._limited is not None and self._limited_schedule.due(step):
            self._limited.publish(control_messages.limited_twist(time, *self.controller.limited))
        if not self._schedule.due(step):
            return
        outputs = [out for out in self._outputs if out.get_num_connections()]
        self._robot.manager.observe()
        message = control_messages.drive_odometry(time, self._spec.drive, self.controller.odometry)
        for out in outputs:
            out.publish(message if out is self._odometry else TFMessage([transform_of(message)]))


class FourWheelDrive(Drive):
    """Also takes four_wheel_steering_msgs/FourWheelSteering and publishes it on odom_steer."""

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._endpoints.append(
            robot.arrivals.subscribe(
                f"{self.name}/cmd_four_wheel_steering", FourWheelSteering, self._on_angles
            )
        )
        self._steering = self._publisher(f"{self.name}/odom_steer", FourWheelSteeringStamped)
        self._steering_schedule = self._every(spec.publish_rate, self._steering)

    def _on_angles(self, message):
        values = (message.speed, message.front_steering_angle, message.rear_steering_angle)
        self._robot.buffer_command(self._spec.name, values)

    def publish(self, step, time):
        """Publish the odometry of this step, also as speed and steering angles."""
        super().publish(step, time)
        if self._steering_schedule.due(step):
            self._robot.manager.observe()
            self._steering.publish(
                control_messages.four_wheel_state(
                    time, self._spec.drive.odom_frame, self.controller.odometry
                )
            )
