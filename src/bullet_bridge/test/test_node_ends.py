"""The simulator says nothing when it ends while messages come and its own go out."""

import signal
import subprocess
import sys

import pytest
import testing

TOPICS = {
    "/gazebo/set_model_state": "gazebo_msgs/ModelState",
    "/gazebo/set_link_state": "gazebo_msgs/LinkState",
}
LISTENER = """
import rospy, sys
from gazebo_msgs.msg import LinkStates, ModelStates
from rosgraph_msgs.msg import Clock
rospy.init_node("listener", disable_signals=True, disable_rostime=True)
for topic, kind in (("/clock", Clock), ("/gazebo/model_states", ModelStates)):
    rospy.Subscriber(topic, kind, lambda message: None)
rospy.wait_for_message("/gazebo/link_states", LinkStates)
rospy.spin()
"""


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        with testing.flood(environment, TOPICS, "model_name='ground_plane'", "link_name='a::b'"):
            with testing.running(environment, [sys.executable, "-c", LISTENER]):
                yield environment


@pytest.mark.parametrize(
    "lockstep, number", [(False, signal.SIGINT), (True, signal.SIGTERM)], ids=["free", "lockstep"]
)
def test_simulator_exits_without_output(environment, tmp_path, lockstep, number):
    testing.assert_clean_exit(
        testing.slow_close(tmp_path, environment),
        "/gazebo",
        [
            testing.executable("bullet_bridge", "bridge"),
            f"_lockstep:={str(lockstep).lower()}",
        ],
        TOPICS,
        number,
    )
    done = subprocess.run(["rosparam", "get", "/use_sim_time"], env=environment, check=True,
                          stdout=subprocess.PIPE, text=True)  # fmt: skip
    assert done.stdout.strip() == "true", "the simulator has set it, as gazebo_ros does"
