"""Worlds with what makes worlds slow, one cause each, for Paddock and for Gazebo.

A world is an SDF file with meshes beside it. In each a robot on two wheels and a ball drives a
circle by libgazebo_ros_diff_drive.so.
"""

import pathlib
from dataclasses import dataclass

import numpy as np
from worlds.core import INERTIAL, hills

SPEED, TURN = 0.3, 0.5  # of the robot [m/s], [rad/s]
COMMANDS, ODOMETRY = "/cmd_vel", "/odom"
WORLD = """<sdf version="1.6"><world name="default">
<physics type="ode"><max_step_size>0.001</max_step_size><real_time_factor>1</real_time_factor>
<real_time_update_rate>0</real_time_update_rate></physics>
<light type="directional" name="sun"><pose>0 0 10 0 0 0</pose><direction>-0.5 0.1 -0.9</direction>
<diffuse>0.8 0.8 0.8 1</diffuse><cast_shadows>false</cast_shadows></light>
<scene><ambient>0.4 0.4 0.4 1</ambient><background>0.7 0.7 0.7 1</background>
<shadows>false</shadows></scene>
{things}
{robot}
</world></sdf>
"""
GROUND = (
    '<model name="ground"><static>true</static><link name="link"><collision name="c"><geometry>'
    "<plane><normal>0 0 1</normal><size>100 100</size></plane></geometry></collision>"
    '<visual name="v"><geometry><plane><normal>0 0 1</normal><size>100 100</size></plane>'
    "</geometry></visual></link></model>"
)
ROBOT = """<model name="robot"><pose>0 0 {height} 0 0 0</pose>
<link name="base">{inertial}
{body}
<collision name="ball"><pose>-0.15 0 -0.06 0 0 0</pose><geometry><sphere><radius>0.04</radius>
</sphere></geometry><surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface>
</collision>
{sensors}</link>
{wheels}
<plugin name="drive" filename="libgazebo_ros_diff_drive.so">
<robotNamespace>/</robotNamespace><updateRate>50</updateRate>
<leftJoint>left_joint</leftJoint><rightJoint>right_joint</rightJoint>
<wheelSeparation>0.36</wheelSeparation><wheelDiameter>0.2</wheelDiameter>
<wheelTorque>5</wheelTorque><commandTopic>cmd_vel</commandTopic>
<odometryTopic>odom</odometryTopic><odometryFrame>odom</odometryFrame>
<robotBaseFrame>base</robotBaseFrame><publishWheelTF>false</publishWheelTF>
<publishWheelJointState>false</publishWheelJointState><odometrySource>encoder</odometrySource>
<publishTf>1</publishTf></plugin></model>
"""
WHEEL = """<link name="{name}"><pose>0.05 {y} 0 -1.5707963267948966 0 0</pose>{inertial}
{shape}</link>
<joint name="{name}_joint" type="revolute"><parent>base</parent><child>{name}</child>
<axis><xyz>0 1 0</xyz><use_parent_model_frame>1</use_parent_model_frame></axis></joint>
"""
LIDAR = """<sensor name="lidar" type="ray"><pose>0 0 0.2 0 0 0</pose>
<update_rate>{rate}</update_rate>
<ray><scan><horizontal><samples>{samples}</samples><min_angle>-3.1</min_angle>
<max_angle>3.1</max_angle></horizontal><vertical><samples>{layers}</samples>
<min_angle>{low}</min_angle><max_angle>{high}</max_angle></vertical></scan>
<range><min>0.3</min><max>30</max></range></ray>
<plugin name="lidar" filename="{plugin}"><robotNamespace>/</robotNamespace>
<topicName>/scan</topicName><frameName>base</frameName></plugin></sensor>"""
IMU = """<sensor name="imu" type="imu"><update_rate>1000</update_rate>
<plugin name="imu" filename="libgazebo_ros_imu_sensor.so">
<robotNamespace>/</robotNamespace><topicName>/imu</topicName>
<bodyName>base</bodyName><frameName>base</frameName><updateRateHZ>1000</updateRateHZ>
<gaussianNoise>0</gaussianNoise></plugin></sensor>"""
CAMERA = """<sensor name="{name}" type="{kind}"><pose>0 0 0.2 0 0 {yaw}</pose>
<update_rate>30</update_rate><camera><horizontal_fov>1.3</horizontal_fov><image><width>{width}</width>
<height>{height}</height><format>R8G8B8</format></image><clip><near>0.05</near><far>50</far></clip>
</camera><plugin name="{name}" filename="{plugin}">
<robotNamespace>/</robotNamespace><cameraName>{name}</cameraName>
<imageTopicName>image</imageTopicName><cameraInfoTopicName>camera_info</cameraInfoTopicName>
<depthImageTopicName>depth/image</depthImageTopicName>
<depthImageCameraInfoTopicName>depth/camera_info</depthImageCameraInfoTopicName>
<pointCloudTopicName>points</pointCloudTopicName><pointCloudCutoff>0.1</pointCloudCutoff>
<frameName>base</frameName><updateRate>30</updateRate></plugin></sensor>"""
OMNI = """<model name="robot"><pose>0 0 0.051 0 0 0</pose><link name="base">{inertial}
{body}
{sensors}<sensor name="bumper" type="contact"><update_rate>1000</update_rate>
<contact><collision>c</collision></contact><plugin name="bumper" filename="libgazebo_ros_bumper.so">
<bumperTopicName>/bumper</bumperTopicName><frameName>base</frameName></plugin></sensor></link>
<plugin name="drive" filename="libgazebo_ros_planar_move.so"><commandTopic>cmd_vel</commandTopic>
<odometryTopic>odom</odometryTopic><odometryFrame>odom</odometryFrame>
<odometryRate>50</odometryRate><robotBaseFrame>base</robotBaseFrame></plugin></model>
"""
TIRE = "<cylinder><radius>0.1</radius><length>0.04</length></cylinder>"
BOX = "<box><size>0.2 0.2 0.2</size></box>"
BALL = "<sphere><radius>0.1</radius></sphere>"
CAN = "<cylinder><radius>0.1</radius><length>0.2</length></cylinder>"
POST = "<box><size>0.1 0.1 1</size></box>"


def solid(shape):
    """A collision and a visual of one shape."""
    return (
        f'<collision name="c"><geometry>{shape}</geometry></collision>'
        f'<visual name="v"><geometry>{shape}</geometry></visual>'
    )


def thing(name, shape, place, mass=0.0):
    """A model of one shape at a place [m]; static without a mass [kg]."""
    inertial = INERTIAL.format(mass, 0.01 * mass) if mass else ""
    at = " ".join(f"{value:.4f}" for value in place)
    return (
        f'<model name="{name}"><static>{int(not mass)}</static><pose>{at} 0 0 0</pose>'
        f'<link name="link">{inertial}{solid(shape)}</link></model>'
    )


def ring(count, step=24):
    """Places on circles around the robot's, whose circle has a radius of 0.6 m."""
    for number in range(count):
        radius, angle = 2.0 + number // step, 2.0 * np.pi * (number % step) / step
        yield radius * np.cos(angle), 0.6 + radius * np.sin(angle)


def mesh(path):
    """Geometry of a file."""
    return f"<mesh><uri>file://{path}</uri></mesh>"


def write_ring(path, around=24, across=12):
    """Write an OBJ of 2 around x across triangles that is not convex: a ring, lying [m]."""
    one = 2.0 * np.pi * np.arange(around)[:, None] / around
    other = 2.0 * np.pi * np.arange(across)[None, :] / across
    radius = 0.2 + 0.06 * np.cos(other)
    points = np.stack(
        [radius * np.cos(one), radius * np.sin(one), 0.06 * np.sin(other) + 0.0 * one], axis=-1
    )
    lines = ["v {:.5f} {:.5f} {:.5f}".format(*point) for point in points.reshape(-1, 3)]
    for i in range(around):
        for j in range(across):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            a, b, c, d = (1 + (k % around) * across + n % across for k, n in corners)
            lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    path.write_text("\n".join(lines) + "\n")


def robot(sensors="", height=0.1, tire=TIRE):
    """The robot, its wheels' middles at a height [m]; tire: their shape."""
    wheel = solid(tire)
    wheels = [
        WHEEL.format(name=name, y=y, inertial=INERTIAL.format(0.5, 0.002), shape=wheel)
        for name, y in (("left", 0.18), ("right", -0.18))
    ]
    return ROBOT.format(
        height=height,
        inertial=INERTIAL.format(5.0, 0.1),
        body=solid("<box><size>0.4 0.3 0.1</size></box>"),
        sensors=sensors,
        wheels="".join(wheels),
    )


def omni(sensors=""):
    """A box on the ground that libgazebo_ros_planar_move.so moves, with a bumper at each step."""
    body = solid("<box><size>0.4 0.3 0.1</size></box>")
    return OMNI.format(inertial=INERTIAL.format(5.0, 0.1), body=body, sensors=sensors)


def write_tire(path, around=64):
    """Write an OBJ of 4 x around triangles: a TIRE."""
    angles = 2.0 * np.pi * np.arange(around) / around
    ends = np.stack([0.1 * np.cos(angles), 0.1 * np.sin(angles)], axis=1)
    points = [(x, y, z) for x, y in ends for z in (-0.02, 0.02)] + [(0, 0, -0.02), (0, 0, 0.02)]
    lines = ["v {:.5f} {:.5f} {:.5f}".format(*point) for point in points]
    low, high = 2 * around + 1, 2 * around + 2
    for i in range(around):
        a, b, c, d = 2 * i + 1, 2 * i + 2, 2 * ((i + 1) % around) + 1, 2 * ((i + 1) % around) + 2
        triangles = (a, c, d), (a, d, b), (low, c, a), (high, b, d)
        lines += ["f {} {} {}".format(*triangle) for triangle in triangles]
    path.write_text("\n".join(lines) + "\n")


def posts():
    """Eighty posts around the robot."""
    return [thing(f"post{i}", POST, (*at, 0.5)) for i, at in enumerate(ring(80))]


def lidar(samples, rate, layers=1, plugin="libgazebo_ros_laser.so"):
    """A lidar; several layers are within 15 degrees of the horizon."""
    high = 0.26 if layers > 1 else 0.0
    return LIDAR.format(
        samples=samples, rate=rate, layers=layers, low=-high, high=high, plugin=plugin
    )


def camera(name, yaw, size, kind="camera", plugin="libgazebo_ros_camera.so"):
    """A camera of 30 Hz that looks to a yaw [rad]."""
    return CAMERA.format(
        name=name, yaw=yaw, width=size[0], height=size[1], kind=kind, plugin=plugin
    )


def loose(seen_as):
    """Fifty boxes, balls and cans in piles of two, let go a centimeter above each other."""
    shapes = (BOX, CAN, BALL)
    return [
        thing(f"thing{i}", shapes[i % 3] if i % 2 else BOX, (*at, 0.11 + 0.21 * (i % 2)), 0.5)
        for i, at in enumerate(place for place in ring(25) for _ in range(2))
    ]


def rings(seen_as, count, mass):
    """Rings of triangles around the robot, static without a mass [kg]."""
    shape = mesh(f"{seen_as}/ring.obj")
    return [thing(f"ring{i}", shape, (*at, 0.12), mass) for i, at in enumerate(ring(count))]


def on_hills(seen_as):
    """A ground of 20,000 triangles with six rings lying on it."""
    ground = thing("hills", mesh(f"{seen_as}/hills.obj"), (0.0, 0.0, -1.0))
    return [ground, *rings(seen_as, 6, 0.5)]


@dataclass(frozen=True)
class Cause:
    """A world.

    Attributes:
        text: what is in it, for the table.
        things: function of the path of its folder where it is loaded: models beside the robot.
        sensors: of the robot.
        topics: subscribed beyond the odometry.
        pictures: those of them that Gazebo drops when it cannot draw as fast as it steps.
        plane: whether the robot stands on the plane.
        robot: function of the path of its folder, the sensors and the height.
    """

    text: str
    things: object = lambda seen_as: []
    sensors: str = ""
    topics: tuple = ()
    pictures: tuple = ()
    plane: bool = True
    robot: object = lambda seen_as, sensors, height: robot(sensors, height)


FOUR = ("front", "left", "rear", "right")
CAUSES = {
    "plain": Cause("the robot alone"),
    "lidar": Cause("1,081 rays at 40 Hz, 80 posts", lambda _: posts(), lidar(1081, 40), ("/scan",)),
    "lidar_16_layers": Cause(
        "16 layers of 900 points at 10 Hz, 80 posts",
        lambda _: posts(),
        lidar(900, 10, 16, "libgazebo_ros_block_laser.so"),
        ("/scan",),
    ),
    "imu_1_khz": Cause("an IMU at 1 kHz", sensors=IMU, topics=("/imu",)),
    "concave_meshes": Cause(
        "a mesh as ground, six rings of triangles on it", on_hills, plane=False
    ),
    "mesh_wheels": Cause(
        "wheels of 256 triangles on a ground of 20,000",
        lambda seen_as: [thing("hills", mesh(f"{seen_as}/hills.obj"), (0.0, 0.0, -1.0))],
        plane=False,
        robot=lambda seen_as, sensors, height: robot(sensors, height, mesh(f"{seen_as}/tire.obj")),
    ),
    "omni_bumper": Cause(
        "planar_move, two lidars, a bumper at each step, 80 posts",
        lambda _: posts(),
        lidar(720, 20) + lidar(720, 20).replace('"lidar"', '"rear"').replace("/scan<", "/rear<"),
        ("/scan", "/rear", "/bumper"),
        robot=lambda seen_as, sensors, height: omni(sensors),
    ),
    "static_meshes": Cause("300 static meshes", lambda seen_as: rings(seen_as, 300, 0.0)),
    "loose_things": Cause("fifty loose things", loose),
    "four_cameras": Cause(
        "four cameras 320x240 at 30 Hz",
        lambda _: posts(),
        "".join(camera(name, 1.5708 * i, (320, 240)) for i, name in enumerate(FOUR)),
        tuple(f"/{name}/image" for name in FOUR),
        tuple(f"/{name}/image" for name in FOUR),
    ),
    "depth_camera": Cause(
        "a depth camera 640x480 with points at 30 Hz",
        lambda _: posts(),
        camera("depth", 0.0, (640, 480), "depth", "libgazebo_ros_openni_kinect.so"),
        ("/depth/depth/image", "/depth/points"),
        ("/depth/depth/image", "/depth/points"),
    ),
}


def write(folder, name, seen_as=None):
    """Write a world and its meshes.

    Args:
        seen_as: the folder's path where it is loaded; None: the same.

    Returns:
        Path of the world file.
    """
    folder = pathlib.Path(folder)
    seen_as, cause = seen_as or str(folder.resolve()), CAUSES[name]
    hills(folder / "hills.obj", 100, height=0.05)
    write_ring(folder / "ring.obj")
    write_tire(folder / "tire.obj")
    things = ([GROUND] if cause.plane else []) + cause.things(seen_as)
    height = 0.101 if cause.plane else 0.16
    path = folder / f"{name}.world"
    path.write_text(
        WORLD.format(things="\n".join(things), robot=cause.robot(seen_as, cause.sensors, height))
    )
    return path
