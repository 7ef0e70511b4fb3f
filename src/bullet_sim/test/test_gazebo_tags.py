"""<gazebo> elements: sensors with their plugins' names, surfaces, colours, warnings."""

import math

import pytest
from bullet_sim.formats.materials import standard
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.plugins.contacts import ContactSpec
from bullet_sim.plugins.depth_cameras import DepthCameraSpec
from bullet_sim.plugins.grasping import GripperSpec
from bullet_sim.plugins.inertial import ImuSpec
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose

pytestmark = pytest.mark.usefixtures("sketches")

LINKS = (
    '<link name="base"><visual><geometry><box size="1 1 1"/></geometry></visual><collision>'
    '<geometry><box size="1 1 1"/></geometry></collision></link><link name="head"/>'
    '<joint name="neck" type="fixed"><parent link="base"/><child link="head"/></joint>'
)


def read(gazebo, name="car"):
    """ModelDescription of a two-link robot with <gazebo> elements."""
    return parse_urdf(f'<robot name="r">{LINKS}{gazebo}</robot>', str, name)


def sensor(kind, plugin, tags="", inside="", name="eye"):
    """A <gazebo reference="base"> with one sensor."""
    return (
        f'<gazebo reference="base"><sensor type="{kind}" name="{name}">'
        f"<pose>1 0 0 0 0 0</pose>{inside}"
        f'<plugin name="p" filename="{plugin}">{tags}</plugin></sensor></gazebo>'
    )


def one(gazebo, name="car"):
    """The one sensor of a robot, which must not warn."""
    model = read(gazebo, name)
    assert model.warnings == []
    (spec,) = model.sensors
    return spec


CAMERA = (
    "<camera><image><width>64</width><height>48</height></image></camera>"
    "<update_rate>20</update_rate>"
)


@pytest.mark.parametrize(
    "tags, topic, info, frame",
    [
        ("", "/image_raw", "/camera_info", ""),
        (
            "<cameraName>cam</cameraName><frameName>f</frameName>",
            "/cam/image_raw",
            "/cam/camera_info",
            "f",
        ),
        (
            "<robotNamespace>/bot/</robotNamespace><cameraName>a/b</cameraName><imageTopicName>rgb"
            "</imageTopicName><cameraInfoTopicName>info</cameraInfoTopicName><frameName>f</frameName>",
            "/bot/a/b/rgb",
            "/bot/a/b/info",
            "f",
        ),
        (
            "<robotNamespace>bot</robotNamespace><imageTopicName>/abs</imageTopicName>"
            "<frameName>/f</frameName>",
            "/abs",
            "/bot/camera_info",
            "f",
        ),
        (
            "<robotNamespace></robotNamespace><cameraName>c</cameraName><frameName>f</frameName>",
            "/car/c/image_raw",
            "/car/c/camera_info",
            "f",
        ),
        (
            "<robotNamespace>/</robotNamespace><cameraName>c</cameraName><frameName>f</frameName>",
            "/c/image_raw",
            "/c/camera_info",
            "f",
        ),
    ],
)
def test_names_of_a_camera(tags, topic, info, frame):
    spec = one(sensor("camera", "libgazebo_ros_camera.so", tags, CAMERA))
    assert type(spec) is CameraSpec
    assert (spec.topic, spec.info_topic, spec.frame_id) == (topic, info, frame)
    assert (spec.width, spec.height, spec.rate, spec.link) == (64, 48, 20.0, "base")
    assert spec.pose[0] == (1, 0, 0)


@pytest.mark.parametrize(
    "inside, tags, rate",
    [
        ("<update_rate>20</update_rate>", "", 20),
        ("<update_rate>20</update_rate>", "<updateRate>0.0</updateRate>", 20),
        ("<update_rate>20</update_rate>", "<updateRate>5</updateRate>", 20),
        ("<update_rate>20</update_rate>", "<updateRate>50</updateRate>", 20),
        ("", "<updateRate>7</updateRate>", 7),
    ],
)
def test_the_rate_is_the_sensors_and_the_plugin_leaves_images_out(inside, tags, rate):
    spec = one(sensor("camera", "libgazebo_ros_camera.so", tags, inside))
    limit = float(tags[12:-13]) if tags else 0.0
    assert (spec.rate, spec.plugin_rate, spec.is_free) == (rate, limit, not inside)


@pytest.mark.parametrize("library", ["depth_camera", "openni_kinect"])
@pytest.mark.parametrize("inside, rate, limit", [("<update_rate>20</update_rate>", 20, 7),
                                                 ("", 7, 0)])  # fmt: skip
def test_a_depth_camera_has_the_rate_of_its_sensor(library, inside, rate, limit):
    """The plugin's limits camera_info alone (Robotnik's rb1: 20 images per second in Gazebo)."""
    tags = "<updateRate>7</updateRate>"
    spec = one(sensor("depth", f"libgazebo_ros_{library}.so", tags, inside))
    assert (spec.rate, spec.plugin_rate) == (rate, limit)
    assert spec.tells_info == (library == "openni_kinect"), "depth_camera calls it nowhere"


def test_a_prosilica_publishes_no_images_and_says_so():
    model = read(sensor("camera", "libgazebo_ros_prosilica.so"))
    assert model.sensors == [] and "polled_camera" in model.warnings[0]


def test_no_rate_at_all_is_said():
    model = read(sensor("camera", "libgazebo_ros_camera.so"))
    assert model.sensors[0].rate == 30 and "sensor 'eye'" in model.warnings[0]


def test_a_multicamera_is_a_left_and_a_right_camera():
    """With the topics, poses and baseline of libgazebo_ros_multicamera.so."""
    camera = (
        '<camera name="{}"><pose>0 {} 0 0 0 0</pose><image><width>{}</width><height>24</height>'
        "</image></camera>"
    )
    inside = (
        "<update_rate>15</update_rate>"
        + camera.format("eye_left", 0, 32)
        + camera.format("eye_right", -0.1, 40)
        + camera.format("middle", 0, 32)
    )
    tags = (
        "<cameraName>stereo</cameraName><imageTopicName>image_raw</imageTopicName>"
        "<frameName>optical</frameName><hackBaseline>0.1</hackBaseline>"
    )
    model = read(sensor("multicamera", "libgazebo_ros_multicamera.so", tags, inside))
    left, right = model.sensors
    assert (left.topic, left.info_topic) == ("/stereo/left/image_raw", "/stereo/left/camera_info")
    assert (right.topic, right.info_topic) == (
        "/stereo/right/image_raw",
        "/stereo/right/camera_info",
    )
    assert (left.baseline, right.baseline) == (0.0, 0.1)
    assert (left.width, right.width, left.rate, left.frame_id) == (32, 40, 15.0, "optical")
    assert left.pose[0] == (1, 0, 0) and right.pose[0] == (1, -0.1, 0)
    (warning,) = [text for text in model.warnings if "multi" not in text]
    assert "camera 'middle' is left out" in warning and "'left' or 'right'" in warning


def test_a_multicamera_whose_right_camera_comes_first_has_its_images_on_the_others_topics():
    camera = '<camera name="{}"><pose>0 {} 0 0 0 0</pose></camera>'
    inside = "<update_rate>15</update_rate>" + camera.format("right", -0.1)
    inside += camera.format("left", 0.0)
    tags = "<cameraName>stereo</cameraName><imageTopicName>image_raw</imageTopicName>"
    model = read(sensor("multicamera", "libgazebo_ros_multicamera.so", tags, inside))
    places = {spec.topic: spec.pose[0] for spec in model.sensors}
    assert places == {"/stereo/right/image_raw": (1, 0, 0), "/stereo/left/image_raw": (1, -0.1, 0)}


def test_camera_noise_format_and_baseline():
    inside = (
        "<update_rate>1</update_rate><camera><image><format>L8</format></image><noise>"
        "<type>gaussian</type><mean>0.01</mean><stddev>0.007</stddev></noise></camera>"
    )
    spec = one(
        sensor("camera", "libgazebo_ros_camera.so", "<hackBaseline>0.07</hackBaseline>", inside)
    )
    assert (spec.noise_mean, spec.noise_stddev, spec.encoding) == (0.01, 0.007, "mono8")
    assert spec.baseline == 0.07


@pytest.mark.parametrize(
    "plugin, furthest",
    [("libgazebo_ros_depth_camera.so", math.inf), ("libgazebo_ros_openni_kinect.so", 5.0)],
)
def test_depth_camera_defaults(plugin, furthest):
    spec = one(sensor("depth", plugin, "<cameraName>k</cameraName>", CAMERA))
    assert type(spec) is DepthCameraSpec
    assert (spec.topic, spec.info_topic) == ("/k/image_raw", "/k/camera_info")
    assert (spec.depth_topic, spec.depth_info_topic) == (
        "/k/depth/image_raw",
        "/k/depth/camera_info",
    )
    assert (spec.points_topic, spec.cutoff, spec.cutoff_max) == ("/k/points", 0.4, furthest)


RAY = (
    "<update_rate>40</update_rate><visualize>true</visualize><ray><scan><horizontal><samples>"
    "181</samples><min_angle>-1.5</min_angle><max_angle>1.5</max_angle></horizontal></scan>"
    "<range><min>0.1</min><max>8</max></range><noise><type>gaussian</type><mean>0.1</mean>"
    "<stddev>0.01</stddev></noise></ray>"
)


@pytest.mark.parametrize("text, mask", [("", 0x0FFFFFFC), ("7", 4), ("4294967295", 0x0FFFFFFC)])
def test_the_mask_of_a_camera(text, mask):
    tag = f"<visibility_mask>{text}</visibility_mask>" if text else ""
    inner = f"<camera><horizontal_fov>1</horizontal_fov>{tag}</camera>"
    assert (
        one(
            sensor("camera", "libgazebo_ros_camera.so", "<updateRate>9</updateRate>", inner)
        ).visibility
        == mask
    )


@pytest.mark.parametrize(
    "kind, plugin",
    [
        ("ray", "libgazebo_ros_laser.so"),
        ("gpu_ray", "/opt/x/libgazebo_ros_gpu_laser.so"),
        ("ray", "gazebo_ros_laser"),
    ],
)
def test_lidar(kind, plugin):
    tags = "<topicName>scan</topicName><frameName>head</frameName><updateRate>3</updateRate>"
    spec = one(sensor(kind, plugin, tags, RAY))
    assert spec == RaySpec(
        "eye",
        "base",
        ((1, 0, 0), (0, 0, 0)),
        181,
        -1.5,
        1.5,
        0.1,
        8.0,
        40.0,
        0.01,
        "/scan",
        "head",
        True,
        0.1,
        sees_visuals=kind == "gpu_ray",
    )


def test_imu_sensor():
    inside = (
        '<update_rate>200</update_rate><imu><angular_velocity><x><noise type="gaussian">'
        "<mean>0.1</mean><stddev>0.3</stddev></noise></x></angular_velocity></imu>"
    )
    tags = (
        "<robotNamespace>/n</robotNamespace><topicName>/imu</topicName><frameName>imu_link"
        "</frameName><updateRateHZ>50</updateRateHZ><gaussianNoise>0.4</gaussianNoise>"
    )
    spec = one(sensor("imu", "libgazebo_ros_imu_sensor.so", tags, inside))
    assert type(spec) is ImuSpec
    assert (spec.topic, spec.frame_id, spec.rate) == ("/imu", "imu_link", 50)
    assert (spec.gyro_noise_mean, spec.accel_noise_mean) == ((0.1, 0.0, 0.0), 0.0)
    assert spec.gyro_noise_stddev == pytest.approx((0.5, 0.4, 0.4))
    assert spec.accel_noise_stddev == pytest.approx(0.4)
    assert spec.variance == pytest.approx(0.16)


@pytest.mark.parametrize(
    "own, wanted, rate", [(100, 30, 25.0), (100, 50, 50.0), (90, 30, 30.0), (50, 100, 50.0)]
)
def test_an_imu_sensor_waits_for_a_measurement_that_is_late_enough(own, wanted, rate):
    tags = f"<frameName>f</frameName><updateRateHZ>{wanted}</updateRateHZ>"
    inside = f"<update_rate>{own}</update_rate>"
    spec = one(sensor("imu", "libgazebo_ros_imu_sensor.so", tags, inside))
    assert spec.rate == pytest.approx(rate)


def test_an_imu_sensor_without_a_frame_is_left_out():
    model = read(sensor("imu", "libgazebo_ros_imu_sensor.so"))
    assert not model.sensors and "has no frameName" in model.warnings[0]


def test_imu_model_plugin():
    plugin = (
        '<gazebo><plugin name="i" filename="libgazebo_ros_imu.so"><bodyName>head</bodyName>'
        "<topicName>imu/data</topicName><gaussianNoise>0.2</gaussianNoise>{}</plugin>"
        "</gazebo>"
    )
    spec = one(plugin.format("<updateRate>0</updateRate><robotNamespace>a</robotNamespace>"))
    assert (spec.topic, spec.frame_id, spec.rate) == ("/a/imu/data", "base", 0.0)
    assert spec.accel_noise_stddev == 0.2
    for frame, found in (("head", "base"), ("base", "base"), ("/mast", "/mast")):  # as sdformat
        assert one(plugin.format(f"<frameName>{frame}</frameName>")).frame_id == found
    model = read(plugin.replace(">head<", ">tail<").format(""))
    assert model.sensors == [] and "bodyName 'tail'" in model.warnings[0]


def test_bumper():
    inside = "<update_rate>10</update_rate><contact><collision>base_collision</collision></contact>"
    spec = one(
        sensor(
            "contact",
            "libgazebo_ros_bumper.so",
            "<bumperTopicName>hit</bumperTopicName><frameName>base</frameName>",
            inside,
        )
    )
    assert spec == ContactSpec("eye", "base", ("base_collision",), 10.0, "/hit", "base")
    plain = one(sensor("contact", "libgazebo_ros_bumper.so"))
    assert (plain.topic, plain.frame_id, plain.rate) == ("/bumper_states", "world", 0.0)


P3D = (
    '<gazebo><plugin filename="libgazebo_ros_p3d.so"><topicName>t</topicName><bodyName>{}'
    "</bodyName><frameName>{}</frameName>{}</plugin></gazebo>"
)


@pytest.mark.parametrize("body, frame", [("mast", "world"), ("base", "mast"), ("mast", "mast")])
def test_p3d_of_merged_links_is_as_sdformat_writes_it(body, frame):
    """Of the link that remains, with the joint's origin in the offset, once for each name."""
    mast = (
        '<link name="mast"/><joint name="m" type="fixed"><parent link="base"/><child link="mast"/>'
        '<origin xyz="1 2 3"/></joint>'
    )
    gazebo = P3D.format(body, frame, "<xyzOffset>0 0 1</xyzOffset>")
    spec = one(mast + gazebo)
    count = (body == "mast") + (frame == "mast")
    left = "world" if frame == "world" else "base"
    assert (spec.link, spec.child_frame_id, spec.frame_id) == ("base", "base", left)
    assert spec.reference == ("" if frame == "world" else "base")
    assert spec.offset[0] == pytest.approx((-count, -2 * count, 1 - 3 * count))


def test_the_offset_of_a_p3d_of_a_merged_link_is_turned_back_as_measured_in_gazebo():
    """The link at (1, 2, 0.1), turned by 0.6, is told at (0.9, 1.8, -0.2); angles are degrees."""
    mast = (
        '<link name="mast"/><joint name="m" type="fixed"><parent link="base"/><child link="mast"/>'
        '<origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/></joint>'
    )
    xyz, rpy = one(mast + P3D.format("mast", "world", "")).offset
    assert xyz == pytest.approx((-0.1, -0.2, -0.3))
    told = Pose((0, 0, 0), Pose.from_xyz_rpy((0, 0, 0), rpy).orientation) * Pose.from_xyz_rpy(
        (0, 0, 0), (0, 0, 0.6)
    )
    assert told.orientation == pytest.approx((-0.16849, -0.05886, 0.25786, 0.94956), abs=1e-5)
    _, rpy = one(mast + P3D.format("mast", "world", "<rpyOffset>0 0 90</rpyOffset>")).offset
    turned = Pose.from_xyz_rpy((0, 0, 0), (0.3, 0.2, 0.1)) * Pose.from_xyz_rpy((0, 0, 0), rpy)
    assert turned.rpy == pytest.approx((0.0, 0.0, math.pi / 2.0), abs=1e-9)


@pytest.mark.parametrize(
    "gazebo, words",
    [
        (sensor("sonar", "libx.so"), ["sensor 'eye'", "type 'sonar'", "gpu_ray"]),
        (
            sensor("ray", "libgazebo_ros_sonic.so"),
            ["'libgazebo_ros_sonic.so'", "sensor 'eye'", "libgazebo_ros_laser.so"],
        ),
        ('<gazebo><plugin name="a" filename="libfoo.so"/></gazebo>' * 2, ["'libfoo.so'"]),
        ('<gazebo reference="base"><glitter>1</glitter></gazebo>' * 2, ["<glitter>", "'base'"]),
        ('<gazebo reference="nose"><mu1>1</mu1></gazebo>', ["'nose'", "no link"]),
        ('<gazebo reference="base"><material>Mine/Plaid</material></gazebo>', ["'Mine/Plaid'"]),
        (
            '<gazebo reference="head"><sensor type="ray" name="bare"/></gazebo>',
            ["'bare'", "plugin"],
        ),
    ],
)
def test_one_warning_by_name(gazebo, words):
    model = read(gazebo)
    assert len(model.warnings) == 1 and model.sensors == []
    for word in words:
        assert word in model.warnings[0]


QUIET = [
    "<maxVel>1</maxVel><minDepth>0.01</minDepth><dampingFactor>0.1</dampingFactor>",
    "<implicitSpringDamper>1</implicitSpringDamper><fdir1>1 0 0</fdir1>",
    "<kp>1e9</kp><kd>1</kd><mu1>0.5</mu1><mu2>0.5</mu2><laserRetro>0</laserRetro>",
]


@pytest.mark.parametrize("tags", QUIET)
def test_usual_tags_are_quiet(tags):
    assert read(f'<gazebo reference="base">{tags}</gazebo>').warnings == []
    assert (
        read(
            '<gazebo reference="neck"><preserveFixedJoint>false</preserveFixedJoint>'
            "<disableFixedJointLumping>false</disableFixedJointLumping>"
            "<provideFeedback>true</provideFeedback></gazebo>"
        ).warnings
        == []
    )


def test_what_merged_links_say_first_about_decay_counts():
    first, last = (
        f'<gazebo reference="{name}"><dampingFactor>{value}</dampingFactor></gazebo>'
        for name, value in (("base", 0.1), ("head", 0.2))
    )
    for gazebo, decay in (("", 0.0), (first, 0.1), (last, 0.2), (last + first, 0.1)):
        links = read(gazebo).links
        assert links["base"].decay == links["head"].decay == (decay, decay)


def test_elements_of_sdf_within_a_urdf():
    """What sdformat does not know it copies into the link, behind its own, or into the model."""
    decay = "<velocity_decay><linear>0.1</linear><angular>0.2</angular></velocity_decay>"
    model = read(
        f'<gazebo reference="base">{decay}</gazebo>'
        "<gazebo><allow_auto_disable>false</allow_auto_disable></gazebo>"
    )
    assert model.links["base"].decay == (0.0, 0.0) and not model.auto_disable
    (warning,) = model.warnings
    assert "<velocity_decay> has no effect" in warning and "<dampingFactor>" in warning
    assert read("").auto_disable


def test_a_collide_bitmask_counts_in_a_collision_alone():
    mask = "<collide_bitmask>2</collide_bitmask>"
    model = read(f'<gazebo reference="base">{mask}</gazebo>')
    assert model.links["base"].surface.bitmask == 0xFFFF and len(model.warnings) == 1
    mask = f"<collision><surface><contact>{mask}</contact></surface></collision>"
    model = read(f'<gazebo reference="base">{mask}</gazebo>')
    assert model.links["base"].surface.bitmask == 2 and model.warnings == []


def test_what_is_within_a_visual_and_a_collision():
    inside = "<transparency>0.25</transparency><cast_shadows>false</cast_shadows>"
    inside += "<visibility_flags>48</visibility_flags><laser_retro>7</laser_retro>"
    inside += "<pose>1 2 3 0 0 0</pose>"  # which has no effect
    model = read(
        f'<gazebo reference="base"><material>Gazebo/Blue</material><visual>{inside}</visual>'
        "<collision><laser_retro>9</laser_retro></collision></gazebo>"
    )
    link, blue = model.links["base"], standard("Gazebo/Blue").color
    (visual,) = link.visuals
    assert visual.color == (*blue[:3], 0.75) and not visual.finish.cast_shadows
    assert visual.visibility == 48 and visual.laser_retro == 7.0
    assert visual.pose.position != (1.0, 2.0, 3.0)
    assert [shape.laser_retro for shape in link.collisions] == [9.0] * len(link.collisions)
    assert model.warnings == []


@pytest.mark.parametrize("tag", ["gripper", "projector"])
def test_elements_that_are_ignored_are_named(tag):
    (warning,) = read(f'<gazebo reference="base"><{tag}>1</{tag}></gazebo>').warnings
    assert f"<{tag}>" in warning and "ignored" in warning


def test_a_gripper_of_a_urdf_is_that_of_its_sdf():
    """sdformat copies it into the model where <gazebo> names no link, else into a link."""
    text = (
        "<gripper name='g'><palm_link>base</palm_link><gripper_link>base</gripper_link>"
        "<grasp_check><attach_steps>7</attach_steps></grasp_check></gripper>"
    )
    model = read(f"<gazebo>{text}</gazebo>")
    assert model.sensors == [GripperSpec("g", "base", ("base",), 2, 7, 40)] and not model.warnings


NAMED = """<robot name="r"><link name="base">%s</link><link name="head">%s</link>
<joint name="j" type="fixed"><parent link="base"/><child link="head"/></joint>
<link name="base_two">%s</link>
<joint name="k" type="fixed"><parent link="base"/><child link="base_two"/></joint>
<gazebo reference="base"><mu1>0.1</mu1><material>Gazebo/Red</material></gazebo>
<gazebo reference="head"><mu1>0.2</mu1><material>Gazebo/Green</material></gazebo>
<gazebo reference="base_two"><mu1>0.3</mu1><material>Gazebo/Blue</material></gazebo></robot>"""


def test_names_decide_which_surface_and_material_a_shape_has_as_in_sdformat():
    """What `gz sdf -p` of Gazebo 11.1 makes of it; no surface there: none of the link's."""

    def shapes(*names):
        named = [f' name="{name}"' if name else "" for name in names]
        return "".join(
            f"<{tag}{name}><geometry><box size='1 1 1'/></geometry></{tag}>"
            for tag in ("visual", "collision")
            for name in named
        )

    own = ("c", "", "base_c"), ("h", "", "head", "head_collision", "head_visual"), ("",)
    model = parse_urdf(NAMED % tuple(shapes(*names) for names in own), str, "bot")
    assert model.warnings == []
    color = {0.1: "Red", 0.2: "Green", None: None}
    for link, collisions, visuals in (
        ("base", (None, 0.1, 0.1), (None, 0.1, 0.1)),
        ("head", (None, 0.2, 0.2, 0.2, None), (None, 0.2, 0.2, None, 0.2)),
        ("base_two", (0.1,), (0.1,)),
    ):
        found = model.links[link]
        surfaces = [shape.surface or found.surface for shape in found.collisions]
        assert tuple(surface.friction for surface in surfaces) == collisions
        for shape, number in zip(found.visuals, visuals):
            wanted = standard(color[number]).color if number else None
            assert shape.color == wanted, shape.name


URDF_LIMIT = (
    f"{LINKS}<link name='arm'/><joint name='hinge' type='continuous'><parent link='base'/>"
    "<child link='arm'/></joint><gazebo reference='hinge'>%s</gazebo>"
)
SDF_LIMIT = (
    "<link name='base'/><link name='arm'><velocity_decay><linear>0.3</linear><angular>0.4"
    "</angular></velocity_decay></link><joint name='hinge' type='revolute'><parent>base</parent>"
    "<child>arm</child><axis><xyz>0 0 1</xyz><dynamics>%s</dynamics></axis>"
    "<physics><ode>%s</ode></physics></joint>"
)


@pytest.mark.parametrize(
    "urdf, in_sdf, dynamics, found",
    [
        ("", "", "", (0.2, 0.0, 1.0, 0.0, 0.0)),
        ("<stopErp>0.1</stopErp>", "<limit><erp>0.1</erp></limit>", "", (0.1, 0.0, 1.0, 0.0, 0.0)),
        (
            "<stopCfm>0.2</stopCfm><fudgeFactor>0.3</fudgeFactor>",
            "<limit><cfm>0.2</cfm></limit><fudge_factor>0.3</fudge_factor>",
            "",
            (0.2, 0.2, 0.3, 0.0, 0.0),
        ),
        (
            "<springStiffness>40</springStiffness><springReference>0.5</springReference>",
            "",
            "<spring_stiffness>40</spring_stiffness><spring_reference>0.5</spring_reference>",
            (0.2, 0.0, 1.0, 40.0, 0.5),
        ),
    ],
)
def test_how_limits_and_springs_hold(urdf, in_sdf, dynamics, found):
    described = parse_urdf(f'<robot name="r">{URDF_LIMIT % urdf}</robot>', str, "bot")
    other, _ = parse_model(
        f'<sdf version="1.6"><model name="m">{SDF_LIMIT % (dynamics, in_sdf)}</model></sdf>', str
    )
    assert described.warnings == other.warnings == [] and other.links["arm"].decay == (0.3, 0.4)
    for model in (described, other):
        joint = model.joints["hinge"]
        limit = joint.stop_erp, joint.stop_cfm, joint.stop_push
        assert (*limit, joint.stiffness, joint.rest) == found


@pytest.mark.parametrize("tag", ["implicitSpringDamper", "cfmDamping"])
def test_cfm_damping_is_an_old_name_of_implicit_spring_damper(tag):
    for text, on in (("true", True), ("0", False)):
        urdf = f'<robot name="r">{URDF_LIMIT % f"<{tag}>{text}</{tag}>"}</robot>'
        model = parse_urdf(urdf, str, "bot")
        assert model.joints["hinge"].implicit_damping == on and model.warnings == []


@pytest.mark.parametrize(
    "tags, friction",
    [
        ("<mu1>0.4</mu1><mu2>0.4</mu2>", 0.4),
        ("<mu1>0.7</mu1>", 0.7),
        ("<mu1>-1</mu1><mu2>-1</mu2>", 1e6),
        ('<mu1 value="0.4"/><mu2 value="0.4"/>', 0.4),
        ('<mu1 value="0.4">0.5</mu1><mu2 value="0.4"/>', 0.4),
        (
            "<collision><surface><friction><ode><mu>0.2</mu><mu2>0.2</mu2></ode></friction></surface>"
            "</collision>",
            0.2,
        ),
    ],
)
def test_friction(tags, friction):
    model = read(f'<gazebo reference="base">{tags}</gazebo>')
    assert model.links["base"].surface.friction == friction and model.warnings == []


def test_a_surface_replaces_what_earlier_elements_say_as_in_sdformat():
    tags = (
        "<mu1>0.5</mu1><mu2>0.4</mu2><kp>2000</kp><fdir1>1 0 0</fdir1>",
        "<collision><surface><contact><collide_bitmask>0x01</collide_bitmask></contact></surface>"
        "</collision>",
        "<mu2>0.3</mu2>",
    )
    first, mask, last = (f'<gazebo reference="base">{each}</gazebo>' for each in tags)
    model = read(first + mask + last)
    surface = model.links["base"].surface
    assert (surface.friction, surface.friction2, surface.kp) == (None, 0.3, None)
    assert (surface.direction, surface.stiffness, surface.bitmask) == (None, None, 1)
    assert len(model.warnings) == 1 and "'base'" in model.warnings[0]
    for one in (mask + first, f'<gazebo reference="base">{tags[0]}{tags[1]}</gazebo>'):
        model = read(one)
        surface = model.links["base"].surface
        assert (surface.friction, surface.friction2, surface.bitmask) == (0.5, 0.4, 1)
        assert model.warnings == []


def test_tags_that_gazebo_has_no_use_for_are_told():
    """`gz sdf -p` of Gazebo 11.1 copies both to where nobody reads them."""
    model = read('<gazebo reference="base"><mu>0.3</mu><gravity>0</gravity></gazebo>')
    link = model.links["base"]
    assert link.surface.friction is None and link.gravity
    of_gravity, of_mu = model.warnings
    assert "turnGravityOff" in of_gravity and "<mu>" in of_mu
    assert read('<gazebo reference="base"><gravity>true</gravity></gazebo>').warnings == []


def test_soft_contact():
    surface = (
        read('<gazebo reference="base"><kp>2000</kp><kd>30</kd></gazebo>').links["base"].surface
    )
    assert (surface.stiffness, surface.damping) == (2000, 30)


def test_flags_and_colours():
    model = read(
        '<gazebo><static>true</static></gazebo><gazebo reference="base"><selfCollide>1'
        "</selfCollide><material>Gazebo/Blue</material></gazebo>"
    )
    link = model.links["base"]
    assert model.static and link.self_collide and model.links["head"].self_collide  # one link
    blue = standard("Gazebo/Blue")
    assert (link.visuals[0].color, link.visuals[0].finish) == (blue.color, blue.finish)
    values = read(
        '<gazebo reference="base"><selfCollide value="true"/><turnGravityOff value="1"/></gazebo>'
    )
    assert values.links["base"].self_collide and not values.links["base"].gravity
    own = read(
        '<gazebo reference="base"><visual><material><ambient>1 0 0 1</ambient><diffuse>'
        "0 1 0</diffuse></material></visual></gazebo>"
    )
    (shape,) = own.links["base"].visuals
    assert shape.color == (0, 1, 0, 1) and shape.finish.ambient == (1, 0, 0)


def test_a_material_of_a_script_that_gazebo_finds_by_itself(tmp_path):
    """As where a launch file names its package in GAZEBO_RESOURCE_PATH."""
    script = "material Mine/Plaid\n{\ntechnique\n{\npass\n{\ndiffuse 0 1 0 1\n}\n}\n}\n"
    (tmp_path / "mine.material").write_text(script)

    def resolve(uri):
        if uri != "file://media/materials/scripts":
            raise ValueError("nowhere")
        return str(tmp_path)

    named = '<gazebo reference="base"><material>Mine/Plaid</material></gazebo>'
    model = parse_urdf(f'<robot name="r">{LINKS}{named}</robot>', resolve, "car")
    assert model.links["base"].visuals[0].color == (0, 1, 0, 1) and model.warnings == []


@pytest.mark.parametrize(
    "name",
    [
        "Gazebo/Grey",
        "Gazebo/White",
        "Orange",
        "Gazebo/RedBright",
        "Gazebo/BlueTransparent",
        "Gazebo/GreenGlow",
    ],
)
def test_standard_colours(name):
    color = standard(name).color
    assert len(color) == 4 and all(0 <= value <= 1 for value in color)
    assert (color[3] < 1) == ("Transparent" in name)
    assert standard("Gazebo/NoSuchThing") is None
