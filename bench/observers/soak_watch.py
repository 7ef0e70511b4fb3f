"""soak_watch: counts messages of all topics of a soak; answers {"what": "sample"}."""

import struct
import threading
import time

import rospy

from observers import graph

TOPICS = (
    "/clock",
    "/racecar/odom",
    "/racecar/joint_states",
    "/scan",
    "/camera/image",
    "/cybertruck/joint_states",
    "/trailer_scan",
    "/odom",
    "/tf",
)


class Counter:
    """Counts the messages of a topic; of /clock also the newest time."""

    def __init__(self, topic):
        self.count, self.time, self._topic = 0, 0.0, topic
        rospy.Subscriber(topic, rospy.AnyMsg, self._take, buff_size=1 << 22, tcp_nodelay=True)

    def _take(self, message):
        self.count += 1
        if self._topic == "/clock":
            seconds, nanoseconds = struct.unpack_from("<II", message._buff, 0)
            self.time = seconds + 1e-9 * nanoseconds


def main():
    """Counts until the soak closes its end."""
    graph.join()
    threading.stack_size(1 << 18)
    counters = {topic: Counter(topic) for topic in TOPICS}
    while True:
        graph.hear_json()
        graph.say(
            wall=time.monotonic(),
            simulated=counters["/clock"].time,
            counts={topic: counter.count for topic, counter in counters.items()},
            complete=all(counter.count > 0 for counter in counters.values()),
        )
