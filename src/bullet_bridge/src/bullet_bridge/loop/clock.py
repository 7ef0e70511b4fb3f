"""/clock: its schedule and its publisher."""

import rospy
from rosgraph_msgs.msg import Clock

from bullet_bridge.loop.schedule import Schedule
from bullet_bridge.transport.conversions import stamp
from bullet_bridge.transport.packed import PackedClock
from bullet_bridge.transport.publishing import publisher


def set_own_time(now):
    """Set rospy's time in this process, as a subscription to /clock would."""
    rospy.rostime._rostime_current = now


class SimClock:
    """Publishes simulated time, at times k / rate and on request.

    Attributes:
        next: physics step after which the next message is due.

    Args:
        rate: messages per simulated second [Hz].
        time_step: physics step [s].
        send: function of a simulated time [s], instead of the topic /clock (tests).
        own: function of a rospy.Time that sets the time of this process.
    """

    def __init__(self, rate, time_step, send=None, own=None):
        self._own = own
        if send is None:
            send = PackedClock(publisher("/clock", Clock, latch=True)).send
        self._send = send
        self._rate = rate
        self.set_time_step(time_step, 0)

    @property
    def next(self):
        """Physics step after which the next message is due."""
        return self._schedule.next

    def set_time_step(self, time_step, step):
        """Continue after a step with another physics step [s]; at most one message per step."""
        self._schedule = Schedule(min(self._rate, 1.0 / time_step), time_step, step)

    def restart(self, step):
        """Count on from a step."""
        self._schedule.restart(step)

    def skip(self, steps):
        """Skip messages due less than so many steps after the last one."""
        self._schedule.skip(steps)

    def publish_due(self, step, time):
        """Publish the time [s] if it is due at this step; returns whether it was."""
        if not self._schedule.due(step):
            return False
        self.publish(time)
        return True

    def publish(self, time):
        """Publish the time [s] now."""
        if self._own is not None:
            self._own(stamp(time))
        self._send(time)
