"""Robots for tests of every plugin: of a model, or of a sensor of the kind that it takes."""

from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins import PLUGINS, SENSOR_PLUGINS

NAMES = (
    "front_steering", "front_wheel", "left_wheel", "right_wheel", "left", "right", "front_left",
    "front_right", "rear_left", "rear_right", "left_front", "right_front", "left_rear",
    "right_rear", "spare",
)  # fmt: skip
LINKS = (
    '<link name="foot"/><link name="base"/><joint name="f" type="fixed"><parent link="foot"/>'
    '<child link="base"/></joint>'
    + "".join(
        f'<link name="{name}"/><joint name="{name}_joint" type="continuous"><parent link="base"/>'
        f'<child link="{name}"/></joint>'
        for name in NAMES
    )
)
CAMERA = "<camera name='left'><horizontal_fov>1</horizontal_fov></camera>"
SENSORS = {  # type of <sensor> -> its content
    "camera": CAMERA,
    "multicamera": CAMERA,
    "depth": CAMERA,
    "ray": "<ray/>",
    "imu": "",
    "contact": "<contact><collision>base_collision</collision></contact>",
}


def robot_with(library, content):
    """The description of a robot, 'bot', with a plugin of its model or of a sensor."""
    plugin = f'<plugin name="p" filename="lib{library}.so">{content}</plugin>'
    if library in PLUGINS.names():
        body = f"<gazebo>{plugin}</gazebo>"
    else:
        kind = next(kind for kind in SENSORS if kind in SENSOR_PLUGINS.find(library).types)
        body = (
            f'<gazebo reference="base"><sensor name="s" type="{kind}"><update_rate>10'
            f"</update_rate>{SENSORS[kind]}{plugin}</sensor></gazebo>"
        )
    return parse_urdf(f'<robot name="r">{LINKS}{body}</robot>', str, "bot")
