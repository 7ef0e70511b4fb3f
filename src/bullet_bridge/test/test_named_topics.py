"""Topics, frames, links and joints that a plugin's parameters name: where its messages come."""

import pytest
from bullet_sim.formats.sdf.world import ground_plane
from bullet_sim.pose import Pose
from fake_impl import plugin_of
from test_plugin_outputs import CART, WALL

RAY = (
    "<ray><scan><horizontal><samples>9</samples><min_angle>-0.4</min_angle><max_angle>0.4"
    "</max_angle></horizontal><vertical><samples>2</samples><min_angle>0</min_angle><max_angle>0.1"
    "</max_angle></vertical></scan><range><min>0.2</min><max>10</max></range></ray>"
)
CONTACT = "<contact><collision>base_collision</collision></contact>"
# library -> kind of its <sensor>, "" for a plugin of the model; the parameters of topic and frame
NAMED = {
    "gazebo_ros_block_laser": ("ray", "topicName", "frameName"),
    "gazebo_ros_laser": ("ray", "topicName", "frameName"),
    "gazebo_ros_gpu_laser": ("ray", "topicName", "frameName"),
    "gazebo_ros_range": ("ray", "topicName", "frameName"),
    "gazebo_ros_velodyne_laser": ("ray", "topicName", "frameName"),
    "gazebo_ros_velodyne_gpu_laser": ("ray", "topicName", "frameName"),
    "hector_gazebo_ros_sonar": ("ray", "topicName", "frameId"),
    "gazebo_ros_imu_sensor": ("imu", "topicName", "frameName"),
    "gazebo_ros_bumper": ("contact", "bumperTopicName", "frameName"),
    "gazebo_ros_imu": ("", "topicName", "frameName"),
    "gazebo_ros_p3d": ("", "topicName", "frameName"),
    "gazebo_ros_f3d": ("", "topicName", "frameName"),
    "gazebo_ros_ft_sensor": ("", "topicName", ""),
    "hector_gazebo_ros_imu": ("", "topicName", "frameId"),
    "hector_gazebo_ros_gps": ("", "topicName", "frameId"),
    "hector_gazebo_ros_magnetic": ("", "topicName", "frameId"),
}
ALWAYS = {  # parameters without which a plugin is none
    "gazebo_ros_ft_sensor": "<jointName>left</jointName>",
    **dict.fromkeys(
        ("gazebo_ros_imu", "gazebo_ros_p3d", "gazebo_ros_f3d", "hector_gazebo_ros_imu",
         "hector_gazebo_ros_gps", "hector_gazebo_ros_magnetic"),
        "<bodyName>base</bodyName>",
    ),
}  # fmt: skip


def made(world, library, tags, always=None):
    """A plugin of a cart before a wall."""
    kind = NAMED[library][0]
    always = ALWAYS.get(library, "") if always is None else always
    content = always + "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags)
    plugin = f'<plugin name="p" filename="lib{library}.so">{content}</plugin>'
    inner = {"ray": RAY, "contact": CONTACT}.get(kind, "")
    sensor = f'<sensor name="s" type="{kind}"><update_rate>10</update_rate>{inner}{plugin}</sensor>'
    element = (
        f'<gazebo reference="base">{sensor}</gazebo>' if kind else f"<gazebo>{plugin}</gazebo>"
    )
    world.spawn(ground_plane())
    world.spawn_sdf("wall", WALL, Pose((5.1, 0.0, 0.0)), str)
    text = CART.replace(
        "<collision><geometry><box", '<collision name="base_collision"><geometry><box'
    )
    cart = world.spawn_urdf(
        "cart", text.replace("</robot>", f"{element}</robot>"), Pose((0, 0, 0.1)), str
    )
    (spec,) = cart.description.sensors
    return plugin_of(world, cart, spec, 1)


def sent(world, topics, library, tags):
    """The topics on which a plugin of a cart has sent something, with their last messages."""
    plugin = made(world, library, tags)
    for _ in range(3):
        world.step(100)
        plugin.update(world.time, 0.0)
    return {name: topic.messages[-1] for name, topic in topics.items() if topic.messages}


@pytest.mark.parametrize("library", NAMED)
def test_messages_come_on_the_topic_and_in_the_frame_that_are_named(world, topics, library):
    _, topic, frame = NAMED[library]
    tags = [("robotNamespace", "ns"), (topic, "given/topic")]
    found = sent(world, topics, library, [*tags, *([(frame, "mine")] if frame else [])])
    assert "/ns/given/topic" in found
    assert found["/ns/given/topic"].header.frame_id == ("mine" if frame else "left_wheel")


def test_the_body_that_is_named_is_measured(world, topics):
    """The left wheel's place; where no frame is named, hector's sensors have the body's name."""
    found = {}
    for library in ("gazebo_ros_p3d", "hector_gazebo_ros_imu", "hector_gazebo_ros_magnetic"):
        for name in list(world.models):
            world.delete(name)
        tags = [("robotNamespace", library), ("topicName", "t"), ("bodyName", "left_wheel")]
        plugin = made(world, library, tags, always="")
        world.step(10)
        for time in (0.5, 1.0, 1.5):
            plugin.update(time, 0.0)
        found[library] = topics[f"/{library}/t"].messages[-1]
    assert found["gazebo_ros_p3d"].pose.pose.position.y == pytest.approx(0.15, abs=0.01)
    for library in ("hector_gazebo_ros_imu", "hector_gazebo_ros_magnetic"):
        assert found[library].header.frame_id == "left_wheel"
