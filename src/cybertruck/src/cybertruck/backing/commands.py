"""Drive commands to the truck."""

import rospy

from cybertruck.msg import CyberDriveStamped


class Driver:
    """Publishes /cmd_cyberdrive."""

    def __init__(self):
        self._publisher = rospy.Publisher(
            "/cmd_cyberdrive", CyberDriveStamped, queue_size=1, tcp_nodelay=True
        )
        self._steering = 0.0
        rospy.on_shutdown(self.stop)

    def send(self, steering, speed):
        """Sends a steering angle [rad] and a speed [m/s]."""
        message = CyberDriveStamped()
        message.header.stamp = rospy.Time.now()
        message.drive.steering_angle, message.drive.speed = float(steering), float(speed)
        self._steering = float(steering)
        try:
            self._publisher.publish(message)
        except rospy.ROSException:
            if (
                not rospy.is_shutdown()
            ):  # at shutdown the topic is closed; the shutdown hook has stopped the truck
                raise

    def stop(self):
        """Sends speed 0; the steering stays where it is."""
        self.send(self._steering, 0.0)

    @property
    def subscribers(self):
        """Number of subscribers."""
        return self._publisher.get_num_connections()
