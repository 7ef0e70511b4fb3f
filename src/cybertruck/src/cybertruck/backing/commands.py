"""Drive commands to the truck."""

import threading

import rospy
from paddock_common.sending import flush

from cybertruck.msg import CyberDriveStamped


class Driver:
    """Publishes /cmd_cyberdrive."""

    def __init__(self):
        self._publisher = rospy.Publisher(
            "/cmd_cyberdrive", CyberDriveStamped, queue_size=1, tcp_nodelay=True
        )
        self._steering = 0.0
        self._lock, self._ended = threading.RLock(), False
        rospy.on_shutdown(self._end)

    def send(self, steering, speed):
        """Sends a steering angle [rad] and a speed [m/s]."""
        message = CyberDriveStamped()
        message.header.stamp = rospy.Time.now()
        message.drive.steering_angle, message.drive.speed = float(steering), float(speed)
        self._steering = float(steering)
        with self._lock:
            if not self._ended:
                self._publisher.publish(message)

    def stop(self):
        """Sends speed 0; the steering stays where it is."""
        self.send(self._steering, 0.0)

    def _end(self):
        """Stops the truck at shutdown; nothing follows, rospy closes the topic next."""
        with self._lock:
            self.stop()
            self._ended = True
        flush(self._publisher)

    @property
    def subscribers(self):
        """Number of subscribers."""
        return self._publisher.get_num_connections()
