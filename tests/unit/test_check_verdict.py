"""./run check: what is said of what came up, and of what roslaunch wrote."""

import copy
import math
import os
from xml.etree import ElementTree

import pytest
from bullet_sim.description.warnings import is_loss
from bullet_sim.formats.urdf import parse_urdf
from run_rig import Like, make_package
from urdf_texts import joint, link, robot

from commands import (
    check_observer,
    check_remedies,
    check_roslaunch,
    check_sources,
    check_verdict,
)
from commands.bootstrap.left_out import GAZEBO as BRINGS_GAZEBO
from commands.bootstrap.left_out import OWN
from commands.check_remedies import GENERIC
from commands.errors import CommandError
from commands.parsing import parser_of
from commands.subcommands import check

STATE = {"position": (1.0, 2.0, 0.05), "orientation": (0.0, 0.0, 0.0, 1.0), "speed": 0.0}
GROUND = {"name": "ground_plane", "static": True, "sensors": [], "warnings": [], "lost": [],
          "control_namespace": None}  # fmt: skip
CAR = {
    "name": "car",
    "static": False,
    "control_namespace": "/car",
    "controllers": [["wheels", "velocity_controllers/JointVelocityController", "running"]],
    "sensors": [{"topic": "/scan", "type": "sensor_msgs/LaserScan", "rate": 10.0, "count": 80,
                 "measured": 9.9, "link": "laser"}],
    "warnings": ["a", "a", "b"],
    "lost": [],
    "before": STATE,
    "after": STATE,
}  # fmt: skip
GOOD = {
    "simulator": True,
    "world": "default",
    "real_time_factor": 1.0,
    "simulated": 8.0,
    "refused": None,
    "cannot": [],
    "died": [],
    "warnings": ["w"],
    "lost": [],
    "models": [GROUND, CAR],
}


def changed(**values):
    """GOOD with other values; those of the car are named car_NAME."""
    found = copy.deepcopy(GOOD)
    for name, value in values.items():
        if name.startswith("car_"):
            found["models"][1][name[4:]] = value
        else:
            found[name] = value
    return found


def dead(name, program, code=1, **values):
    """A node that has ended with an error, as check_log.read() tells it."""
    return {"name": name, "program": program, "code": code, "times": 1, "why": "", "screen": False,
            **values}  # fmt: skip


def state(x=0.0, y=0.0, z=0.0, about_x=0.0):
    """STATE after a way [m] and a turn [rad]."""
    position = tuple(start + way for start, way in zip(STATE["position"], (x, y, z)))
    turned = (math.sin(about_x / 2.0), 0.0, 0.0, math.cos(about_x / 2.0))
    return {**STATE, "position": position, "orientation": turned}


def topic(rate, count, measured=None, **values):
    """The car's only sensor, which has sent some messages."""
    kind = {"type": "sensor_msgs/Image", "link": "eye", **values}
    return [{"topic": "/t", "rate": rate, "count": count, "measured": measured, **kind}]


def massless(base_has_mass):
    """What the reader says of a robot whose arm has no mass."""
    base = link("base") if base_has_mass else '<link name="base"/>'
    joints = (joint(to, "continuous", of, to) for of, to in (("base", "arm"), ("arm", "hand")))
    text = robot(base, '<link name="arm"/>', link("hand"), *joints)
    (warning,) = parse_urdf(text, str, "car").warnings
    assert is_loss(warning)
    return str(warning)


FAILS = "does not work because "
MOVED, MOVES = state(y=0.4), "robot car moves by itself: 0.40 m while it was watched"
ARM, WHEELS = ["arm", "x", "stopped"], ["wheels", "y", "running"]
MUX = dead("mux", "mux.py")
UNKNOWN = "plugin '{}' is not known here and is ignored"
MEANT = UNKNOWN + "; did you mean 'libgazebo_ros_control.so'?"
OTHERS, NEARLY = MEANT.format("libgazebo_ros_control2.so"), MEANT.format("libgazebo_ros_contol.so")
BARELY = MEANT.format("gazebo_ros_contol")
KOBUKI = UNKNOWN.format("libgazebo_ros_kobuki.so")
BASE = ["base", "diff_drive_controller/DiffDriveController", "running"]
NO_JOINT = (
    "plugin 'libgazebo_ros_diff_drive.so' names joints left, which do not exist or do not move; "
    "movable joints are port"
)
NO_LINK = "plugin 'libhector_gazebo_ros_imu.so' has bodyName 'imu', which is no link; it is out"
NO_PARAMETERS = "controller 'base' has no parameters: /base is not there"
NO_WORLD = "world file 'a.world' is in none of /b; the empty world takes its place"
NO_GDAL = "elevation data, which GDAL reads (apt-get install python3-gdal)"  # of formats/shapes.py
NO_PATH = "[FATAL] [1.5]: Package[arm_description] does not have a path"
NOT_FOUND = "Resource not found: amcl"
LONG_NOT_FOUND = (
    "Resource not found: The following package was not found in "
    '<arg name="a: b" value="$(find ferry)/x: y"/>: amcl\n'
)
THERE = "/home/ada/ws/src/car/a.launch"
MODELS = {"included models cannot be used": ["'model://cafe_table'", "'model://bookshelf'"]}
OWN_MODEL = {"included models cannot be used": ["'model://shed_of_mine'"]}
MESHES = {"meshes are missing and left out": ["package://a/b.stl", "package://a/c.stl"]}
DATABASE_MESH = {"meshes are missing and left out": ["model://cafe_table/meshes/cafe_table.dae"]}
HILL = {"heightmaps cannot be used and are left out": ["/w/hill.asc"]}
NO_GROUND = {f"heightmaps are {NO_GDAL}, and left out": ["/w/hill.asc"]}
NO_MODELS = (
    "2 models of Gazebo's database are missing: bookshelf, cafe_table; "
    "./run add models bookshelf cafe_table"
)
CANNOT = {"cannot": [["tools", "merge"], ["gone", "node"]],
          "builders": {"merge": ["laser_tools", True], "node": ["gone", False]}}  # fmt: skip
NOT_INSTALLED = "node gone/node cannot start: package gone is not installed; " + GENERIC
NOT_BUILT = "node tools/merge cannot start: it is C++ of laser_tools, which is not built; ...make"
WAITS = {"companions": {name: [("car", f"{name}.launch")]
                        for name in ("world", "robot", "controllers")}}  # fmt: skip
MANY = {"companions": {"robot": [("car", "robot.launch")] * 5}}
BRINGS = "; if another launch file brings it, add it to the command: + car {}.launch"
LOOSE = {**CAR, "furniture": True, "sensors": [], "controllers": [], "after": MOVED}
CRATE = {**LOOSE, "name": "crate", "furniture": False, "control_namespace": None,
         "extensions": [], "before": state(about_x=math.pi / 2.0),
         "after": state(about_x=math.pi / 2.0)}  # fmt: skip
ADD = [f"{name} is missing; ./run add {name}" for name in ("a", "models b c")]

# What was found, problems, the verdict (None: nothing works, for the first problem), notes.
SAID = [
    ({}, [], "works"),
    # roslaunch
    ({"refused": "no such file"}, ["roslaunch refuses...: no such file"], None),
    ({"refused": f"there is no file {THERE}", "moved": {THERE: "$(find car)/a.launch"}},
     ["...there is no file...a.launch; here it is $(find car)/a.launch"], None),
    ({"refused": NOT_FOUND, "simulator": False, "models": [], "remedies": {"amcl": "look"}},
     [f"...: {NOT_FOUND}; amcl: look"], None),
    ({"simulator": False}, ["no simulator came up: does...empty_world.launch?"], None),
    ({"simulator": False, "models": [], **WAITS},
     ["no simulator came up" + BRINGS.format("world")], None),
    ({"interpreters": [("/a/old.py", "/usr/bin/python")]},
     ["script /a/old.py begins with #!/usr/bin/python,...python-is-python3..."], None),
    ({"interpreters": [("/a/old.py", "/no/python")]},
     ["...#!/no/python...: install it, or change the script's first line"], None),
    # nodes that do not start
    ({"cannot": [["tools", "merge"]]}, ["node tools/merge...has no such node;..."],
     "works without node tools/merge"),
    (CANNOT, [NOT_INSTALLED, NOT_BUILT], "works without node gone/node, node tools/merge"),
    ({"cannot": [["move_base", "move_base"], ["base", "hw"]],
      "builders": {"move_base": ["move_base", False, ""], "hw": ["base", True, "X's headers"]},
      "remedies": {"move_base": "look there"}},
     ["...move_base is not installed; look there", "...asks for X's headers,...Python..."],
     "works without node move_base/move_base, node base/hw"),
    ({"cannot": [["rqt_robot_steering", "rqt_robot_steering"]]}, [], "works",
     "node rqt_robot_steering/rqt_robot_steering, a window, is not installed"),
    ({"unable": ["joystick"]}, ["node joystick has a program that cannot be run"],
     "works without node joystick"),
    # nodes that die
    ({"died": [MUX]}, ["node mux (mux.py) died with exit code 1"], "works without node mux"),
    ({"died": [dead("car", "drive.py", why="cv2.error: x", drives=True, times=8)]},
     ["node car (drive.py) died with exit code 1, 8 times: cv2.error: x"],
     "does not drive because node car..."),
    ({"died": [dead("view", "rviz", -6, screen=True), dead("keys", "keys.py", screen=True)]}, [],
     "works", "node view (rviz) wants a screen...", "node keys (keys.py) wants a screen..."),
    # the robot
    ({"models": [GROUND]}, ["no robot was spawned"], None),
    ({"models": [GROUND], **WAITS}, ["no robot was spawned" + BRINGS.format("robot")], None),
    ({"models": [GROUND], **MANY},
     ["...: + car robot.launch, + car robot.launch, + car robot.launch and 2 more"], None),
    ({"models": [GROUND], **WAITS, "died": [dead("put", "spawn_model", why="two root links")]},
     ["no robot was spawned: two root links"], None),
    ({"models": [GROUND], **WAITS, "died": [dead("put", "spawn_model")]},
     ["no robot was spawned" + BRINGS.format("robot"), "node put (spawn_model) died..."], None),
    ({"models": [GROUND], "errors": [NO_PATH, NO_PATH], "remedies": {"arm_description": "look"}},
     ["package arm_description is not there...; look", "no robot was spawned"], None),
    ({"models": [LOOSE]}, ["no robot was spawned"], None, "loose things...: car"),
    ({"models": [GROUND, CAR, *({**LOOSE, "name": f"b{n}"} for n in range(5))]}, [], "works",
     "loose things move, fall or lie: b0, b1, b2 and 2 more"),
    ({"models": [GROUND, CAR, CRATE]}, [], "works", "loose things move, fall or lie: crate"),
    ({"models": [{**CRATE, "joints": 0}]}, [], "works"),  # a camera that hangs so
    ({"models": [{**CRATE, "joints": 0, "commands": ["/cmd_vel"]}]},
     ["robot crate is tilted by 90 degrees"], None),
    ({"models": [CRATE]}, ["robot crate is tilted by 90 degrees"], None),
    ({"car_after": None}, ["robot car cannot be asked where it is"], None),
    ({"car_after": MOVED}, [MOVES], None),
    ({"car_after": MOVED, "car_driven_by": ["/driver"]}, [], "works"),
    ({"car_after": state(y=math.nan)}, ["robot car is nowhere: its...not finite"], None),
    ({"car_before": state(z=-5.05), "car_after": state(z=-5.05)},
     ["robot car has fallen to z = -5.0 m"], None),
    ({"car_after": state(about_x=1.0)}, ["robot car is tilted by 57 degrees"], None),
    ({**CANNOT, "car_after": MOVED}, [NOT_INSTALLED, NOT_BUILT, MOVES], FAILS + NOT_INSTALLED),
    ({"car_after": MOVED, "car_sensors": topic(30.0, 0)}, ["...sends nothing", MOVES],
     FAILS + MOVES),
    # controllers
    ({"car_controllers": None}, ["the controller_manager of car in /car does not answer"], None),
    ({"car_controllers": []}, ["no controller is loaded in /car: is there a spawner,..."], None),
    ({"car_controllers": [], **WAITS},
     ["no controller is loaded in /car" + BRINGS.format("controllers")], None),
    ({"car_controllers": [], "car_commands": ["/cmd_vel"]},
     ["no controller is loaded in /car: is there a spawner,..."],
     "works without controllers in /car"),
    ({"car_controllers": [ARM]}, ["controller arm in /car is stopped"], None),
    ({"car_controllers": [ARM, WHEELS]}, ["controller arm in /car is stopped"],
     "works without controller arm in /car"),
    ({"car_lost": [NO_PARAMETERS]}, [NO_PARAMETERS], "works without controller base"),
    # sensors
    ({"car_sensors": topic(30.0, 0)}, ["sensor on /t of car sends nothing"],
     "works without sensor /t"),
    ({"car_sensors": topic(30.0, 9, 12.0)}, ["sensor on /t sends 12.0 of 30 Hz"],
     "works without sensor /t"),
    ({"car_sensors": topic(30.0, 80, 10.0, is_camera=True), "was_paused": True}, [], "works",
     "the file starts the world paused;...", "...draws /t 10.0 times..., 30 are wanted"),
    ({"car_sensors": topic(2.0, 0), "real_time_factor": 0.1, "simulated": 0.8}, [], "works",
     "this machine simulates 0.10 s in a second", "...too slow for a first message on /t"),
    ({"car_sensors": topic(2.0, 0), "real_time_factor": 0.1}, ["...sends nothing"],
     "works without sensor /t", "...simulates 0.10 s..."),
    ({"car_sensors": topic(2.0, 0, is_camera=True), "real_time_factor": 0.1}, [], "works",
     "...simulates...", "...too slow..."),
    # plugins
    ({"lost": [UNKNOWN.format("x")]}, [UNKNOWN.format("x")], "works without plugin x"),
    ({"car_lost": [UNKNOWN.format("libhover.so")], "builders": {"hover": ["h_g", True]}},
     [UNKNOWN.format("libhover.so") + f": it is C++ of package h_g; {BRINGS_GAZEBO}"],
     "works without plugin libhover.so"),
    ({"car_lost": [OTHERS], "builders": {"gazebo_ros_control2": ["x_control", True]}},
     [f"{OTHERS}: it is C++ of package x_control; {BRINGS_GAZEBO}"],
     "works without plugin libgazebo_ros_control2.so"),
    ({"car_lost": [NEARLY], "builders": {"gazebo_ros_control": ["x_control", True]}}, [NEARLY],
     "works without plugin libgazebo_ros_contol.so"),
    ({"lost": ["/w/a.world has no <world>; the empty world takes its place"]}, ["..."],
     "works without file /w/a.world"),
    ({"car_lost": [BARELY]}, [BARELY], "works without plugin gazebo_ros_contol"),
    ({"car_lost": ["plugin 'x' of sensor 'eye' is ignored; take libgazebo_ros_y.so"]}, ["..."],
     "works without plugin x"),
    ({"car_lost": [KOBUKI]}, [f"{KOBUKI}; {OWN}"], f"does not drive because {KOBUKI}; {OWN}"),
    ({"car_lost": [NO_JOINT]}, [NO_JOINT], f"does not drive because {NO_JOINT}"),
    ({"car_lost": [NO_JOINT], "car_controllers": [BASE]}, [NO_JOINT],
     "works without plugin libgazebo_ros_diff_drive.so"),
    ({"car_lost": [NO_LINK]}, [NO_LINK], "works without plugin libhector_gazebo_ros_imu.so"),
    ({"car_lost": [massless(True)]}, [massless(True)],
     "works without links without mass: arm, hand"),
    ({"car_lost": [massless(False)]}, [massless(False)], None),
    # files
    ({"lost": [NO_WORLD]}, [NO_WORLD], "works without world file a.world"),
    ({"missing": MODELS, "car_missing": MESHES},
     [NO_MODELS, "2 meshes are missing and left out: package://a/b.stl, package://a/c.stl"],
     "works without 2 models, 2 meshes"),
    ({"missing": OWN_MODEL}, ["model model://shed_of_mine cannot be used"],
     "works without model shed_of_mine"),
    ({"missing": NO_GROUND}, [f"heightmap /w/hill.asc is {NO_GDAL}, and left out"],
     "works without heightmap hill.asc"),
    ({"missing": HILL, "car_after": MOVED}, ["heightmap /w/hill.asc cannot be used...", MOVES],
     FAILS + "heightmap /w/hill.asc cannot be used and is left out"),
    ({"missing": DATABASE_MESH, "car_after": MOVED}, ["1 model of Gazebo's database is...", MOVES],
     FAILS + MOVES),
    ({"missing": {cause: [uri.replace("//", "///") for uri in uris]
                  for cause, uris in DATABASE_MESH.items()}},
     ["1 model of Gazebo's database is...cafe_table"], "works without 1 model"),
    ({"problems": ADD, "checked": ["robot", "a.launch"]}, [], "works",
     "./run add --for robot a.launch brings all of these packages and models at once"),
    ({"problems": ADD[:1], "checked": ["robot", "a.launch"]}, [], "works"),
    # causes before what they cause
    ({**CANNOT, "died": [MUX], "car_lost": [UNKNOWN.format("libx.so")], "car_after": MOVED,
      "car_sensors": topic(30.0, 0)},
     [NOT_INSTALLED, NOT_BUILT, "...libx.so...Python class...", "node mux...",
      "...on /t...", MOVES], FAILS + NOT_INSTALLED),
]  # fmt: skip


@pytest.mark.parametrize("row", SAID)
def test_what_is_said(row, monkeypatch):
    monkeypatch.setattr(check_remedies, "GAZEBO", "/no/gazebo")
    values, problems, verdict, *notes = row
    found = changed(**values)
    assert check_verdict.problems(found) == list(map(Like, problems))
    assert check_verdict.verdict(found) == Like(FAILS + problems[0] if verdict is None else verdict)
    assert check_verdict.notes(found) == list(map(Like, notes))


def test_the_page_of_what_works():
    lines = check.page(GOOD, 8.0)
    assert lines[0] == "works" and lines[2].endswith("watched for 8 s, real-time factor 1.00")
    for line in ("robot car at (1.00, 2.00, 0.05)", "  /scan ...10 Hz ...9.9 Hz", "  2 x a", "  b",
                 "  running     wheels..."):  # fmt: skip
        assert Like(line) in lines
    assert "worth knowing:" not in lines and "  of car:" not in lines
    assert "worth knowing:" in check.page(changed(was_paused=True), 8.0)


def test_topics_of_two_robots_say_whose_they_are():
    other = {**CAR, "name": "cart", "driven_by": ["/driver"]}
    lines = check.page(changed(models=[*GOOD["models"], other]), 8.0)
    assert lines.index("  of cart:") > lines.index("  of car:")
    assert Like("robot cart at...driven by /driver...") in lines


def test_the_first_line_is_the_verdict_and_its_cause_is_told_once():
    lines = check.page(changed(died=[MUX], car_sensors=[], models=[GROUND]), 8.0)
    assert lines[0] == "does not work because no robot was spawned"
    assert "1 more problem:" in lines and not any("no robot" in line for line in lines[1:])


def test_without_a_simulator():
    (line,) = check.page({"simulator": False, "refused": None, "cannot": [], "died": []}, 8.0)
    assert line.startswith("does not work because no simulator came up: ")


def test_a_launch_that_ends_early_has_no_simulator(monkeypatch):
    class Gone:
        def getSystemState(self):
            raise ConnectionRefusedError

    monkeypatch.setattr(check_observer.rospy, "get_master", Gone)
    assert check_observer.find_simulator() is None


@pytest.mark.parametrize("program, prefix, is_window, left", [
    ("drive.py", "xterm -e", False, None),
    ("drive.py", "xterm -hold -e", False, None),
    ("drive.py", "gnome-terminal --", False, None),
    ("drive.py", "/usr/bin/konsole -e gdb --args", False, "gdb --args"),
    ("drive.py", "gnome-terminal --command", False, None),
    ("drive.py", "bash -c 'sleep 5; $0 $@'", False, "bash -c 'sleep 5; $0 $@'"),
    ("drive.py", "nice -n 10", False, "nice -n 10"),
    ("rviz", None, True, None),
])  # fmt: skip
def test_no_window_is_required_and_none_is_opened(program, prefix, is_window, left):
    class Node:
        def __init__(self, package, node_type, name=None, required=False, respawn=False):
            self.type, self.required, self.respawn = node_type, required, respawn
            self.launch_prefix = prefix

    check_roslaunch.without_required_windows(Node)
    node = Node("base", program, "base", required=True, respawn=True)
    assert (node.required, node.respawn, node.launch_prefix) == (not is_window, not is_window, left)


@pytest.mark.parametrize("values, names", [
    ({"refused": f"{NOT_FOUND}\nROS path [0]=/a"}, ["amcl"]),
    ({"refused": LONG_NOT_FOUND}, ["amcl"]),
    ({"refused": "package 'ferry' not found"}, ["ferry"]),
    ({"errors": [NO_PATH, NO_PATH]}, ["arm_description"]),
    ({"builders": {"merge": ["laser_tools", True], "node": ["gone", False]}}, ["gone"]),
    ({}, []),
])  # fmt: skip
def test_packages_that_are_missing(values, names):
    assert check_remedies.missing_packages(changed(**values)) == names


def test_sources_of_what_is_missing(tmp_path, monkeypatch):
    for name in ("base", "hover"):
        make_package(tmp_path / name, name)
    for name, text in {
        "CMakeLists.txt":
            "project(hover)\nadd_library(${PROJECT_NAME}_plugin SHARED a.cpp)\n"
            "add_library(gazebo_ros_control a.cpp)\n"
            "add_executable(drive b.cpp)\nadd_subdirectory(src/pad)\nadd_subdirectory(gone)\n",
        "src/pad/CMakeLists.txt": "add_executable(pad pad.cpp)\n",
        "src/pad/pad.cpp": "#include <gazebo/g.hh>\n",
        "a.cpp": "#include <ros/ros.h>\n# include <gazebo/g.hh>\n",
        "b.cpp": "#include <ros/ros.h>\n",
    }.items():  # fmt: skip
        (tmp_path / "hover" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "hover" / name).write_text(text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    lost = [UNKNOWN.format("libhover_plugin.so"), NEARLY]  # which is misspelled, and no one's own
    found = {"cannot": [["hover", "drive"], ["hover", "pad"], ["gone", "node"]], "lost": [],
             "models": [{"lost": lost}]}  # fmt: skip
    assert check_sources.builders(found) == {
        "drive": ("hover", True, ""),
        "pad": ("hover", True, "Gazebo's headers"),
        "node": ("gone", False, ""),
        "hover_plugin": ("hover", True, "Gazebo's headers"),
    }


@pytest.mark.parametrize("name, remedy", [
    ("laser_filters", "apt-get install laser-filters"),
    ("move_base", "./run add move_base"),
    ("slam_toolbox", "./run add slam_toolbox"),
    ("robot_localization", "./run add robot_localization"),
    ("robot_pose_ekf", "./run add robot_pose_ekf"),
    ("cmd_vel_mux", "twist_mux does the same, it comes by ./run add"),
    ("my_own", "./run deps..."),
    ("libhover.so", "...Python class..."),
    ("libhector_gazebo_thermal_camera.so", "libgazebo_ros_camera..."),
])  # fmt: skip
def test_what_would_replace_it(name, remedy):
    def resolve(names):
        return {name: ["laser-filters"] if name == "laser_filters" else [] for name in names}

    if name.endswith(".so"):
        assert check_remedies.for_plugin(name) == Like(remedy)
    else:
        assert check_remedies.for_package(name, set, resolve) == Like(remedy)


def test_a_plugin_with_sources_that_gazebos_libraries_did_not_build(tmp_path, monkeypatch):
    monkeypatch.setattr(check_remedies, "GAZEBO", str(tmp_path))
    assert check_remedies.for_plugin("libhover.so", has_sources=True) == OWN


def test_what_there_is_has_no_remedy():
    from bullet_sim.plugins import rules

    assert not set(check_remedies.PLUGINS) & set(rules.RULES)


def test_the_replay_of_the_last_check_of_a_file_is_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(check, "OUT", str(tmp_path / "out"))
    folder = tmp_path / "check-1"
    folder.mkdir()
    (folder / "replay.html").write_text("first")
    kept = tmp_path / "out" / "check" / "my_car" / "drive.html"
    words = str(folder), "my_car", "/my/launch/drive.launch"
    assert check.kept_replay(*words) == str(kept)
    assert kept.read_text() == "first" and list(folder.iterdir()) == []
    assert check.kept_replay(str(folder), "my_car", "park.launch") is None  # has left none
    assert kept.exists()
    assert check.kept_replay(*words) is None  # nor has this one, of the same file
    assert not kept.exists()


def test_several_launch_files():
    words = "gui:=false + car navigate.launch --seconds 3 map:=a:=b + car view.launch".split()
    options, rest = parser_of("check", check).parse_known_args(["car", "world.launch", *words])
    assert options.seconds == 3.0
    assert check.files_of(options.package, options.file, rest) == [
        ("car", "world.launch", ["gui:=false"]),
        ("car", "navigate.launch", ["map:=a:=b"]),
        ("car", "view.launch", []),
    ]


def test_several_launch_files_are_one(tmp_path):
    environ = {**os.environ, "ROS_PACKAGE_PATH": str(tmp_path / "src")}
    for name in ("world", "navigate"):
        folder = make_package(tmp_path / "src" / name, name) / "launch"
        folder.mkdir()
        (folder / f"{name}.launch").write_text("<launch/>")
    files = [("world", "world.launch", []), ("navigate", "navigate.launch", ['words:=<"a">'])]
    path = check.together(files, str(tmp_path / "both.launch"), environ)
    root = ElementTree.parse(path).getroot()
    assert [each.get("file") for each in root] == [
        str(tmp_path / "src" / name / "launch" / f"{name}.launch") for name in ("world", "navigate")
    ]
    (argument,) = root.iter("arg")
    assert (argument.get("name"), argument.get("value")) == ("words", '<"a">')
    with pytest.raises(CommandError, match="the package 'world' has no file 'other.launch'"):
        check.together([("world", "other.launch", [])], path, environ)


def test_a_node_that_two_files_start_is_that_of_the_last():
    """As on a master: who registers with a name ends the node that had it."""
    from roslaunch.config import ROSLaunchConfig
    from roslaunch.core import Node, RLException

    def nodes(config_class):
        config = config_class()
        for package, namespace in (("first", "/"), ("other", "/robot"), ("second", "/")):
            config.add_node(Node(package, "rviz", name="rviz", namespace=namespace))
        return [(node.package, node.namespace) for node in config.nodes]

    class Config(ROSLaunchConfig):
        pass

    with pytest.raises(RLException, match="multiple nodes named"):
        nodes(Config)
    check_roslaunch.keep_last_of_a_name(Config)
    assert nodes(Config) == [("other", "/robot/"), ("second", "/")]
