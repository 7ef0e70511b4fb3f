"""Commands through the mux and the relay, the ROS's own nodes.

Time is simulated and stands still unless a test sets it.
"""

import unittest

from actionlib import SimpleActionClient
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from launches import wait_subscribed
from sensor_msgs.msg import Image
from sim_client import Recorder, wait_connected, wait_until
from standins_rig import SetClock, publisher, twist
from std_msgs.msg import Bool
from tf2_msgs.msg import TFMessage
from twist_mux_msgs.msg import JoyPriorityAction, JoyPriorityGoal
from visualization_msgs.msg import Marker

LAUNCH = """<launch>
  <param name="/use_sim_time" value="true"/>

  <group ns="mux">
    <node pkg="twist_mux" type="twist_mux" name="twist_mux" output="screen">
      <rosparam>
        topics:
          - {name: low, topic: low_vel, timeout: 0.5, priority: 10}
          - {name: broken, topic: broken_vel, timeout: soon, priority: 10}
          - {name: high, topic: high_vel, timeout: 0.5, priority: 100}
        locks:
          - {name: pause, topic: pause, timeout: 0.0, priority: 50}
      </rosparam>
      <remap from="cmd_vel_out" to="/mux/out"/>
    </node>
    <node pkg="twist_mux" type="joystick_relay.py" name="joystick_relay" output="screen">
      <rosparam command="load" file="$(find twist_mux)/config/joystick.yaml"/>
    </node>
    <node pkg="twist_mux" type="twist_marker" name="twist_marker">
      <remap from="twist" to="/mux/out"/>
    </node>
  </group>

  <!-- The ROS's own. -->
  <node pkg="topic_tools" type="relay" name="relay" args="/mux/out /relayed"/>
  <node pkg="image_transport" type="republish" name="republish"
        args="raw in:=/picture raw out:=/picture_again"/>
  <node pkg="tf" type="static_transform_publisher" name="mount"
        args="1 2 3 0 0 0 world camera 50"/>

</launch>
"""


class Nodes(unittest.TestCase):
    """One test for each package."""

    @classmethod
    def setUpClass(cls):
        cls.clock = SetClock()

    def state_of(self, diagnostics, *words):
        """Whether the mux' last report holds all (key, start of the value)."""
        reports = [s for m in diagnostics.messages for s in m.status if "Twist mux" in s.name]
        values = {item.key: item.value for item in reports[-1].values} if reports else {}
        return all(values.get(key, "").startswith(value) for key, value in words)

    def wait_state(self, diagnostics, *words):
        wait_until(lambda: self.state_of(diagnostics, *words), f"the mux to report {words}")

    def test_twist_mux(self):
        diagnostics, out = Recorder("/diagnostics", DiagnosticArray), Recorder("/mux/out", Twist)
        markers, relayed = Recorder("/mux/marker", Marker), Recorder("/relayed", Twist)
        for recorder in (diagnostics, out, markers, relayed):
            self.addCleanup(recorder.close)
        low, high = publisher("/mux/low_vel", Twist), publisher("/mux/high_vel", Twist)
        pause = publisher("/mux/pause", Bool)
        masked, unmasked = ("velocity low", "masked"), ("velocity low", "unmasked")
        self.wait_state(diagnostics, masked, ("lock pause", "free"))
        wait_subscribed([out.topic], publisher="/mux/twist_mux")

        high.publish(twist(0.9))
        out.wait_count(1)
        low.publish(twist(0.2))
        self.wait_state(diagnostics, unmasked, ("velocity high", "unmasked"))  # it was heard
        self.assertEqual([m.linear.x for m in out.messages], [0.9])

        self.clock.time += 1.0  # both fall silent
        self.wait_state(diagnostics, masked, ("velocity high", "masked"))
        low.publish(twist(0.3))
        self.assertEqual(out.wait_count(2)[-1].linear.x, 0.3)
        self.wait_state(diagnostics, unmasked, ("velocity high", "masked"))

        pause.publish(True)
        self.wait_state(diagnostics, masked, ("lock pause", "locked"), ("current priority", "50"))
        high.publish(twist(0.8))
        self.assertEqual(out.wait_count(3)[-1].linear.x, 0.8)
        pause.publish(False)
        self.wait_state(diagnostics, unmasked, ("lock pause", "free"))
        wait_until(lambda: markers.last and markers.last.points[1].x == 0.8, "the arrow")
        wait_until(lambda: relayed.last and relayed.last.linear.x == 0.8, "topic_tools' relay")

    def test_joystick_relay(self):
        out, drives = Recorder("/mux/joy_vel_out", Twist), Recorder("/mux/joy_priority", Bool)
        for recorder in (out, drives):
            self.addCleanup(recorder.close)
        stick = publisher("/mux/joy_vel_in", Twist)
        wait_subscribed([out.topic, drives.topic], publisher="/mux/joystick_relay")
        stick.publish(twist(1.0))
        # Second of four steps from 0.5 to 1 m/s.
        self.assertAlmostEqual(out.wait_count(1)[-1].linear.x, 0.5 + 0.5 / 3)
        self.assertTrue(drives.wait_count(1)[-1].data)
        action = SimpleActionClient("/mux/joy_priority_action", JoyPriorityAction)
        wait_connected(action.action_client.pub_goal, "the relay's action")
        action.send_goal(JoyPriorityGoal())
        self.assertFalse(drives.wait_count(2)[-1].data)

    def test_nodes_of_the_ros_itself(self):
        pictures, frames = Recorder("/picture_again", Image), Recorder("/tf", TFMessage)
        for recorder in (pictures, frames):
            self.addCleanup(recorder.close)
        picture = Image(height=1, width=2, encoding="mono8", step=2, data=b"ab")
        sender = publisher("/picture", Image)
        wait_subscribed([pictures.topic], publisher="/republish")
        sender.publish(picture)
        self.assertEqual(pictures.wait_count(1)[0].data, b"ab")

        def moved():
            self.clock.time += 0.01  # tf's publisher sends in periods of the clock
            return frames.last

        mount = wait_until(moved, "tf's static_transform_publisher").transforms[0]
        self.assertEqual((mount.header.frame_id, mount.child_frame_id), ("world", "camera"))
        self.assertEqual(mount.transform.translation.y, 2.0)
