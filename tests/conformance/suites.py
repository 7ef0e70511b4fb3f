"""The suites that run.py knows, and what of them cannot apply here."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Suite:
    """Tests of one package.

    Attributes:
        repository: name of the clone's folder.
        package: folder of the package in it.
        rostests: patterns of launch files with <test>, in the package's folder.
        modules: patterns of Python files with test functions or cases, run by pytest.
        nodes: replaced nodes: (package, type) -> launch file of this folder that takes its place,
            and its arguments.
        service: of those nodes; the tests start when it is there, as a simulator starts slower.
        edits: (text, its replacement) in scripts, for Python libraries newer than the tests.
        plugin: module of this folder that pytest loads first.
        folders: of the package that are copied.
        in_place: tests look for files of the package that they belong to.
        own_name: the copy has the package's own name, because tests look for themselves in it.
        simulator: name of the node that the launch files start as Gazebo, whose pace can be lower.
        not_applicable: test, or name of its file -> why it cannot apply here.
    """

    repository: str
    package: str = "."
    rostests: tuple[str, ...] = ()
    modules: tuple[str, ...] = ()
    nodes: dict[tuple[str, str], str] = field(default_factory=dict)
    service: str = ""
    edits: tuple[tuple[str, str], ...] = ()
    plugin: str = ""
    folders: tuple[str, ...] = ("test",)
    in_place: bool = False
    own_name: bool = False
    simulator: str = ""
    not_applicable: dict[str, str] = field(default_factory=dict)


MANAGER = "/controller_manager/list_controllers"
KINEMATIC = "kinematic_robot/robot.launch"
LIBRARY = "C++ against the classes of the package, which is no node"


def controller(
    package: str, robots: dict[str, str], *rostests: str, **not_applicable: str
) -> Suite:
    """A Suite of a package of ros_controllers.

    Args:
        robots: its robots in C++ -> arguments of KINEMATIC.
        not_applicable: file without suffix -> why.
    """
    return Suite(
        "ros_controllers",
        package,
        rostests=rostests,
        nodes={(package, name): f"{KINEMATIC} {args}".strip() for name, args in robots.items()},
        service=MANAGER,
        not_applicable={f"{name}.test": why for name, why in not_applicable.items()},
    )


BOTH = "interfaces:='velocity position'"
SUITES = {
    "diff_drive_controller": controller(
        "diff_drive_controller", {"diffbot": "", "skidsteerbot": ""}, "test/*.test"
    ),
    "ackermann_steering_controller": controller(
        "ackermann_steering_controller",
        {"ackermann_steering_controller_ackermann_steering_bot": BOTH},
        "test/*/*.test",
    ),
    "four_wheel_steering_controller": controller(
        "four_wheel_steering_controller", {"four_wheel_steering": BOTH}, "test/*.test"
    ),
    "joint_trajectory_controller": controller(
        "joint_trajectory_controller",
        {
            "rrbot": BOTH,
            "rrbot_wrapping": "interfaces:=velocity wrap:=true start:='3.04159 -3.04159'",
        },
        "test/*.test",
        tolerances=LIBRARY,
        joint_partial_trajectory_controller="not built by the package's own CMakeLists.txt",
    ),
    "effort_controllers": controller(
        "effort_controllers", {"simple_bot_hw": "interfaces:=effort"}, "test/*.test"
    ),
    "gazebo_plugins": Suite(
        "gazebo_ros_pkgs",
        "gazebo_plugins",
        rostests=("test/camera/*.test", "test/range/*.test", "test/*test/*.test", "test/*.test"),
        folders=("test", "scripts"),
        in_place=True,
        simulator="gazebo",
    ),
    "gazebo_ros": Suite(
        "gazebo_ros_pkgs",
        "gazebo_ros",
        rostests=("test/ros_network/*.test",),
        edits=(("yaml.load(open(f))", "yaml.safe_load(open(f))"),),
    ),
    "controller_manager_tests": Suite(
        "ros_control",
        "controller_manager_tests",
        rostests=("test/*.test",),
        modules=("test/cm_msgs_utils_test.py",),
        nodes={("controller_manager_tests", "dummy_app"): "dummy_robot/dummy.launch"},
        service=MANAGER,
    ),
    "combined_robot_hw_tests": Suite(
        "ros_control",
        "combined_robot_hw_tests",
        rostests=("test/*.test",),
        nodes={
            ("combined_robot_hw_tests", "combined_robot_hw_dummy_app"): (
                "dummy_robot/dummy.launch combined:=true"
            )
        },
        service=MANAGER,
        not_applicable={"combined_robot_hw_test.test": LIBRARY},
    ),
    "xacro": Suite("xacro", modules=("test/test_xacro.py",), plugin="xacro_here", own_name=True),
}
# Packages whose tests are not run here, and why.
WITHOUT = {
    "joint_state_controller": LIBRARY,
    "controller_manager: hwi_switch_test, hwi_update_test": LIBRARY,
    "controller_interface, hardware_interface, joint_limits_interface": LIBRARY,
    "transmission_interface": LIBRARY,
    "joint_trajectory_controller: tests of splines, segments and builders": LIBRARY,
    "position_controllers, velocity_controllers, forward_command_controller": "have no tests",
    "gripper_action_controller": "has no tests",
    "imu_sensor_controller, force_torque_sensor_controller": "have no tests",
}
