"""The install space alone: all that is named is in it, and two worlds come up from it."""

import functools
import json
import os
import re
import subprocess
import unittest
from pathlib import Path

from bullet_sim.engine.quickstep.sources import library_path
from drop_in_workspace import Launched
from install_contents import (
    data_files,
    dependencies,
    executables,
    executables_found,
    found,
    modules,
    nodes_of,
    packages,
    references,
    references_in,
)
from install_tree import ROOT, InstallSpace, cache_entry, descendants
from paddock_common.process import free_port
from sim_client import START_LIMIT, WHEELS

from commands.bootstrap import ros, workspace

# What a ROS that is sourced may be without, and is.
LACKING = set(ros.lacking(ros.prefix())[1]) if ros.prefix() else set()
ADDED = {
    "amcl",
    "gmapping",
    "map_server",
    "move_base",
}  # what ./run add brings, for paddock_navigation
BESIDE = {"gazebo_dev": "gazebo"}  # package -> second folder of share/, where cmake looks
OBSERVER = Path(__file__).with_name("install_observer.py")
SOURCES = tuple(f"{ROOT / name}{os.sep}" for name in ("src", "devel", "build"))
# catkin writes both branches into each ...Config.cmake (Debian's leaves the devel space's out), and
# where the sources were into a message.
DEVEL_BRANCH = re.compile(
    rb'if\("FALSE" STREQUAL "TRUE"\)\n.*?^else\(\)\n|message\(FATAL_ERROR "Project [^\n]*\n',
    re.DOTALL | re.MULTILINE,
)
DESCRIPTIONS = {  # everything that a description can have
    "cybertruck": ("cybertruck.urdf.xacro", "trailer:=true", "lidar:=true", "trailer_lidar:=true"),
    "track_model": ("racecar.urdf.xacro", "lidar:=true"),
}


@functools.lru_cache(maxsize=None)
def install_space():
    """Gives the install space that all tests share."""
    space = InstallSpace()
    unittest.addModuleCleanup(space.close)
    space.install()
    return space


def tearDownModule():
    """Removes the install space."""
    unittest.doModuleCleanups()


class InstalledFiles(unittest.TestCase):
    """What lies in the install space, beside what the sources hold and what they name."""

    @classmethod
    def setUpClass(cls):
        cls.space = install_space()
        cls.prefix = cls.space.prefix
        cls.packages = packages()

    def named_in(self, pattern):
        """Gives (name of a file, it) for those of our packages' share folders."""
        for package in self.packages:
            for path in sorted((self.prefix / "share" / package).rglob(pattern)):
                if path.is_file():
                    yield str(path.relative_to(self.prefix)), path

    def test_data_files_of_the_sources_are_installed(self):
        for package, folder in self.packages.items():
            asked = set(data_files(folder))
            self.assertIn(Path("package.xml"), asked)
            shares = [
                self.prefix / "share" / name for name in (package, BESIDE.get(package, package))
            ]
            missing = sorted(
                str(path) for path in asked if not any((each / path).is_file() for each in shares)
            )
            self.assertEqual(missing, [], package)

    def test_hooks_of_setup_bash_are_installed(self):
        hooks = [path for folder in self.packages.values() for path in folder.glob("env-hooks/*")]
        self.assertTrue(hooks)
        for path in hooks:
            name = path.name[: -len(".in")] if path.suffix == ".in" else path.name
            self.assertTrue((self.prefix / "etc/catkin/profile.d" / name).is_file(), path)

    def test_headers_are_installed(self):
        folders = [folder / "include" for folder in self.packages.values()]
        headers = [path.relative_to(each) for each in folders for path in each.rglob("*.h*")]
        self.assertTrue(headers)
        missing = [path for path in headers if not (self.prefix / "include" / path).is_file()]
        self.assertEqual(missing, [])

    def test_nodes_and_scripts_are_installed_to_be_run_by_env(self):
        for package, folder in self.packages.items():
            for name in executables(folder):
                installed = executables_found(self.prefix, package, name)
                self.assertEqual(len(installed), 1, f"{package} {name}")
                first = installed[0].read_text(encoding="utf-8").partition("\n")[0]
                self.assertRegex(first, r"^#!/usr/bin/env python3?$", installed[0])

    def test_python_modules_are_those_of_the_sources(self):
        asked = set().union(*(modules(folder / "src") for folder in self.packages.values()))
        (place,) = self.prefix.glob("lib/python3*/*-packages")
        ours = {path.parts[0] for path in asked}
        installed = {path for path in modules(place) if path.parts[0] in ours}
        self.assertIn(Path("bullet_sim/world.py"), asked)
        self.assertEqual(sorted(map(str, installed ^ asked)), [], "in one of the two only")

    def test_the_compiled_solver_is_installed(self):
        """Without it the first start compiles it for a minute, in which spawners give up."""
        (place,) = self.prefix.glob("lib/python3*/*-packages")
        folder = place / library_path().parent.relative_to(ROOT / "src" / "bullet_sim" / "src")
        self.assertTrue((folder / library_path().name).is_file(), folder)

    def test_what_files_name_is_there(self):
        count = 0
        for name, path in self.named_in("*"):
            for package, below in references(path):
                if (package, below.partition("/")[0]) == ("gazebo_plugins", "test"):
                    continue  # of range_world.launch, for a workspace that has the original
                count += 1
                ours = package in self.packages or not ros.prefix()
                place = self.prefix if ours else Path(ros.prefix())
                self.assertTrue(found(place, package, below), f"{name}: {package}/{below}")
        self.assertGreater(count, 50, "the walk misses references")

    def test_nodes_of_launch_files_are_there(self):
        named = {node: name for name, path in self.named_in("*.launch") for node in nodes_of(path)}
        self.assertIn(("bullet_bridge", "bridge"), named)
        self.assertLessEqual(ADDED, {package for package, _ in named})
        for (package, kind), name in named.items():
            if package in ADDED:
                self.assertIn("paddock_navigation", name)
                continue
            if package in self.packages:
                there = executables_found(self.prefix, package, kind)
            else:
                there = self.space.run("catkin_find", "--libexec", package).stdout
            self.assertEqual(bool(there), package not in LACKING, f"{name}: {package} {kind}")

    def test_a_bare_xacro_is_the_one_that_finds_packages(self):
        place = self.space.run("sh", "-c", "command -v xacro").stdout.strip()
        folder = ros.prefix() if workspace.in_ros("xacro") else self.prefix
        self.assertEqual(place, f"{folder}/bin/xacro")

    def test_what_expanded_descriptions_name_is_there(self):
        for package, (file, *arguments) in DESCRIPTIONS.items():
            path = self.prefix / "share" / package / "urdf" / file
            done = self.space.run("xacro", path, *arguments)
            self.assertEqual(done.returncode, 0, done.stderr)
            named = set(references_in(done.stdout))
            self.assertGreater(len(named), 5, package)
            for package_named, below in named:
                self.assertTrue(found(self.prefix, package_named, below), f"{file}: {below}")

    def test_rospack_finds_every_package_outside_of_the_sources(self):
        path = self.space.run("printenv", "ROS_PACKAGE_PATH").stdout.strip()
        below = [ros.share()] if ros.prefix() else []  # rospkg knows Debian's by itself
        self.assertEqual(path.split(":"), [str(self.prefix / "share"), *below])
        places = self.rospack()
        for name in self.packages:
            self.assertEqual(places.get(name), str(self.prefix / "share" / name))

    def test_catkin_make_with_the_devel_space_sourced_does_not_chain_it(self):
        # an entry in the cache, though empty for Debian's ROS, keeps CMake from asking the
        # environment
        self.assertEqual(cache_entry("CMAKE_PREFIX_PATH"), ros.prefix())

    def test_dependencies_are_there(self):
        manifests = [path for _, path in self.named_in("package.xml")]
        wanted = set().union(*map(dependencies, manifests)) - set(self.rospack()) - LACKING
        # of some packages Debian has the Python module and no package.xml
        code = "import sys, importlib; [importlib.import_module(name) for name in sys.argv[1:]]"
        done = self.space.run("python3", "-c", code, *sorted(wanted))
        self.assertEqual(done.returncode, 0, done.stderr)

    def rospack(self):
        """Gives name -> place of all packages that are found."""
        done = self.space.run("rospack", "list")
        return dict(line.split(maxsplit=1) for line in done.stdout.splitlines())

    def test_no_file_names_the_sources_or_the_devel_space(self):
        for path in self.prefix.rglob("*"):
            euslisp = path.relative_to(self.prefix).parts[:2] == ("share", "roseus")
            if path.is_file() and path.suffix != ".pyc" and not euslisp:  # geneus' own lists
                content = DEVEL_BRANCH.sub(b"", path.read_bytes())
                named = [place for place in SOURCES if place.encode() in content]
                self.assertEqual(named, [], path)


class InstalledWorlds(unittest.TestCase):
    """Launch files of the install space, each on a master of its own."""

    @classmethod
    def setUpClass(cls):
        cls.space = install_space()

    def observe(self, launched, port, topic, kind):
        """Gives the fields of one message of a launch's topic."""
        try:
            done = self.space.run(
                *("python3", OBSERVER, topic, kind, START_LIMIT),
                limit=START_LIMIT + 20.0,
                ROS_MASTER_URI=f"http://127.0.0.1:{port}",
            )
        except subprocess.TimeoutExpired:
            raise AssertionError(f"no {topic}:\n{launched.output()}") from None
        self.assertEqual(done.returncode, 0, f"{topic}: {done.stderr}\n{launched.output()}")
        return json.loads(done.stdout.splitlines()[-1])

    def assert_processes_use_the_install_space_alone(self, launched):
        """Looks at all that a launch has started."""
        commands = {}
        for pid in descendants(launched.pid):
            try:
                process = Path(f"/proc/{pid}")
                commands[pid] = (process / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                environment = (process / "environ").read_bytes().decode()
                maps = (process / "maps").read_text()
                places = [os.readlink(path) for path in (process / "fd").iterdir()]
                places.append(os.readlink(process / "cwd") + os.sep)
            except (FileNotFoundError, ProcessLookupError, PermissionError):
                continue  # it has ended, as spawners do; what is left of it belongs to root
            for text in (commands[pid], environment, maps, "\n".join(places)):
                named = [place for place in SOURCES if place in text]
                self.assertEqual(named, [], commands[pid])
        bridge = str(self.space.prefix / "lib" / "bullet_bridge" / "bridge")
        self.assertTrue(any(bridge in command for command in commands.values()), commands)

    def test_world_of_the_racing_car(self):
        port = free_port()
        overlay = self.space.overlay("track_model")
        with Launched(overlay, "world.launch", port, headless="true") as launched:
            joints = self.observe(launched, port, "/racecar/joint_states", "sensor_msgs/JointState")
            self.assertLessEqual({f"{wheel}_joint" for wheel in WHEELS}, set(joints["name"]))
            picture = self.observe(launched, port, "/camera/image", "sensor_msgs/Image")
            self.assertEqual((picture["width"], picture["height"]), (640, 480))
            self.assertEqual(picture["data"]["length"], 640 * 480 * 3)
            self.assertGreater(picture["data"]["values"], 20, "colours of the track and the sky")
            self.assert_processes_use_the_install_space_alone(launched)
            self.assertNotIn("Traceback", launched.output())
        tracks = list((self.space.path / "home" / ".cache" / "paddock" / "tracks").iterdir())
        self.assertEqual([path.name[:8] for path in tracks], ["default-"], "generated from there")

    def test_truck_and_trailer(self):
        port = free_port()
        overlay = self.space.overlay("cybertruck")
        with Launched(overlay, "truck.launch", port, headless="true") as launched:
            joints = self.observe(launched, port, "/joint_states", "sensor_msgs/JointState")
            self.assertLessEqual({"front_left_steer_joint", "hitch_yaw_joint"}, set(joints["name"]))
            self.assert_processes_use_the_install_space_alone(launched)
            self.assertNotIn("Traceback", launched.output())
