"""./run check: what is said of what came up, and of what roslaunch wrote."""

import copy
import math
import os
from xml.etree import ElementTree

import pytest
from bullet_sim.description.warnings import is_loss
from bullet_sim.formats.urdf import parse_urdf
from urdf_texts import joint, link, robot

from commands import (
    check_observer,
    check_remedies,
    check_roslaunch,
    check_sources,
    check_verdict,
    cli,
)
from commands.errors import CommandError, UsageError
from commands.subcommands import check

STATE = {"position": (1.0, 2.0, 0.05), "orientation": (0.0, 0.0, 0.0, 1.0), "speed": 0.0}
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
    "models": [
        {"name": "ground_plane", "static": True, "sensors": [], "warnings": [], "lost": [],
         "control_namespace": None},
        {
            "name": "car",
            "static": False,
            "control_namespace": "/car",
            "controllers": [["wheels", "velocity_controllers/JointVelocityController", "running"]],
            "sensors": [{"topic": "/scan", "type": "sensor_msgs/LaserScan", "rate": 10.0,
                         "count": 80, "measured": 9.9, "link": "laser"}],
            "warnings": ["a", "a", "b"],
            "lost": [],
            "before": STATE,
            "after": STATE,
        },
    ],
}  # fmt: skip


def dead(name, program, code=1, **values):
    """A node that has ended with an error, as check_log.read() tells it."""
    return {"name": name, "program": program, "code": code, "times": 1, "why": "", "screen": False,
            **values}  # fmt: skip


def changed(**values):
    """GOOD with other values; those of the car are named car_NAME."""
    found = copy.deepcopy(GOOD)
    for name, value in values.items():
        if name.startswith("car_"):
            found["models"][1][name[4:]] = value
        else:
            found[name] = value
    return found


def state(**values):
    return {**STATE, **values}


def test_nothing_is_wrong():
    assert check_verdict.problems(GOOD) == [] and check_verdict.verdict(GOOD) == "works"
    page = "\n".join(check.page(GOOD, 8.0))
    assert page.startswith("works\n") and "2 x a" in page and "real-time factor 1.00" in page
    for word in ("robot car", "/scan", "9.9 Hz", "wheels", "running"):
        assert word in page


@pytest.mark.parametrize(
    "found, words",
    [
        (changed(refused="no such file"), ["roslaunch refuses", "no such file"]),
        (changed(cannot=[["laser_tools", "merge"]]), ["laser_tools/merge", "no such node"]),
        (
            changed(cannot=[["laser_tools", "merge"]], builders={"merge": ["laser_tools", False]}),
            ["laser_tools/merge", "laser_tools is not installed"],
        ),
        (
            changed(cannot=[["tools", "merge"]], builders={"merge": ["laser_tools", True]}),
            ["tools/merge", "C++ of laser_tools", "not built"],
        ),
        (changed(unable=["joystick"]), ["joystick", "cannot be run"]),
        (changed(died=[dead("mux", "mux.py")]), ["node mux (mux.py) died", "1"]),
        (changed(lost=["world plugin 'x'"]), ["world plugin 'x'"]),
        (
            changed(
                car_lost=["plugin 'libhover.so' is not known here and is ignored"],
                builders={"hover": ["h_g", True]},
            ),
            ["libhover.so", "C++ of package h_g"],
        ),
        (changed(models=[GOOD["models"][0]]), ["no robot"]),
        (changed(car_after=None), ["car", "where it is"]),
        (changed(car_after=state(position=(1.0, 2.4, 0.05))), ["moves by itself", "0.40 m"]),
        (changed(car_after=state(position=(1.0, math.nan, 0.0))), ["car", "not finite"]),
        (
            changed(car_before=state(position=(1, 2, -5.0)), car_after=state(position=(1, 2, -5))),
            ["fallen", "-5.0 m"],
        ),
        (
            changed(car_after=state(orientation=(math.sin(0.5), 0.0, 0.0, math.cos(0.5)))),
            ["tilted", "57 degrees"],
        ),
        (changed(car_controllers=None), ["controller_manager", "/car", "does not answer"]),
        (changed(car_controllers=[]), ["no controller", "spawner"]),
        (changed(car_controllers=[["arm", "x", "stopped"]]), ["arm", "stopped"]),
        (
            changed(car_sensors=[{"topic": "/t", "rate": 30.0, "count": 0, "measured": None}]),
            ["/t", "sends nothing"],
        ),
        (
            changed(car_sensors=[{"topic": "/t", "rate": 30.0, "count": 9, "measured": 12.0}]),
            ["/t", "12.0 of 30 Hz"],
        ),
    ],
)
def test_one_problem_each(found, words):
    (sentence,) = check_verdict.problems(found)
    assert all(word in sentence for word in words), sentence


MISSING = {"cannot": [["tools", "merge"], ["gone", "node"]],
           "builders": {"merge": ["laser_tools", True], "node": ["gone", False]}}  # fmt: skip


MEANT = "plugin '{}' is not known here and is ignored; did you mean 'libgazebo_ros_control.so'?"


def test_a_plugin_of_ones_own_with_a_name_that_is_nearly_known():
    text = MEANT.format("libgazebo_ros_control2.so")
    found = changed(car_lost=[text], builders={"gazebo_ros_control2": ["x_control", True]})
    (said,) = check_verdict.problems(found)
    assert said.startswith(f"{text}: it is C++ of package x_control; ")


@pytest.mark.parametrize("library", ["libgazebo_ros_contol.so", "gazebo_ros_contol"])
def test_a_plugin_that_is_misspelled(library, monkeypatch):
    found = changed(
        car_lost=[MEANT.format(library)], builders={"gazebo_ros_control": ["x_control", True]}
    )
    assert check_verdict.problems(found) == [MEANT.format(library)]
    assert check_verdict.verdict(found) == f"works without plugin {library}"
    sought = set()
    monkeypatch.setattr(
        check_sources, "_found_in_sources", lambda _, names: sought.update(names) or {}
    )
    check_sources.builders(found)
    assert "gazebo_ros_control" not in sought


NO_GDAL = "elevation data, which GDAL reads (apt-get install python3-gdal)"  # of formats/shapes.py
HILL = {"heightmaps cannot be used and are left out": ["/w/hill.asc"]}
MESHES = {"meshes are missing and left out": ["package://a/b.stl", "package://a/c.stl"]}
MODELS = {"included models cannot be used": ["'model://cafe_table'", "'model://bookshelf'"]}
DATABASE_MESH = {"meshes are missing and left out": ["model://cafe_table/meshes/cafe_table.dae"]}
KOBUKI = "plugin 'libgazebo_ros_kobuki.so' is not known here and is ignored"
NO_JOINT = (
    "plugin 'libgazebo_ros_diff_drive.so' names joints left, which do not exist or do not move; "
    "movable joints are port"
)


def test_missing_models_are_told_with_the_command_that_brings_them():
    first, second = check_verdict.problems(changed(missing=MODELS, car_missing=MESHES))
    assert first == (
        "2 models of Gazebo's database are missing: bookshelf, cafe_table; "
        "./run add models bookshelf cafe_table"
    )
    assert second.startswith("2 meshes are missing and left out: package://a/b.stl")
    own = {"included models cannot be used": ["'model://shed_of_mine'"]}
    (said,) = check_verdict.problems(changed(missing=own))
    assert said == "model model://shed_of_mine cannot be used"
    assert check_verdict.verdict(changed(missing=own)) == "works without model shed_of_mine"
    grounds = {f"heightmaps are {NO_GDAL}, and left out": ["/w/hill.asc"]}
    (said,) = check_verdict.problems(changed(missing=grounds))
    assert said == f"heightmap /w/hill.asc is {NO_GDAL}, and left out"


def test_a_file_of_another_machine_that_is_in_the_package():
    found = changed(simulator=False, refused="there is no file /home/ada/ws/src/car/a.launch",
                    moved={"/home/ada/ws/src/car/a.launch": "$(find car)/a.launch"})  # fmt: skip
    (said,) = check_verdict.problems(found)
    assert said.endswith("/a.launch; here it is $(find car)/a.launch")


def test_a_robot_that_is_refused_has_the_reason_of_its_spawner():
    """Another launch file that spawns one is no remedy then."""
    found = changed(models=[GOOD["models"][0]], companions={"robot": [("car", "spawn.launch")]},
                    died=[dead("put", "spawn_model", why="two root links")])  # fmt: skip
    assert check_verdict.problems(found) == ["no robot was spawned: two root links"]
    found["died"][0]["why"] = ""
    assert "+ car spawn.launch" in check_verdict.problems(found)[0]


def test_a_slow_machine_is_no_fault_of_a_sensor():
    silent = {"topic": "/t", "rate": 2.0, "count": 0, "measured": None, "is_camera": False}
    slow = changed(car_sensors=[silent], real_time_factor=0.1, simulated=0.8)
    assert check_verdict.problems(slow) == [] and "/t" in check_verdict.notes(slow)[1]
    assert "nothing" in check_verdict.problems({**slow, "simulated": 8.0})[0]
    camera = changed(car_sensors=[{**silent, "is_camera": True}], real_time_factor=0.1)
    assert check_verdict.problems(camera) == []


def test_topics_of_two_robots_say_whose_they_are():
    other = {**GOOD["models"][1], "name": "cart", "driven_by": ["/driver"]}
    lines = check.page(changed(models=[*GOOD["models"], other]), 8.0)
    assert "  of car:" in lines and lines.index("  of cart:") > lines.index("  of car:")
    assert any(line.startswith("robot cart at") and "driven by /driver" in line for line in lines)
    assert "  of car:" not in check.page(GOOD, 8.0)


def test_the_first_line_is_the_verdict_and_its_cause_is_told_once():
    found = changed(died=[dead("mux", "mux.py")], car_sensors=[], models=[GOOD["models"][0]])
    lines = check.page(found, 8.0)
    assert lines[0] == "does not work because no robot was spawned"
    assert "1 more problem:" in lines and not any("no robot" in line for line in lines[1:])


def test_problems_come_in_the_order_of_their_causes():
    sensors = [{"topic": "/t", "rate": 30.0, "count": 0, "measured": None}]
    found = changed(
        **MISSING, died=[dead("mux", "mux.py")], car_lost=["plugin 'libx.so' is not known here"],
        car_sensors=sensors, car_after=state(position=(1.0, 2.4, 0.05))
    )  # fmt: skip
    words = (
        *("gone is not installed", "laser_tools, which is not built", "libx.so", "mux", "/t"),
        "moves by itself",
    )
    said = check_verdict.problems(found)
    assert len(said) == len(words) and all(word in text for word, text in zip(words, said)), said
    assert "./run deps" in said[0] and "catkin_make" in said[1] and "Python class" in said[2]


def massless(base_has_mass):
    """What the reader says of a robot whose arm has no mass."""
    base = link("base") if base_has_mass else '<link name="base"/>'
    joints = (joint(to, "continuous", of, to) for of, to in (("base", "arm"), ("arm", "hand")))
    text = robot(base, '<link name="arm"/>', link("hand"), *joints)
    (warning,) = parse_urdf(text, str, "car").warnings
    assert is_loss(warning)
    return str(warning)


@pytest.mark.parametrize(
    "found, line",
    [
        (changed(**MISSING), "works without node gone/node, node tools/merge"),
        (changed(car_lost=["plugin 'libx.so' is ignored"]), "works without plugin libx.so"),
        (
            changed(car_lost=["plugin 'x' of sensor 'eye' is ignored; take libgazebo_ros_y.so"]),
            "works without plugin x",
        ),
        (changed(died=[dead("mux", "mux.py")]), "works without node mux"),
        (
            changed(car_lost=["controller 'base' has no parameters: /base is not there"]),
            "works without controller base",
        ),
        (
            changed(
                lost=["world file 'a.world' is in none of /b; the empty world takes its place"]
            ),
            "works without world file a.world",
        ),
        (
            changed(car_controllers=[["arm", "x", "stopped"], ["wheels", "y", "running"]]),
            "works without controller arm in /car",
        ),
        (
            changed(car_controllers=[["arm", "x", "stopped"]]),
            "does not work because controller arm in /car is stopped",
        ),
        (changed(models=[GOOD["models"][0]]), "does not work because no robot was spawned"),
        (
            changed(**MISSING, car_after=state(position=(1.0, 2.4, 0.05))),
            "does not work because node gone/node cannot start: package gone is not installed; "
            + check_remedies.GENERIC,
        ),
        (
            changed(car_after=state(position=(1.0, 2.4, 0.05))),
            "does not work because robot car moves by itself: 0.40 m while it was watched",
        ),
        (
            changed(car_after=state(position=(1.0, 2.4, 0.05)), car_driven_by=["/driver"]),
            "works",
        ),
        (
            changed(missing=HILL, car_after=state(position=(1.0, 2.0, -5e3))),
            "does not work because heightmap /w/hill.asc cannot be used and is left out",
        ),
        (
            changed(missing=MESHES, car_after=state(position=(1.0, 2.4, 0.05))),
            "does not work because robot car moves by itself: 0.40 m while it was watched",
        ),
        (
            changed(missing=DATABASE_MESH, car_after=state(position=(1.0, 2.4, 0.05))),
            "does not work because robot car moves by itself: 0.40 m while it was watched",
        ),
        (changed(missing=MODELS, car_missing=MESHES), "works without 2 models, 2 meshes"),
        (
            changed(car_lost=[KOBUKI]),
            f"does not drive because {KOBUKI}; {check_remedies.for_plugin('libx.so')}",
        ),
        (
            changed(died=[dead("car", "drive.py", why="cv2.error: x", drives=True)]),
            "does not drive because node car (drive.py) died with exit code 1: cv2.error: x",
        ),
        (changed(car_lost=[massless(True)]), "works without links without mass: arm, hand"),
        (changed(car_lost=[massless(False)]), f"does not work because {massless(False)}"),
        (
            changed(car_lost=[NO_JOINT]),
            f"does not drive because {NO_JOINT}",
        ),
    ],
)
def test_the_verdict(found, line):
    assert check_verdict.verdict(found) == line


def test_what_this_machine_or_a_missing_screen_does_is_no_problem():
    camera = {"topic": "/image", "type": "sensor_msgs/Image", "rate": 30.0, "count": 80,
              "measured": 10.0, "link": "eye", "is_camera": True}  # fmt: skip
    died = [dead("view", "rviz", -6, screen=True), dead("keys", "keys.py", screen=True)]
    found = changed(died=died, car_sensors=[camera], real_time_factor=0.5, was_paused=True)
    assert check_verdict.problems(found) == []
    screen, keys, paused, slow, image = check_verdict.notes(found)
    assert "view (rviz) wants a screen" in screen and "0.50 s" in slow
    assert "keys" in keys and "starts the world paused" in paused
    assert "/image 10.0" in image and "30 are wanted" in image
    page = "\n".join(check.page(found, 8.0))
    assert "worth knowing" in page and page.startswith("works\n")
    assert check_verdict.notes(GOOD) == []


def test_windows_that_are_missing_or_required_are_no_problem():
    found = changed(cannot=[["rqt_robot_steering", "rqt_robot_steering"]], died=[])
    assert check_verdict.problems(found) == [] and "not installed" in check_verdict.notes(found)[0]

    class Node:
        def __init__(self, package, node_type, name=None, required=False, respawn=False):
            self.type, self.required, self.respawn = node_type, required, respawn
            self.launch_prefix = None

    check_roslaunch.without_required_windows(Node)
    window = Node("rviz", "rviz", "view", required=True, respawn=True)
    driver = Node("base", "driver", "driver", required=True, respawn=True)
    assert (window.required, window.respawn) == (False, False)
    assert (driver.required, driver.respawn) == (True, True)


def test_a_launch_that_ends_early_has_no_simulator(monkeypatch):
    class Gone:
        def getSystemState(self):
            raise ConnectionRefusedError

    monkeypatch.setattr(check_observer.rospy, "get_master", Gone)
    assert check_observer.find_simulator() is None


def test_launch_arguments_get_to_the_launch_file(monkeypatch):
    seen = []
    monkeypatch.setattr(check, "run", lambda options, rest: seen.append((options, rest)))
    cli.parsed("check", check, ["car", "car.launch", "--seconds", "3", "gui:=false", "n:=2"])
    (options, rest), = seen  # fmt: skip
    assert (options.file, options.seconds, rest) == ("car.launch", 3.0, ["gui:=false", "n:=2"])


def test_loose_things_of_the_world_are_no_robots():
    ball = {**GOOD["models"][1], "name": "ball", "furniture": True, "sensors": [],
            "controllers": [], "after": state(position=(1.0, 2.4, 0.05))}  # fmt: skip
    found = changed(models=[*GOOD["models"], *({**ball, "name": f"b{n}"} for n in range(5))])
    assert check_verdict.problems(found) == []
    assert check_verdict.notes(found) == ["loose things move, fall or lie: b0, b1, b2 and 2 more"]
    assert check_verdict.problems(changed(models=[ball])) == ["no robot was spawned"]


def test_a_crate_that_was_spawned_is_no_robot_beside_one():
    fallen = state(orientation=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
    crate = {"name": "crate", "static": False, "furniture": False, "control_namespace": None,
             "sensors": [], "extensions": [], "lost": [], "warnings": [],
             "before": fallen, "after": fallen}  # fmt: skip
    found = changed(models=[*GOOD["models"], crate])
    assert check_verdict.verdict(found) == "works" and check_verdict.robots(found) == [
        GOOD["models"][1]
    ]
    assert check_verdict.notes(found) == ["loose things move, fall or lie: crate"]
    (sentence,) = check_verdict.problems(changed(models=[crate]))
    assert sentence == "robot crate is tilted by 90 degrees"


def test_packages_that_a_refused_file_misses():
    long = 'The following package was not found in <arg name="a: b" value="$(find ferry)/x: y"/>'
    assert check_remedies.named_packages("Resource not found: ferry\nROS path [0]=/a") == ["ferry"]
    assert check_remedies.named_packages(f"Resource not found: {long}: ferry_2\n") == ["ferry_2"]
    assert check_remedies.named_packages("package 'ferry' not found") == ["ferry"]
    assert check_remedies.named_packages(None) == []


def test_sources_of_what_is_missing(tmp_path, monkeypatch):
    for name in ("base", "hover"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (tmp_path / "hover" / "CMakeLists.txt").write_text(
        "project(hover)\nadd_library(${PROJECT_NAME}_plugin SHARED a.cpp)\n"
        "add_executable(drive b.cpp)\nadd_subdirectory(src/pad)\nadd_subdirectory(gone)\n"
    )
    (tmp_path / "hover" / "src" / "pad").mkdir(parents=True)
    (tmp_path / "hover" / "src" / "pad" / "CMakeLists.txt").write_text(
        "add_executable(pad pad.cpp)\n"
    )
    (tmp_path / "hover" / "src" / "pad" / "pad.cpp").write_text("#include <gazebo/g.hh>\n")
    (tmp_path / "hover" / "a.cpp").write_text("#include <ros/ros.h>\n# include <gazebo/g.hh>\n")
    (tmp_path / "hover" / "b.cpp").write_text("#include <ros/ros.h>\n")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    found = {"cannot": [["hover", "drive"], ["hover", "pad"], ["gone", "node"]], "lost": [],
             "models": [{"lost": ["plugin 'libhover_plugin.so' is not known here"]}]}  # fmt: skip
    assert check_sources.builders(found) == {
        "drive": ("hover", True, ""),
        "pad": ("hover", True, "Gazebo's headers"),
        "node": ("gone", False, ""),
        "hover_plugin": ("hover", True, "Gazebo's headers"),
    }


def test_one_command_brings_all_that_is_missing():
    one = {**GOOD, "problems": ["a is not there; ./run add a"], "checked": ["robot", "a.launch"]}
    assert check_verdict.notes(one) == []
    two = {**one, "problems": [*one["problems"], "2 models are missing; ./run add models b c"]}
    assert check_verdict.notes(two) == [
        "./run add --for robot a.launch brings all of these packages and models at once"
    ]


def test_what_would_replace_it():
    def resolve(names):
        return {name: ["laser-filters"] if name == "laser_filters" else [] for name in names}

    remedies = {
        name: check_remedies.for_package(name, set, resolve)
        for name in (
            *("laser_filters", "move_base", "robot_localization", "robot_pose_ekf"),
            *("cmd_vel_mux", "my_own", "slam_toolbox"),
        )
    }
    assert remedies["laser_filters"] == "apt-get install laser-filters"
    assert remedies["move_base"] == "./run add move_base"
    assert remedies["slam_toolbox"] == "./run add slam_toolbox"
    assert remedies["robot_localization"] == "./run add robot_localization"
    assert remedies["robot_pose_ekf"] == "./run add robot_pose_ekf"
    assert remedies["cmd_vel_mux"] == "twist_mux does the same, it comes by ./run add"
    assert "./run deps" in remedies["my_own"]
    assert "Python class" in check_remedies.for_plugin("libhover.so")
    assert "libgazebo_ros_camera" in check_remedies.for_plugin("libhector_gazebo_thermal_camera.so")


def test_what_there_is_has_no_remedy():
    from bullet_sim.plugins import rules

    assert not set(check_remedies.PLUGINS) & set(rules.RULES)


def test_remedies_are_told_with_their_problems():
    found = changed(
        cannot=[["move_base", "move_base"], ["base", "hw"]],
        builders={"move_base": ["move_base", False, ""], "hw": ["base", True, "X's headers"]},
        remedies={"move_base": "look there"},
    )
    missing, absent = check_verdict.problems(found)
    assert "move_base is not installed; look there" in missing
    assert "asks for X's headers" in absent and "Python" in absent
    refused = changed(simulator=False, models=[], refused="Resource not found: amcl",
                      remedies={"amcl": "look here"})  # fmt: skip
    assert check_remedies.missing_packages(refused) == ["amcl"]
    assert check_verdict.problems(refused)[0].endswith("Resource not found: amcl; amcl: look here")


def test_a_model_that_is_refused_for_a_package():
    line = "[FATAL] [1.5]: Package[arm_description] does not have a path"
    found = changed(models=GOOD["models"][:1], errors=[line, line],
                    remedies={"arm_description": "look there"})  # fmt: skip
    assert check_remedies.missing_packages(found) == ["arm_description"]
    assert check_verdict.problems(found)[0].startswith("package arm_description is not there")
    assert check_verdict.problems(found)[0].endswith("; look there")


def test_without_a_simulator():
    found = {"simulator": False, "refused": None, "cannot": [], "died": []}
    (sentence,) = check_verdict.problems(found)
    assert "no simulator" in sentence
    assert check.page(found, 8.0) == [f"does not work because {sentence}"]


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
    words = ["gui:=false", "+", "car", "navigate.launch", "map:=a:=b", "+", "car", "view.launch"]
    assert check.files_of("car", "world.launch", words) == [
        ("car", "world.launch", ["gui:=false"]),
        ("car", "navigate.launch", ["map:=a:=b"]),
        ("car", "view.launch", []),
    ]
    for words, sentence in (
        (["+", "car"], "behind [+] there must be PACKAGE FILE.launch"),
        (["+", "a:=b", "c.launch"], "behind [+] there must be"),
        (["gui"], "unknown argument 'gui'"),
    ):
        with pytest.raises(UsageError, match=sentence):
            check.files_of("car", "world.launch", words)


def test_several_launch_files_are_one(tmp_path):
    environ = {**os.environ, "ROS_PACKAGE_PATH": str(tmp_path / "src")}
    for name in ("world", "navigate"):
        folder = tmp_path / "src" / name / "launch"
        folder.mkdir(parents=True)
        (folder.parent / "package.xml").write_text(f"<package><name>{name}</name></package>")
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


def test_a_plugin_on_a_link_that_is_none_has_no_remedy():
    text = (
        "plugin 'libhector_gazebo_ros_imu.so' has bodyName 'imu', which is no link; it is left out"
    )
    assert check_verdict.problems(changed(lost=[text])) == [text]
