"""Sensor outputs without a ROS master: messages of depth cameras, bumpers and lidars."""

import math
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from bullet_bridge.plugins import base
from bullet_bridge.plugins.base import ROS_SIDE
from bullet_bridge.plugins.cameras import PointClouds
from bullet_bridge.transport import conversions, publishing
from bullet_bridge.transport.senders import sender
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.parts.outputs import ImageOutput
from bullet_sim.plugins import drives
from bullet_sim.plugins.cameras import CameraSpec, TriggeredCameraSpec
from bullet_sim.plugins.contacts import ContactSpec
from bullet_sim.plugins.custom import CustomSpec
from bullet_sim.plugins.depth_cameras import DepthCameraSpec
from bullet_sim.plugins.drives import BaseSpec, SidesSpec, WheelDrive
from bullet_sim.plugins.forces import LinkForceSpec
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.plugins.spec import PluginSpec, SensorSpec
from bullet_sim.pose import Pose
from bullet_sim.render.request import Frame
from bullet_sim.sensors import camera
from fake_impl import (
    FakeReceivedCounts,
    FakeServer,
    Topic,
    in_thread,
    plugin_of,
    twist,
)
from sensor_msgs.srv import SetCameraInfoRequest
from urdf_texts import joint, link, robot, tags

from bullet_bridge import robots
from bullet_sim import plugins

pytestmark = pytest.mark.usefixtures("sketches")

BOT = robot(
    link("base", 2, 0.02, '<box size="0.4 0.3 0.2"/>'),
    '<link name="bumper"><collision name="rubber"><geometry><box size="0.02 0.3 0.1"/></geometry>'
    "</collision></link>",
    joint("j", "fixed", "base", "bumper", "0.21 0 0"),
)


CRATE = (
    '<model name="c"><link name="k"><inertial><mass>5</mass></inertial><collision name="side">'
    "<geometry><box><size>0.1 0.1 0.1</size></box></geometry></collision></link></model>"
)


@pytest.fixture(name="world")
def _world(world):
    world.spawn(sdf.ground_plane())
    return world


@pytest.fixture(name="bot")
def _bot(world):
    bot = world.spawn_urdf("bot", BOT, Pose((0.0, 0.0, 0.1)), str)
    world.step(300)
    return bot


def test_every_specification_has_a_plugin():
    shared = {PluginSpec, SensorSpec, BaseSpec, SidesSpec}
    kinds = {
        kind
        for module in vars(plugins).values()
        if isinstance(module, ModuleType)
        for kind in vars(module).values()
        if isinstance(kind, type) and kind.__name__.endswith("Spec")
    }
    # a user's own plugin has a class of its own
    own = {kind for kind in ROS_SIDE if kind.__module__.startswith("bullet_sim.")}
    assert kinds - shared - {CustomSpec} == own


DEPTH = np.array([[1.0, np.nan], [2.0, 3.5]], np.float32)


def depth_image(time, spec, depth):
    """The message of a depth camera's depths."""
    part = SimpleNamespace(publisher=lambda topic, kind, **_: Topic(topic, kind))
    encoding = "16UC1" if spec.millimeters else "32FC1"
    output = ImageOutput("/depth", spec.frame_id, encoding, *depth.shape)
    pixels = camera.depth_pixels(depth, spec.millimeters)
    sending = sender(part, output)
    sending.send(time, pixels)
    return sending._publisher.messages[-1]


def test_depth_in_meters():
    message = depth_image(1.5, DepthCameraSpec("d", "l", frame_id="f"), DEPTH)
    assert (message.encoding, message.step, message.height) == ("32FC1", 8, 2)
    np.testing.assert_array_equal(np.frombuffer(message.data, "<f4").reshape(2, 2), DEPTH)
    assert message.header.stamp.to_sec() == 1.5 and message.header.frame_id == "f"


def test_depth_in_millimeters():
    message = depth_image(0.0, DepthCameraSpec("d", "l", millimeters=True), DEPTH)
    assert (message.encoding, message.step) == ("16UC1", 4)
    assert np.frombuffer(message.data, "<u2").tolist() == [1000, 0, 2000, 3500]
    cut = np.array([[1.9999, 0.0006, np.inf, 1.0]], np.float32)
    message = depth_image(0.0, DepthCameraSpec("d", "l", millimeters=True), cut)
    assert np.frombuffer(message.data, "<u2").tolist() == [1999, 0, 0, 1000]


def test_points_carry_place_and_colour():
    k = np.array([[2.0, 0.0, 0.5], [0.0, 2.0, 0.5], [0.0, 0.0, 1.0]])
    rgb = np.zeros((2, 2, 3), np.uint8)
    rgb[1, 1] = (10, 20, 30)
    message = PointClouds(DepthCameraSpec("d", "l"), k).message(0.0, DEPTH, rgb)
    assert (message.width, message.height, message.point_step, message.row_step) == (2, 2, 32, 64)
    assert len(message.data) == 128 and not message.is_dense
    floats = np.frombuffer(message.data, "<f4").reshape(2, 2, 8)
    np.testing.assert_allclose(floats[1, 1, :3], (0.875, 0.875, 3.5))
    assert np.isnan(floats[0, 1, :3]).all()
    packed = np.frombuffer(message.data, "<u4").reshape(2, 2, 8)[1, 1, 4]
    assert packed == (30 << 16) + (20 << 8) + 10, "the bytes as they are in the image"
    row = PointClouds(DepthCameraSpec("d", "l", organized=False), k).message(0.0, DEPTH, rgb)
    assert (row.width, row.height, row.row_step) == (4, 1, 128) and row.data == message.data


def images_in_10_s(output):
    """How many images a camera requests in 10 s of steps of 1 ms."""
    output.restart(0.0)
    start = output.world.step_count
    output.schedule.check_subscribers(start)
    before = len(output.context.cameras.requests)
    for step in range(1, 10001):
        if output.schedule.due(start + step):
            output.update(step * 0.001, 0.0)
    return len(output.context.cameras.requests) - before


@pytest.mark.parametrize(
    "rate, limit, is_free, images",
    [
        (30.0, 0.0, False, 300),
        (30.0, 30.0, False, 200),  # of three periods of 33, 33 and 34 ms two are too short
        (30.0, 20.0, False, 150),  # in Gazebo 15.1 a second, and for 30 and 30 18.8
        (30.0, 10.0, False, 100),
        (20.0, 50.0, False, 200),
        (30.0, 30.0, True, 294),  # 34 steps each
    ],
)
def test_a_plugins_rate_leaves_out_images_that_come_too_soon(
    topics, world, bot, rate, limit, is_free, images
):
    spec = CameraSpec("c", "bumper", topic="/c", rate=rate, plugin_rate=limit, is_free=is_free)
    assert images_in_10_s(plugin_of(world, bot, spec)) == images


@pytest.mark.parametrize("waits, limit, images", [(True, 0, 0), (True, 10.0, 0), (False, 0, 40)])
def test_a_multicamera_waits_for_its_time_after_a_reset(topics, world, bot, waits, limit, images):
    """gazebo_ros_multicamera compares with its last image's time; gazebo_ros_camera notices."""
    spec = CameraSpec("c", "bumper", topic="/c", rate=20.0, plugin_rate=limit, waits=waits)
    output = plugin_of(world, bot, spec)

    def images_until(time):
        output.schedule.check_subscribers(world.step_count)
        before = len(output.context.cameras.requests)
        while world.time < time - 1e-6:
            world.step(1)
            if output.schedule.due(world.step_count):
                output.update(world.time, 0.0)
        return len(output.context.cameras.requests) - before

    assert images_until(2.0) > 10
    world.start_over()
    output.go_back(world.time)
    assert images_until(1.99) == pytest.approx(images, abs=1)
    assert images_until(3.0) > 9, "its time has come again"
    output.close()


def test_a_camera_takes_its_info_and_rate_from_services(topics, world, bot):
    spec = CameraSpec("c", "bumper", width=4, height=2, topic="/cam/image_raw", rate=30.0,
                      info_topic="/cam/camera_info", namespace="/cam", tunable=True,
                      plugin_rate=20.0)  # fmt: skip
    output = in_thread(plugin_of(world, bot, spec))
    request = SetCameraInfoRequest()
    request.camera_info.K[0], request.camera_info.header.frame_id = 7.0, "calibrated"
    assert topics["/cam/set_camera_info"].call(request).success
    info = output.info_message(1.5)
    assert (info.K[0], info.header.frame_id, info.header.stamp.to_sec()) == (7.0, "calibrated", 1.5)
    server = FakeServer.made["/cam"]
    assert server.values == {"imager_rate": 2.0} and server.config.max["imager_rate"] == 50.0
    output.schedule.check_subscribers(world.step_count)
    for requested, expected in ((5.0, 5), (40.0, 20)):
        server.callback({"imager_rate": requested}, 3)
        assert images_in_10_s(output) == 10 * expected
    output.close()
    assert server.closed and topics["/cam/set_camera_info"].closed


def test_a_triggered_camera_takes_one_image_for_each_trigger(topics, world, bot):
    spec = TriggeredCameraSpec("c", "bumper", width=4, height=2, topic="/cam/image_raw", rate=0.0,
                               trigger_topics=("/cam/image_trigger",))  # fmt: skip
    received = FakeReceivedCounts()
    output = plugin_of(world, bot, spec, received=received)
    assert received.topic == "/cam/image_trigger" and not output.needs_update()
    received.take(None)
    received.take(None)
    taken = 0
    while output.needs_update():
        output.update(0.1 * taken, 0.1)
        taken += 1
    assert taken == 2 and len(output.context.cameras.requests) == 2
    for topic in topics.values():
        topic.subscribers = 0
    received.take(None)
    topics["/cam/image_raw"].subscribers = 1
    assert not output.needs_update()  # nobody had asked for the image


def test_depth_camera_publishes_what_is_subscribed(topics, world, bot):
    spec = DepthCameraSpec(
        "d",
        "bumper",
        width=2,
        height=2,
        topic="/c",
        info_topic="/i",
        depth_topic="/d",
        depth_info_topic="/di",
        points_topic="/p",
        cutoff=1.5,
        cutoff_max=3.0,
    )
    output = plugin_of(world, bot, spec)
    assert output.request.depth and output.request.pose[0][0] == pytest.approx(0.21)
    topics["/d"].subscribers = 0
    output.publish_frame(Frame("d", 0.5, 5, np.zeros((2, 2, 3), np.uint8), DEPTH))
    assert [len(topics[name].messages) for name in ("/c", "/i", "/di", "/p", "/d")] == [
        1,
        1,
        1,
        1,
        0,
    ]
    cloud = np.frombuffer(topics["/p"].messages[0].data, "<f4").reshape(4, 8)[:, 2]
    assert np.isfinite(cloud).tolist() == [False, False, True, False]
    for name in topics:
        topics[name].subscribers = 0
    assert not output.needs_update()
    topics["/di"].subscribers = 1
    assert not output.needs_update(), "upstream the depths' camera_info activates no sensor"
    topics["/d"].subscribers = 1
    assert output.needs_update()
    output.close()
    assert all(topic.closed for topic in topics.values())


def test_a_depth_camera_has_neither_reflectance_nor_normals(topics, world, bot):
    """As with Gazebo 11.1: upstream compiles what advertises them for Gazebo 9 alone."""
    plugin_of(world, bot, DepthCameraSpec("d", "bumper", width=2, height=2))
    assert not [name for name in topics if "reflectance" in name or "normals" in name]


@pytest.mark.parametrize("tells, limit, infos", [(True, 0.0, 4), (True, 10.0, 2), (False, 0.0, 0)])
def test_a_depth_cameras_rate_is_that_of_camera_info(topics, world, bot, tells, limit, infos):
    """openni_kinect's; depth_camera of Melodic and Noetic advertises it and publishes none."""
    spec = DepthCameraSpec("d", "bumper", width=2, height=2, topic="/c", info_topic="/i",
                           depth_topic="/d", depth_info_topic="/di", points_topic="/p",
                           rate=20.0, plugin_rate=limit, tells_info=tells, waits=True)  # fmt: skip
    output = plugin_of(world, bot, spec)
    for time in (0.05, 0.1, 0.15, 0.2):
        output.publish_frame(Frame("d", time, 5, np.zeros((2, 2, 3), np.uint8), DEPTH))
    counts = {name: len(topics[name].messages) for name in ("/c", "/d", "/p", "/i", "/di")}
    assert counts == {"/c": 4, "/d": 4, "/p": 4, "/i": infos, "/di": infos}
    output.go_back(0.0)
    output.publish_frame(Frame("d", 0.1, 5, np.zeros((2, 2, 3), np.uint8), DEPTH))
    assert len(topics["/i"].messages) == infos, "it waits for its time, which images do not"
    assert len(topics["/c"].messages) == 5


def test_cameras_of_one_name_have_separate_images(topics, world, bot):
    bot.description.sensors += [
        CameraSpec("cam", "base", topic="/a", info_topic="/ai"),
        CameraSpec("cam", "base", topic="/a", info_topic="/ai"),
        CameraSpec("cam", "bumper", topic="/b", info_topic="/bi"),
    ]
    names = [plugin_of(world, bot, spec).request.name for spec in bot.description.sensors]
    assert names == ["bot/base/cam/0", "bot/base/cam/1", "bot/bumper/cam/2"]


def test_a_scan_that_the_message_cannot_hold_leaves_no_topic(monkeypatch, world, bot):
    made = []

    def make(name, kind, **_):
        made.append(Topic(name, kind))
        return made[-1]

    monkeypatch.setattr(publishing.rospy, "Publisher", make)
    monkeypatch.setattr(publishing, "send_directly", lambda *_: None)
    spec = RaySpec("l", "base", samples=1, range_max=1e39, topic="/scan")
    bot.description.sensors.append(spec)
    logged = []
    monkeypatch.setattr(robots.rospy, "logerr", lambda text, *rest: logged.append(text % rest))
    parts = []
    robots.Robots(None, world, None, 0, FakeReceivedCounts())._add_plugin(bot, 0, spec, parts)
    assert parts == []
    assert [topic.closed for topic in made] == [True]
    assert len(logged) == 1 and "/scan is left out" in logged[0]


def test_bumper_names_shapes_and_sums_forces(topics, world, bot):
    bumper = plugin_of(world, bot, ContactSpec("c", "base", topic="/hit"))
    for _ in range(200):  # the force of a single step is as far as the solver has come in it
        world.step()
        bumper.update(world.time, 0.0)
    wrenches = []
    assert len(topics["/hit"].messages) == 200, "without a rate each step has a message"
    for message in topics["/hit"].messages:
        (state,) = message.states
        assert state.collision1_name == "bot::base::base_collision"
        assert state.collision2_name == "ground_plane::link::collision"
        assert state.info.startswith("Debug:  i:(0/1)     my geom:bot::base::base_collision   ")
        assert sum(w.force.z for w in state.wrenches) == pytest.approx(state.total_wrench.force.z)
        force, torque = state.total_wrench.force, state.total_wrench.torque
        wrenches.append((force.z, torque.x, torque.y))
    assert np.mean(wrenches, axis=0) == pytest.approx((2 * 9.81, 0.0, 0.0), rel=0.02, abs=0.05)


@pytest.mark.parametrize("names", [(), ("base_fixed_joint_lump__rubber_collision_1",)])
def test_bumper_on_a_merged_link_sees_its_own_shape_only(topics, world, bot, names):
    output = plugin_of(world, bot, ContactSpec("c", "bumper", names, topic="/hit"))
    world.step(1)
    output.update(0.301, 0.0)
    assert topics["/hit"].messages[0].states == []
    # 0.3 mm inside, which is left to the solver
    world.spawn_sdf("crate", CRATE, Pose((0.2697, 0.0, 0.1)), str)
    world.step(1)
    output.update(0.302, 0.0)
    (state,) = topics["/hit"].messages[1].states
    names = {state.collision1_name, state.collision2_name}
    rubber = "bot::base::base_fixed_joint_lump__rubber_collision_1"  # as sdformat writes it
    assert names == {rubber, "crate::k::side"}
    towards = -1.0 if state.collision1_name == rubber else 1.0
    assert state.contact_normals[0].x == pytest.approx(towards, abs=0.01)


@pytest.mark.parametrize(
    "rate, steps, states", [(50.0, 20, 20), (5.0, 200, 100), (1e6, 1, 1), (0.0, 1, 1)]
)
def test_a_bumpers_message_has_the_contacts_of_all_steps_since_the_last(
    topics, world, bot, rate, steps, states
):
    """At most those of the last 100 steps, as Gazebo's ContactSensor keeps."""
    bumper = plugin_of(world, bot, ContactSpec("c", "base", topic="/hit", rate=rate))
    while world.step_count < 2000:
        world.step()
        assert bumper.is_message(world.step_count) == (world.step_count % steps == 0)
        bumper.update(world.time, 0.0)
    messages = topics["/hit"].messages[1:]  # the first begins with the sensor
    assert len(messages) == 2000 // steps - -(-301 // steps)
    for message in messages:
        stamp = message.header.stamp.to_sec()
        assert round(1000 * stamp) % steps == 0
        assert len(message.states) == states
        for index, state in enumerate(message.states):
            time = stamp - 1e-3 * (states - 1 - index)
            assert state.info.startswith(f"Debug:  i:({index}/{states})     my geom:bot::base::")
            assert float(state.info.rsplit("time:")[1]) == pytest.approx(time)


def test_a_bumper_that_is_the_smaller_ones_partner_has_its_contacts_the_other_way_round(
    topics, world, bot
):
    """Gazebo names the shape first whose model is smaller; the wrench is that on its link."""
    world.spawn_sdf("crate", CRATE, Pose((0.0, 0.0, 0.2497)), str)
    bumper = plugin_of(world, bot, ContactSpec("c", "base", topic="/hit"))
    world.step()
    bumper.update(world.time, 0.0)
    states = {state.collision2_name: state for state in topics["/hit"].messages[0].states}
    assert set(states) == {"ground_plane::link::collision", "bot::base::base_collision"}
    state = states["bot::base::base_collision"]
    assert state.collision1_name == "crate::k::side"
    assert state.contact_normals[0].z == pytest.approx(1.0, abs=1e-6)
    assert state.total_wrench.force.z > 0.0


@pytest.mark.parametrize("of", ["base", "top"])
def test_contacts_with_what_never_moves_as_gazebo_has_them(topics, world, of):
    """Gazebo 11.1, a box of 2 kg on a static one of its size that is turned by 1 rad, gravity
    (1.5, 0, -9.8): that comes first, force (-1.6, 2.5, 19.4) a step, torque 0 on average."""
    world.engine.set_gravity((1.5, 0.0, -9.8))
    for name, static, height, yaw in (("base", 1, 0.5, 1.0), ("top", 0, 0.7, 0.3)):
        box = CRATE.replace("0.1 0.1 0.1", "0.2 0.2 0.2").replace("5</mass>", "2</mass>")
        text = box.replace('"c">', f'"c"><static>{static}</static>')
        pose = Pose.from_xyz_rpy((5.0, 0.0, height), (0.0, 0.0, yaw))
        world.spawn_sdf(name, text, pose, str)
    bumper = plugin_of(world, world.models[of], ContactSpec("c", "k", topic="/hit"))
    for _ in range(1000):
        world.step()
        bumper.update(world.time, 0.0)
    total = np.zeros(6)
    for message in topics["/hit"].messages[500:]:
        for state in message.states:
            names = state.collision1_name, state.collision2_name
            assert names == ("base::k::side", "top::k::side")
            assert state.contact_normals[0].z == pytest.approx(-1.0, abs=1e-3)
            force, torque = state.total_wrench.force, state.total_wrench.torque
            total += (force.x, force.y, force.z, torque.x, torque.y, torque.z)
    wanted = (-3.0 * math.cos(1.0), 3.0 * math.sin(1.0), 19.6, 0.0, 0.0, 0.0)
    assert total / 500 == pytest.approx(wanted, abs=0.3)


@pytest.mark.parametrize("name", ["nose", "bumper_collision", "rubber", "__default__"])
def test_bumper_of_an_unknown_collision_tells_nothing_as_in_gazebo(
    topics, world, bot, name, monkeypatch
):
    """Gazebo 11.1: messages without states come at the sensor's rate."""
    logged = []
    monkeypatch.setattr(robots.rospy, "logwarn", lambda text, *rest: logged.append(text % rest))
    bumper = plugin_of(world, bot, ContactSpec("c", "bumper", (name,), topic="/hit"))
    assert f"tells nothing of {name}" in logged[0] and "base::base_collision" in logged[0]
    world.step()
    bumper.update(world.time, 0.0)
    assert [message.states for message in topics["/hit"].messages] == [[]]


def test_a_scan_of_several_layers_has_the_ranges_of_all(topics, world):
    ray = (
        '<gazebo reference="base"><sensor name="s" type="ray"><update_rate>10</update_rate><ray>'
        "<scan><horizontal><samples>3</samples><min_angle>-0.4</min_angle><max_angle>0.4"
        "</max_angle></horizontal><vertical><samples>2</samples><min_angle>-0.5</min_angle>"
        "<max_angle>0.0</max_angle></vertical></scan><range><min>0.1</min><max>9</max></range>"
        '</ray><plugin name="l" filename="libgazebo_ros_laser.so"><topicName>scan</topicName>'
        "</plugin></sensor></gazebo></robot>"
    )
    post = '<robot name="p"><link name="base"/></robot>'
    cart = world.spawn_urdf("cart", post.replace("</robot>", ray), Pose((0, 0, 1)), str)
    (spec,) = [each for each in cart.description.sensors if each.topic == "/scan"]
    output = plugin_of(world, cart, spec)
    output.update(world.time, 0.1)
    scan = topics["/scan"].messages[-1]
    down = 1.0 / math.sin(0.5)
    assert list(scan.ranges) == pytest.approx([down] * 3 + [math.inf] * 3, rel=1e-4)
    assert len(scan.intensities) == 6 and scan.angle_increment == pytest.approx(0.4)
    assert (scan.scan_time, scan.time_increment) == (0.0, 0.0), "as upstream"
    output.close()


def test_lidar_pose_counts_once(topics, world, bot):
    world.spawn_sdf(
        "wall",
        '<model name="w"><static>1</static><link name="k"><collision name="c">'
        "<geometry><box><size>0.2 2 2</size></box></geometry></collision></link>"
        "</model>",
        Pose((3.1, 0.0, 0.0)),
        str,
    )
    spec = RaySpec(
        "l",
        "bumper",
        ((0.3, 0.0, 0.0), (0.0, 0.0, 0.0)),
        samples=1,
        min_angle=0.0,
        max_angle=0.0,
        topic="/scan",
    )
    plugin_of(world, bot, spec).update(0.1, 0.0)
    assert topics["/scan"].messages[0].ranges[0] == pytest.approx(3.0 - 0.51, abs=0.005)


@pytest.mark.parametrize("rate, first", [(0.0, 1), (1e6, 1), (100.0, 10)])
def test_rate_is_at_most_one_a_step(topics, world, bot, rate, first):
    output = plugin_of(world, bot, LinkForceSpec("f", "base", rate=rate))
    assert output.schedule.next - world.step_count == first


@pytest.mark.parametrize(
    "encoding, expected",
    [
        ("rgb8", [200, 100, 50]),
        ("bgr8", [50, 100, 200]),
        ("mono8", [124]),
        ("mono16", [31919]),  # 124.2 x 257
        ("rgb16", [51400, 25700, 12850]),
    ],
)
def test_encodings(encoding, expected):
    rgb = np.tile(np.array((200, 100, 50), np.uint8), (2, 3, 1))
    pixels = camera.pixels(rgb, encoding)
    assert pixels.flags.c_contiguous and pixels.shape[:2] == (2, 3)
    assert pixels.reshape(6, -1).tolist() == [expected] * 6


@pytest.mark.parametrize("order", ["rggb", "bggr", "gbrg", "grbg"])
def test_a_bayer_pattern_has_one_color_a_pixel(order):
    rgb = np.tile(np.array((200, 100, 50), np.uint8), (3, 5, 1))
    values = [dict(r=200, g=100, b=50)[color] for color in order]
    mosaic = camera.pixels(rgb, f"bayer_{order}8")
    assert mosaic.shape == (3, 5) and mosaic[:2, :2].ravel().tolist() == values
    assert mosaic[2, 3] == values[1] and mosaic[1, 4] == values[2]


def test_stereo_baseline():
    spec = CameraSpec("c", "l", width=100, height=80, horizontal_fov=math.pi / 2, baseline=0.07)
    info = conversions.camera_info(spec, camera.camera_info_arrays(100, 80, math.pi / 2))
    assert info.P[3] == pytest.approx(-50 * 0.07) and info.P[0] == pytest.approx(50)


CART = robot(
    link("base", 3, 0.05).replace(
        "</link>",
        "".join(
            f'<collision><origin xyz="{x} 0 -0.06"/><geometry><sphere radius="0.04"/></geometry>'
            "</collision>"
            for x in (0.15, -0.15)
        )
        + "</link>",
    ),
    tags("base", mu1=0, mu2=0),
    *(
        link(side, 0.3, 0.001, '<cylinder radius="0.1" length="0.03"/>', "1.5707963 0 0")
        + joint(f"{side}_joint", "continuous", "base", side, f"0 {y} 0")
        for side, y in (("left", 0.2), ("right", -0.2))
    ),
    '<gazebo><plugin name="d" filename="libgazebo_ros_diff_drive.so"><wheelSeparation>0.4'
    "</wheelSeparation><wheelDiameter>0.2</wheelDiameter><updateRate>50</updateRate>"
    "<robotNamespace>n</robotNamespace>{}</plugin></gazebo>",
    name="cart",
)


FOUR_WHEELS = "".join(
    f"<{side}{end}Joint>{side}_joint</{side}{end}Joint>"
    for side in ("left", "right")
    for end in ("Front", "Rear")
)


def test_the_wheels_are_braked_before_the_first_update(topics, world):
    cart = world.spawn_urdf("cart", CART.format(""), Pose((0.0, 0.0, 0.1)), str)
    world.engine.set_gravity((0.5, 0.0, -9.81))
    output = plugin_of(world, cart, cart.description.sensors[0])
    output.prepare()
    world.step(500)
    assert cart.pose.position[0] == pytest.approx(0.0, abs=0.02)
    output.close()


@pytest.mark.parametrize("tags", ["<legacyMode>true</legacyMode>", ""])
@pytest.mark.parametrize("source", ["world", "encoder"])
def test_diff_drive_moves_the_wheels_and_publishes(topics, world, monkeypatch, tags, source):
    logged = []
    monkeypatch.setattr(base.rospy, "logerr", lambda _, text: logged.append(text))
    cart = world.spawn_urdf(
        "cart",
        CART.format(f"{tags}<odometrySource>{source}</odometrySource>"),
        Pose((0.0, 0.0, 0.1)),
        str,
    )
    assert cart.description.warnings == []
    received = FakeReceivedCounts()
    output = plugin_of(world, cart, cart.description.sensors[0], received=received)
    assert received.topic == "/n/cmd_vel" and output.needs_update()
    received.take(twist(0.3, 0.5))
    for _ in range(100):
        world.step(20)
        output.update(world.time, 0.0)
    odometry = topics["/n/odom"].messages[-1]
    assert odometry.twist.twist.linear.x == pytest.approx(0.3, rel=0.05)
    assert odometry.twist.twist.angular.z == pytest.approx(0.5, rel=0.08)
    assert odometry.pose.covariance[35] == 1e-3 and not any(odometry.twist.covariance)
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "base_footprint")
    transform = topics["/tf"].messages[-1].transforms[0]
    assert transform.transform.translation.x == odometry.pose.pose.position.x
    sent = odometry.twist.twist
    assert (sent.linear.z, sent.angular.x, sent.angular.y) == (0.0, 0.0, 0.0), "as upstream"
    received.take(twist(math.nan))
    world.step(20)
    output.update(world.time, 0.0)
    assert topics["/n/odom"].messages[-1].twist.twist.linear.x == pytest.approx(0.3, rel=0.05)
    assert len(logged) == 1 and "/n/cmd_vel" in logged[0] and "nan" in logged[0]
    output.close()


@pytest.mark.parametrize("source, sign", [("world", -1.0), ("encoder", 1.0)])
def test_the_encoders_odometry_has_no_sign_backwards_as_upstream(topics, world, source, sign):
    text = CART.format(f"<odometrySource>{source}</odometrySource>")
    cart = world.spawn_urdf("cart", text, Pose((0.0, 0.0, 0.1)), str)
    received = FakeReceivedCounts()
    output = plugin_of(world, cart, cart.description.sensors[0], received=received)
    received.take(twist(-0.3))
    for _ in range(100):
        world.step(20)
        output.update(world.time, 0.0)
    odometry = topics["/n/odom"].messages[-1]
    assert odometry.twist.twist.linear.x == pytest.approx(0.3 * sign, rel=0.05)
    assert odometry.pose.pose.position.x < -0.5
    output.close()


def test_odometry_on_a_slope_is_along_the_heading_in_the_plane(topics, world):
    """Of the velocity in the world x and y alone count; its height is left out by skid steering."""
    text = CART.format("").replace("gazebo_ros_diff_drive", "gazebo_ros_skid_steer_drive")
    skid = text.replace("</plugin>", f"{FOUR_WHEELS}<broadcastTF>true</broadcastTF></plugin>")
    place = Pose.from_xyz_rpy((0.0, 0.0, 5.0), (0.1, 0.3, 0.5))
    for name, content, height in (("diff", CART.format(""), 5.0), ("skid", skid, 0.0)):
        cart = world.spawn_urdf(name, content, place, str)
        output = plugin_of(world, cart, cart.description.sensors[0])
        cart.set_state(place, (0.4, 0.2, 0.3), (0.1, 0.2, 0.7))
        output.update(world.time, 0.0)
        odometry = topics["/n/odom"].messages[-1]
        linear, angular = odometry.twist.twist.linear, odometry.twist.twist.angular
        c, s = math.cos(0.5), math.sin(0.5)
        assert (linear.x, linear.y, linear.z) == pytest.approx(
            (0.4 * c + 0.2 * s, 0.2 * c - 0.4 * s, 0.0)
        )
        assert (angular.x, angular.y, angular.z) == pytest.approx((0.0, 0.0, 0.7))
        assert odometry.pose.pose.position.z == height
        transform = topics["/tf"].messages[-1].transforms[0].transform
        assert transform.translation.z == 5.0
        output.close()
        world.delete(name)


@pytest.mark.parametrize(
    "tags, expected",
    [
        ("<publishTf>false</publishTf>", {"/tf"}),
        ("<publishOdomTF>0</publishOdomTF>", {"/n/odom", "/tf"}),
    ],
)
def test_outputs_of_diff_drive_that_are_switched_off(topics, world, tags, expected):
    cart = world.spawn_urdf("cart", CART.format(tags), Pose((0.0, 0.0, 0.1)), str)
    output = plugin_of(world, cart, cart.description.sensors[0])
    output.update(world.time, 0.0)
    assert set(topics) == expected and topics["/tf"].messages == []  # advertised, as upstream
    output.close()


def test_the_covariances_of_skid_steering():
    text = CART.format(f"{FOUR_WHEELS}<covariance_x>0.5</covariance_x>")
    text = text.replace("gazebo_ros_diff_drive", "gazebo_ros_skid_steer_drive")
    [spec] = parse_urdf(text, str).sensors
    assert not spec.publish_tf and spec.torque == 5.0
    assert spec.pose_covariance == spec.twist_covariance == (0.5, 1e-4, 1e12, 1e12, 1e12, 1e-2)


def test_wheel_acceleration_is_limited():
    drive = WheelDrive(
        drives.WheelDriveSpec(
            "d", "b", left=("l",), right=("r",), separation=1.0, diameter=1.0, acceleration=2.0
        )
    )
    for turn, elapsed, turning, expected in (
        (0.0, 0.1, (0.0, 0.0), (0.4, 0.4)),
        (0.0, 0.1, (0.0, 0.0), (0.8, 0.8)),  # the wheels do not follow: it adds up
        (0.0, 0.1, (2.0, 0.8), (2.0, 2.0)),  # one is as fast as commanded: no limit for either
        (0.0, 1.0, (0.8, 0.8), (2.0, 2.0)),
        (1.0, 1.0, (2.0, 2.0), (1.0, 3.0)),
    ):
        assert drive.wheel_speeds(1.0, turn, elapsed, turning) == pytest.approx(expected)


def test_joint_states_plugin(topics, world):
    text = CART.format("").replace(
        "</robot>",
        (
            '<gazebo><plugin name="j" filename="libgazebo_ros_joint_state_publisher.so"><jointName>'
            "right_joint, left_joint, nose</jointName></plugin></gazebo></robot>"
        ),
    )
    cart = world.spawn_urdf("cart", text, Pose((0.0, 0.0, 0.1)), str)
    assert "nose" in cart.description.warnings[0]
    spec = cart.description.sensors[1]
    plugin_of(world, cart, spec).update(0.2, 0.0)
    message = topics["/cart/joint_states"].messages[0]
    assert message.name == ["right_joint", "left_joint"]
    assert (len(message.velocity), len(message.effort)) == (2, 0)


def test_joint_states_without_a_joint_name_are_empty_as_in_gazebo(topics, world):
    plugin = (
        '<gazebo><plugin name="j" filename="libgazebo_ros_joint_state_publisher.so"><joint_name>'
        "left_joint</joint_name></plugin></gazebo></robot>"
    )
    text = CART.format("").replace("</robot>", plugin)
    cart = world.spawn_urdf("cart", text, Pose((0.0, 0.0, 0.1)), str)
    assert "has no jointName" in cart.description.warnings[0]
    spec = cart.description.sensors[1]
    assert spec.rate == 100.0
    plugin_of(world, cart, spec).update(0.2, 0.0)
    message = topics["/cart/joint_states"].messages[0]
    assert list(message.name) == list(message.position) == list(message.velocity) == []


def test_drive_of_unknown_joints_is_skipped(world):
    cart = world.spawn_urdf("cart", CART.format("<leftJoint>nose</leftJoint>"), Pose(), str)
    assert cart.description.sensors == []
    assert "nose" in cart.description.warnings[0] and "left_joint" in cart.description.warnings[0]
