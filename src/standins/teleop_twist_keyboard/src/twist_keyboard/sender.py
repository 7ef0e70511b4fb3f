"""Publishes the latest velocity: when it changes, and again and again if wished."""

import threading

import rospy
from geometry_msgs.msg import Twist, TwistStamped
from paddock_common.waiting import flush


class Sender:
    """A thread that publishes cmd_vel.

    Args:
        repeat_rate: Messages per second of wall time while nothing changes [Hz]; 0: none.
        stamped: Whether to publish geometry_msgs/TwistStamped.
        frame: frame_id of those.
    """

    def __init__(self, repeat_rate=0.0, stamped=False, frame=""):
        self._stamped, self._frame = stamped, frame
        self.publisher = rospy.Publisher(
            "cmd_vel", TwistStamped if stamped else Twist, queue_size=1
        )
        self._period = 1.0 / repeat_rate if repeat_rate else None
        self._condition = threading.Condition()
        self._velocity, self._waiting, self._ended = None, False, False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def send(self, velocity):
        """Publishes (forward, left, up [m/s], turn [rad/s])."""
        with self._condition:
            self._velocity, self._waiting = velocity, True
            self._condition.notify()

    def close(self):
        """Publishes zeros and ends the thread."""
        with self._condition:
            self._ended = True
            self._condition.notify()
        self._thread.join()
        self._publish((0.0, 0.0, 0.0, 0.0))
        flush(self.publisher)

    def _run(self):
        while True:
            with self._condition:
                if not (self._waiting or self._ended):
                    self._condition.wait(self._period)
                if self._ended:
                    return
                self._waiting, velocity = False, self._velocity
            if velocity is not None:
                self._publish(velocity)

    def _publish(self, velocity):
        twist = Twist()
        twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.z = velocity
        if self._stamped:
            message = TwistStamped(twist=twist)
            message.header.stamp = rospy.Time.now()
            message.header.frame_id = self._frame
            twist = message
        self.publisher.publish(twist)
