"""Plugins with forces, joint poses and the RealSense, without a ROS master."""

import numpy as np
import pytest
import rospy
from bot_rig import Bot
from bullet_bridge.plugins import base
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.plugins.depth_cameras import RangeCameraSpec
from bullet_sim.pose import Pose
from bullet_sim.render.request import Frame
from fake_impl import plugin_of
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import Imu
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from urdf_texts import CONTROL, link

LINK = link("{0}", 2)


def _plugin(library, tags):
    inner = "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags.items())
    return f'<gazebo><plugin name="p" filename="lib{library}.so">{inner}</plugin></gazebo>'


def _robot(joint, plugin):
    return (
        f'<robot name="r"><link name="world"/>{LINK.format("a")}<joint name="j" type="{joint}">'
        '<parent link="world"/><child link="a"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" '
        f'effort="9" velocity="9"/></joint>{plugin}</robot>'
    )


def _output(world, text):
    model = world.spawn_urdf("r", text, Pose((0.0, 0.0, 1.0)), str)
    (spec,) = model.description.sensors
    return model, plugin_of(world, model, spec, 1)


SAID = {  # of a joint -> whether its forces are told
    "<provideFeedback>true</provideFeedback>": True,
    "<provideFeedback>false</provideFeedback>": False,
    "<provideFeedback>0</provideFeedback><provideFeedback>1</provideFeedback>": True,
    "<provideFeedback>1</provideFeedback><provideFeedback>0</provideFeedback>": False,
    "<physics><provide_feedback>true</provide_feedback></physics>": False,
    '<sensor name="s" type="force_torque"/>': True,
}


@pytest.mark.parametrize("feedback, told", SAID.items())
def test_force_torque_in_the_childs_frame(topics, world, feedback, told):
    tags = {"jointName": "j", "topicName": "load", "updateRate": "100", "robotNamespace": "bot"}
    weight = 2.0 * 9.81 if told else 0.0
    given = f'<gazebo reference="j">{feedback}</gazebo>'
    _, output = _output(world, _robot("fixed", _plugin("gazebo_ros_ft_sensor", tags) + given))
    world.step(100)
    assert output.spec.rate == 100.0
    output.update(0.1, 0.0)
    message = topics["/bot/load"].messages[0]
    assert topics["/bot/load"].kind is WrenchStamped
    assert (message.header.frame_id, message.header.stamp.to_sec()) == ("a", 0.1)
    assert message.wrench.force.z == pytest.approx(-weight, rel=1e-3)


def test_the_net_force_on_a_falling_link_is_its_weight(topics, world):
    tags = {"bodyName": "a", "topicName": "/net"}
    text = f'<robot name="r">{LINK.format("a")}{_plugin("gazebo_ros_f3d", tags)}</robot>'
    _, output = _output(world, text)
    for _ in range(3):
        world.step()
        output.update(world.time, 0.0)
    sent = topics["/net"].messages
    assert len(sent) == 2 and sent[0].header.frame_id == "world"
    assert sent[1].wrench.force.z == pytest.approx(-2.0 * 9.81)


def test_the_hand_of_god_pulls_without_overshoot(topics, world, monkeypatch):
    tags = {"linkName": "a", "frameId": "hand", "kl": "100", "ka": "50"}
    text = f'<robot name="r">{LINK.format("a")}{_plugin("gazebo_ros_hand_of_god", tags)}</robot>'
    monkeypatch.setattr(base.RosPart, "transforms", lambda _: None)
    model, output = _output(world, text)
    desired = Pose.from_xyz_rpy((0.5, 0.0, 1.0), (0.0, 0.0, 0.8))
    monkeypatch.setattr(output, "_desired", lambda: desired)
    highest = 0.0
    for _ in range(1500):
        output.update(world.time, 0.0)
        world.step()
        highest = max(highest, model.pose.position[0])
    assert model.pose.position == pytest.approx((0.5, 0.0, 1.0), abs=1e-3)
    assert highest < 0.5005 and model.pose.rpy[2] == pytest.approx(0.8, abs=0.01)
    (transform,) = topics["/tf"].messages[-1].transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "hand_actual")
    assert transform.transform.translation.x == pytest.approx(0.5, abs=1e-3)


def test_joints_are_put_to_the_points_one_after_the_other(topics, world, monkeypatch):
    tags = {"topicName": "poses"}
    plugin = _plugin("gazebo_ros_joint_pose_trajectory", tags)
    model, output = _output(world, _robot("revolute", plugin))
    points = [
        JointTrajectoryPoint(positions=[q, 7.0], time_from_start=rospy.Duration(t))
        for q, t in ((0.3, 0.1), (-0.4, 0.0))
    ]
    header = Header(frame_id="world")
    output._on_trajectory(JointTrajectory(header, ["j", "nose"], points))
    for step, expected in ((1, 0.3), (50, 0.3), (101, -0.4)):
        output.update(step * 0.001, 0.0)
        assert model.joints.positions_of(("j",)) == pytest.approx((expected,))
    assert not output.needs_update()
    errors = []
    monkeypatch.setattr(base.rospy, "logerr", lambda text, *rest: errors.append(text % rest))
    output._on_trajectory(JointTrajectory(header, ["j", "nose", "ear"], points))
    output._on_trajectory(JointTrajectory(joint_names=["j"], points=points))
    assert errors == [
        "/poses: a point has 2 positions, must have 3",
        "/poses: frame_id '' is neither world nor map nor a link",
    ]
    assert not output.needs_update()
    output._on_trajectory(JointTrajectory(Header(frame_id="r::a"), ["j"], points))
    output.update(1.0, 0.0)
    assert model.joints.positions_of(("j",)) == pytest.approx((0.3,))


# RealSense ----------------------------------------------------------------------------------------
def _camera(name, kind="camera", form="R8G8B8"):
    return (
        f'<gazebo reference="a"><sensor name="d435{name}" type="{kind}"><update_rate>15'
        "</update_rate><camera><horizontal_fov>1.2</horizontal_fov><image><width>64</width>"
        f"<height>48</height><format>{form}</format></image></camera></sensor></gazebo>"
    )


REALSENSE = {
    "prefix": "d435",
    "colorTopicName": "color/image_raw",
    "depthTopicName": "depth/image_raw",
    "infrared1TopicName": "infra1/image_raw",
    "colorOpticalframeName": "color_optical",
    "depthOpticalframeName": "depth_optical",
    "infrared1OpticalframeName": "infra_optical",
    "rangeMinDepth": "0.3",
    "rangeMaxDepth": "3.0",
    "pointCloud": "true",
    "pointCloudTopicName": "depth/points",
    "pointCloudCutoff": "0.5",
    "pointCloudCutoffMax": "2.0",
}


def _realsense(names=("color", "ired1", "ired2")):
    cameras = "".join(
        _camera(name, form="L_INT8" if "ired" in name else "R8G8B8") for name in names
    )
    plugin = _plugin("realsense_gazebo_plugin", REALSENSE).replace('"p"', '"camera"')
    return f'<robot name="r">{LINK.format("a")}{cameras}{_camera("depth", "depth")}{plugin}</robot>'


def test_a_realsense_has_four_cameras_below_its_plugins_name():
    model = parse_urdf(_realsense(), str, "r")
    assert not model.warnings
    color, infra1, infra2, deep = model.sensors
    assert type(color) is type(infra1) is CameraSpec and type(deep) is RangeCameraSpec
    assert (color.topic, color.info_topic, color.frame_id, color.encoding, color.rate) == (
        "/camera/color/image_raw",
        "/camera/color/camera_info",
        "color_optical",
        "rgb8",
        15.0,
    )
    assert (infra1.topic, infra1.frame_id, infra1.encoding) == (
        "/camera/infra1/image_raw",
        "infra_optical",
        "8UC1",
    )
    assert infra2.topic == "/camera/infra2/image_raw"
    assert (deep.topic, deep.points_topic, deep.width) == (
        "/camera/depth/image_raw",
        "/camera/depth/points",
        64,
    )


def test_a_camera_that_a_realsense_lacks_is_a_warning():
    model = parse_urdf(_realsense(("color", "ired1")), str, "r")
    assert len(model.sensors) == 3 and "needs a camera sensor 'd435ired2'" in str(model.warnings)


def test_depths_are_millimeters_within_the_range_and_points_within_the_cutoffs(topics, world):
    model = world.spawn_urdf("r", _realsense(), Pose(), str)
    output = plugin_of(world, model, model.description.sensors[-1], 1)
    assert output.request.depth
    depths = np.full((48, 64), 1.5, np.float32)
    depths[0, :4] = (0.2, 0.4, 2.5, 9.0)
    rgb = np.full((48, 64, 3), 7, np.uint8)
    output.publish_frame(Frame("x", 0.5, 500, rgb, depths, 0))
    image = topics["/camera/depth/image_raw"].messages[0]
    assert (image.encoding, image.header.frame_id) == ("16UC1", "depth_optical")
    row = np.frombuffer(image.data, "<u2")[:5]
    assert row.tolist() == [0, 400, 2500, 0, 1500]
    cloud = topics["/camera/depth/points"].messages[0]
    z = np.frombuffer(cloud.data, "<f4").reshape(48, 64, 8)[0, :5, 2]
    assert np.isnan(z[:4]).all() and z[4] == 1.5
    info = topics["/camera/depth/camera_info"].messages[0]
    assert (info.width, info.K[2], info.K[5], info.P[2]) == (64, 32.0, 24.0, 32.0)
    assert (info.distortion_model, list(info.D), list(info.R)) == ("plumb_bob", [], [0.0] * 9)


# controllers that publish sensors -----------------------------------------------------------------
IMU = (
    '<gazebo reference="a"><sensor name="body" type="imu"><plugin filename='
    '"libgazebo_ros_imu_sensor.so"><frameName>imu_frame</frameName></plugin></sensor></gazebo>'
)
PARAMS = {
    "/bot/imus": {"type": "imu_sensor_controller/ImuSensorController", "publish_rate": 100},
    "/bot/loads": {
        "type": "force_torque_sensor_controller/ForceTorqueSensorController",
        "publish_rate": 50,
    },
    "/bot/slow": {"type": "imu_sensor_controller/ImuSensorController"},
}


def test_sensors_are_published_under_their_names_by_their_controllers(monkeypatch):
    tags = {"jointName": "j", "topicName": "load"}
    text = _robot("fixed", _plugin("gazebo_ros_ft_sensor", tags) + IMU + CONTROL)
    bot = Bot(monkeypatch, text, PARAMS)
    bot.start("imus")
    bot.start("loads")
    bot.run(200)
    imus, loads = bot.endpoints["/bot/body"], bot.endpoints["/bot/j"]
    assert (imus.kind, len(imus.messages)) == (Imu, 20)
    assert imus.messages[-1].header.frame_id == "imu_frame"
    assert (loads.kind, len(loads.messages)) == (WrenchStamped, 10)
    assert bot.unload("loads") is False  # it runs
    assert not bot.load("slow") and "has no publish_rate" in bot.log[-2]
    assert bot.switch(stop=["loads"]) and bot.unload("loads") and loads.closed
    bot.world.close()


def test_a_robot_without_such_sensors_refuses_the_controller(monkeypatch):
    bot = Bot(monkeypatch, _robot("revolute", CONTROL), PARAMS)
    assert not bot.load("loads") and "of which the robot has none" in bot.log[-2]
    bot.world.close()
