"""The suites that run.py knows, and what of them cannot apply here."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Suite:
    """Tests of one package.

    Attributes:
        repository: name of the clone's folder.
        package: folder of the package in it.
        rostests: patterns of launch files with <test>, in the package's folder.
        modules: patterns of Python files with test functions or cases, run by pytest.
        nodes: replaced nodes: (package, type) -> launch file of this folder that takes its place.
        service: of those nodes; the tests start when it is there, as a simulator starts slower.
        edits: (text, its replacement) in scripts, for Python libraries newer than the tests.
        plugin: module of this folder that pytest loads first.
        not_applicable: test -> why it cannot apply here.
    """

    repository: str
    package: str = "."
    rostests: tuple[str, ...] = ()
    modules: tuple[str, ...] = ()
    nodes: dict[tuple[str, str], str] = field(default_factory=dict)
    service: str = ""
    edits: tuple[tuple[str, str], ...] = ()
    plugin: str = ""
    not_applicable: dict[str, str] = field(default_factory=dict)


SUITES = {
    "teleop_twist_joy": Suite("teleop_twist_joy", rostests=("test/*.test",)),
    "twist_mux": Suite("twist_mux", rostests=("test/*.test",)),
    "gazebo_ros": Suite(
        "gazebo_ros_pkgs",
        "gazebo_ros",
        rostests=("test/ros_network/*.test",),
        edits=(("yaml.load(open(f))", "yaml.safe_load(open(f))"),),
    ),
    "controller_manager_tests": Suite(
        "ros_control",
        "controller_manager_tests",
        rostests=(
            "test/cm_msgs_utils_rostest.test",
            "test/controller_manager_interface_test.test",
            "test/controller_manager_scripts.test",
        ),
        modules=("test/cm_msgs_utils_test.py",),
        nodes={("controller_manager_tests", "dummy_app"): "dummy_robot/dummy.launch"},
        service="/controller_manager/list_controllers",
        not_applicable={
            "cm_test": "C++ against the class controller_manager::ControllerManager",
            "hwi_switch_test, hwi_update_test": "C++ against hardware_interface's classes",
        },
    ),
    "xacro": Suite("xacro", modules=("test/test_xacro.py",), plugin="xacro_here"),
}
