"""Time that advances only by /gazebo/step: same commands, same bytes; and a reset is a start."""

import math
import unittest

import rospy
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import GetModelState
from launches import Launch, wait_subscribed
from rosgraph_msgs.msg import Clock
from sim_client import (
    START_LIMIT,
    WHEELS,
    Recorder,
    command_publishers,
    wait_connected,
    wait_running,
    wait_until,
    world_time,
)
from std_msgs.msg import Float64
from std_srvs.srv import Empty
from stepping import place

from bullet_bridge.srv import State, Step

LAUNCH = "<launch></launch>"  # a ROS master

TICKS = 30  # of the script
TICK = 50  # physics steps of 1 ms
RATES = {
    "/racecar/joint_states": 50,
    "/racecar/odom": 50,
    "/scan": 10,
    "/camera/image": 30,
    "/bot/joint_states": 100,
    "/bot/odom": 100,
    "/bot/scan": 20,
}  # [Hz]
EXPECTED = {topic: int(rate * TICKS * TICK * 1e-3) for topic, rate in RATES.items()}
SEQ_BYTES = 4  # header.seq, counted by the publisher over its life, opens each message


class World:
    """A running world, a script of commands, and the bytes of all messages."""

    def __init__(self):
        wait_running("/racecar", 7)
        wait_running("/bot", 3)
        self.publishers = {
            f"{'velocity' if name in WHEELS else 'position'}:{name}": publisher
            for name, publisher in command_publishers().items()
        }
        for side in ("left", "right"):
            publisher = rospy.Publisher(f"/bot/{side}/command", Float64, queue_size=10)
            wait_connected(publisher, side)
            self.publishers[f"bot:{side}"] = publisher
        self.recorders = {topic: Recorder(topic, rospy.AnyMsg) for topic in RATES}
        self.clock = Recorder("/clock", Clock)
        wait_subscribed([*RATES, "/clock"])
        rospy.wait_for_service("/gazebo/step", timeout=START_LIMIT)
        self._step = rospy.ServiceProxy("/gazebo/step", Step, persistent=True)

    def step(self, n=1, topics=(), counts=()):
        """Calls the service."""
        return self._step(n, list(topics), list(counts))

    def command(self, tick):
        """Publishes one set of commands; returns the topics."""
        for number, (name, publisher) in enumerate(self.publishers.items()):
            size = 0.3 if name.startswith("position") else 12.0
            publisher.publish(size * math.sin(0.13 * tick + number) + (size > 1) * 6.0)
        return [publisher.name for publisher in self.publishers.values()]

    def run_script(self):
        """Drives both robots around.

        Returns:
            Bytes of all messages by topic.
        """
        for recorder in self.recorders.values():
            recorder.clear()
        for tick in range(TICKS):
            topics = self.command(tick)
            answer = self.step(TICK, topics, [1] * len(topics))
            assert answer.success, answer.status_message
        for topic, recorder in self.recorders.items():
            recorder.wait_count(EXPECTED[topic])
        return {
            topic: [message._buff for message in recorder.messages]
            for topic, recorder in self.recorders.items()
        }

    def close(self):
        """Unregisters everything."""
        for recorder in (*self.recorders.values(), self.clock):
            recorder.close()
        for publisher in self.publishers.values():
            publisher.unregister()
        self._step.close()


def call(name, kind=Empty):
    """Calls a service of the simulator."""
    rospy.wait_for_service("/gazebo/" + name, timeout=START_LIMIT)
    return rospy.ServiceProxy("/gazebo/" + name, kind)()


def without_seq(run):
    """The bytes that do not depend on how often the publisher was used before."""
    return {topic: [raw[SEQ_BYTES:] for raw in messages] for topic, messages in run.items()}


class Lockstep(unittest.TestCase):
    """One world for the service's errors; two for the bytes."""

    def same(self, one, other):
        """Compares two runs message by message."""
        for topic, messages in one.items():
            self.assertEqual(len(messages), EXPECTED[topic], topic)
            self.assertEqual(len(other[topic]), EXPECTED[topic], topic)
            different = [
                number
                for number, pair in enumerate(zip(messages, other[topic]))
                if pair[0] != pair[1]
            ]
            self.assertEqual(different, [], f"{topic}: messages that differ")

    def test_same_script_same_bytes_and_a_reset_is_a_fresh_start(self):
        with Launch("lockstep_world.launch"):
            world = World()
            self.assertEqual(world_time(), 0.0, "spawning and starting cost no simulated time")
            wait_until(lambda: world.clock.last, "/clock, which is latched")
            self.assertEqual(world.clock.last.clock.to_sec(), 0.0)
            first = world.run_script()
            self.manners(world)
            world.close()
        for topic in ("/racecar/odom", "/bot/odom"):
            self.assertGreater(math.dist(place(first[topic][0]), place(first[topic][-1])), 0.1)
        for topic in ("/scan", "/camera/image"):
            self.assertGreater(
                len({raw[SEQ_BYTES + 8 :] for raw in first[topic]}),
                EXPECTED[topic] // 2,
                f"{topic} changes on the way",
            )
        with Launch("lockstep_world.launch"):
            world = World()
            second = world.run_script()
            self.same(first, second)
            call("reset_simulation")
            self.assertEqual(world_time(), 0.0)
            wait_until(lambda: world.clock.last.clock.to_sec() == 0.0, "/clock at 0")
            again = world.run_script()
            self.same(without_seq(first), without_seq(again))
            self.goes_on_from_a_saved_state(world)
            world.close()

    def goes_on_from_a_saved_state(self, world):
        """Saved while both robots drive: going on twice gives the same bytes, noise included."""
        save, restore = (
            rospy.ServiceProxy(f"/gazebo/{name}_state", State) for name in ("save", "restore")
        )
        start = world_time()
        self.assertIn(f"saved 'driving' at {start:.3f} s", save("driving").status_message)
        on = world.run_script()
        answer = restore("driving")
        self.assertTrue(answer.success, answer.status_message)
        self.assertEqual(answer.status_message, f"restored 'driving', it is {start:.3f} s")
        self.assertEqual(world_time(), start)
        self.same(without_seq(on), without_seq(world.run_script()))
        for call_it, name, reason in (
            (restore, "other", "state 'other' does not exist; saved are driving"),
            (save, "", "a state needs a name"),
        ):
            answer = call_it(name)
            self.assertFalse(answer.success)
            self.assertIn(reason, answer.status_message)

    def manners(self, world):
        """Requests that the step service and lockstep refuse; time does not advance."""
        start = world_time()
        self.assertAlmostEqual(start, TICKS * TICK * 1e-3, places=9)
        wait_until(lambda: world.clock.last.clock.to_sec() == start, "/clock at the last step")
        with self.assertRaisesRegex(rospy.ServiceException, "only by /gazebo/step"):
            call("unpause_physics")
        call("pause_physics")
        wheel = "/racecar/left_rear_wheel_velocity_controller/command"
        for request, reason in (
            ((0, [], []), "n is 0"),
            ((1, [wheel], []), "1 topics and 0 counts"),
            ((1, ["/wrong"], [1]), "'/wrong' is not subscribed"),
            ((1, [wheel], [3]), f"{wheel}: 0 of 3"),
        ):
            answer = world.step(*request)
            self.assertFalse(answer.success)
            self.assertIn(reason, answer.status_message)
        counts = {topic: len(recorder.messages) for topic, recorder in world.recorders.items()}
        self.assertEqual(counts, EXPECTED, "nothing comes while time stands")
        self.assertEqual(world_time(), start)
        publisher = next(p for p in world.publishers.values() if p.name == wheel)
        for _ in range(3):
            publisher.publish(1.0)
        self.assertTrue(world.step(1, [wheel], [3]).success, "three in a burst are three")
        self.assertAlmostEqual(world_time(), start + 0.001, places=9)
        self.place_by_topic(world)

    def place_by_topic(self, world):
        """A model that is placed by topic is there before the step that counted the message."""
        publisher = rospy.Publisher("/gazebo/set_model_state", ModelState, queue_size=1)
        wait_connected(publisher, "set_model_state")
        state = ModelState(model_name="a_bot", reference_frame="world")
        state.pose.position.x, state.pose.position.z, state.pose.orientation.w = 2.0, 1.0, 1.0
        publisher.publish(state)
        self.assertTrue(world.step(1, ["/gazebo/set_model_state"], [1]).success)
        rospy.wait_for_service("/gazebo/get_model_state", timeout=START_LIMIT)
        found = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)("a_bot", "")
        self.assertAlmostEqual(found.pose.position.x, 2.0, places=6)
        self.assertAlmostEqual(found.pose.position.z, 1.0, places=3)
        publisher.unregister()
