"""Messages and configuration types, without a master."""

import math
from types import SimpleNamespace

import pytest
from dynamic_reconfigure.encoding import encode_description
from nav_msgs.msg import Odometry
from paddock_common.geometry import transform_of, yaw_of
from paddock_common.reconfigure import describe


@pytest.mark.parametrize("yaw", [-3.0, -0.5, 0.0, 1.2, math.pi])
def test_headings(yaw):
    quaternion = SimpleNamespace(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    assert yaw_of(quaternion) == pytest.approx(yaw)


def test_the_transform_of_an_odometry():
    message = Odometry()
    message.header.frame_id, message.child_frame_id = "odom", "base_footprint"
    position, rotation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y, position.z, rotation.z, rotation.w = 1.0, 2.0, 0.1, 0.6, 0.8
    transform = transform_of(message)
    translation = transform.transform.translation
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "base_footprint")
    assert (translation.x, translation.y, translation.z) == (
        1.0,
        2.0,
        0.1,
    ) and transform.transform.rotation == rotation


def test_a_configuration_type_is_what_dynamic_reconfigure_reads():
    module = describe(
        (("p", "double", 1.0, -5.0, 5.0, "Gain."), ("on", "bool", True, False, True, ""))
    )
    assert (module.defaults, module.type) == ({"p": 1.0, "on": True}, {"p": "double", "on": "bool"})
    message = encode_description(module)
    assert [item.name for item in message.groups[0].parameters] == ["p", "on"]
    assert (message.min.doubles[0].value, message.max.doubles[0].value) == (-5.0, 5.0)
    assert (message.dflt.doubles[0].value, message.dflt.bools[0].value) == (1.0, True)
