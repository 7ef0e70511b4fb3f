"""Simulated time that only the test advances, by /gazebo/step.

The results do not depend on the machine's speed and load.
"""

import rospy
from launches import wait_subscribed
from nav_msgs.msg import Odometry
from sim_client import START_LIMIT, wait_until, world_time
from std_srvs.srv import Empty

from bullet_bridge.srv import Step

PHYSICS_STEP = 0.001  # [s]
LONGEST = 250  # steps in one call


class Time:
    """Pauses the simulation; go() steps it.

    Attributes:
        now: The world's time [s].

    Args:
        commands: Command topics of the world, published by the node under test.
        topics: Topics of the world of which the test must not miss a message.
        node: Name of the node under test.
    """

    def __init__(self, commands=(), topics=(), node="/control"):
        for name in ("pause_physics", "step", "get_world_properties"):
            rospy.wait_for_service("/gazebo/" + name, START_LIMIT)
        rospy.ServiceProxy("/gazebo/pause_physics", Empty)()
        wait_subscribed(topics)
        if commands:
            wait_subscribed(commands, "/gazebo", node)
        self._commands = list(commands)
        self.now = world_time()
        self._step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)

    def go(self, seconds, commands=0):
        """Advances time [s], after so many new messages on each command topic."""
        steps = round(seconds / PHYSICS_STEP)
        topics = self._commands if commands else []
        while steps > 0:
            count = min(steps, LONGEST)
            answer = self._step(count, topics, [commands] * len(topics))
            if not answer.success:
                raise AssertionError(answer.status_message)
            steps, topics = steps - count, []
            self.now += count * PHYSICS_STEP

    def latest(self, recorder, period=0.02):
        """Gives a recorder's message of now.

        Args:
            recorder: Recorder of messages with a header.
            period: Simulated time between two of them [s].
        """
        after = self.now - period + 0.5 * PHYSICS_STEP

        def there():
            last = recorder.last
            return last and last.header.stamp.to_sec() > after and last

        return wait_until(there, f"{recorder.topic} later than {after:g} s")

    def close(self):
        """Lets time go on by itself."""
        self._step.close()
        rospy.ServiceProxy("/gazebo/unpause_physics", Empty)()


def place(raw):
    """x and y [m] of a serialised Odometry."""
    point = Odometry().deserialize(raw).pose.pose.position
    return point.x, point.y
