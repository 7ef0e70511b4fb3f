"""The node joy_node."""

import time

import rospy
from sensor_msgs.msg import Joy

from joy_node.driver import Driver
from joy_node.pad_state import PadState
from joy_node.publish_timer import PublishTimer
from joy_node.sdl_pads import SdlPads
from paddock_common import nodes

POLL_PERIOD = 0.004  # wall time between two readings [s]
IDLE_PERIOD = 0.1  # wall time between two turns without a pad [s]


def _number(name, default):
    value = rospy.get_param("~" + name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{name} is {value!r}, must be a number")
    return float(value)


def make_driver(pads, publisher):
    """Driver with this node's parameters.

    Raises:
        ValueError: names the parameter, its value and what is valid.
    """
    state = PadState(
        _number("deadzone", 0.05),
        bool(rospy.get_param("~default_trig_val", False)),
        bool(rospy.get_param("~sticky_buttons", False)),
    )
    timer = PublishTimer(_number("autorepeat_rate", 0.0), _number("coalesce_interval", 0.001))

    device = str(rospy.get_param("~dev", "/dev/input/js0"))

    def send(axes, buttons):
        message = Joy(axes=axes, buttons=buttons)
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = device
        publisher.publish(message)

    return Driver(pads.open, state, timer, send, rospy.loginfo, wanted=pads.wanted)


def main():
    """Runs the node; returns 1 when a parameter is wrong."""
    nodes.init_interruptible("joy_node")
    try:
        pads = SdlPads(rospy.get_param("~dev", "/dev/input/js0"), rospy.get_param("~dev_name", ""))
        driver = make_driver(pads, rospy.Publisher("joy", Joy, queue_size=1))
    except ValueError as error:
        rospy.logfatal("joy_node: %s", error)
        return 1
    while not rospy.is_shutdown():
        time.sleep(POLL_PERIOD if driver.spin_once() else IDLE_PERIOD)
    driver.close()
    pads.close()
    return 0
