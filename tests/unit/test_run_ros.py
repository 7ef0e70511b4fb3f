"""The ROS below: refused systems, what apt is asked for, a ROS that is sourced, and its Python."""

import os
import pathlib
import shutil

import pytest
import ros_rig
import run_rig
from run_rig import ROOT, make_package, ran, run

from commands import environment
from commands.bootstrap import ros, workspace
from commands.errors import CommandError
from commands.subcommands import deps

DEBIAN = (
    'PRETTY_NAME="Debian GNU/Linux {0}"\nNAME="Debian GNU/Linux"\nID=debian\nVERSION_ID="{0}"\n'
)
UBUNTU = (
    'PRETTY_NAME="Ubuntu {0} LTS"\nNAME="Ubuntu"\nVERSION_ID="{0}"\nID=ubuntu\nID_LIKE=debian\n'
    "UBUNTU_CODENAME={1}\n"
)
MINT = 'PRETTY_NAME="Linux Mint {0}"\nID=linuxmint\nVERSION_ID="{0}"\nUBUNTU_CODENAME={1}\n'
FEDORA = 'NAME="Fedora Linux"\nID=fedora\nVERSION_ID=41\nPRETTY_NAME="Fedora Linux 41"\n'
ARCH = 'NAME="Arch Linux"\nPRETTY_NAME="Arch Linux"\nID=arch\n'
REFUSAL = (
    "run: {} has no ROS 1 that Paddock can use ({}): source one of your own for Python 3.8 to 3.13"
    " (Noetic, ROS-O, RoboStack) and start ./run again, or take a container, with its page in the "
    "browser: ./run container\n"
)
NO_APT = "no dpkg-query or apt-get"
ONLY_JAMMY = "of all Ubuntus, 22.04 alone has a ROS 1 of its own that Paddock builds on"


def names(*files):
    """The first name of each entry of lists in config/."""
    lines = "\n".join((ROOT / "config" / name).read_text() for name in files).splitlines()
    words = [line.partition("#")[0].split() for line in lines]
    return sorted({word[0].partition("|")[0] for word in words if word})


@pytest.mark.parametrize(
    "os_release, apt, name, why",
    [
        (UBUNTU.format("24.04", "noble"), True, "Ubuntu 24.04 LTS", ONLY_JAMMY),
        (UBUNTU.format("20.04", "focal"), True, "Ubuntu 20.04 LTS", ONLY_JAMMY),
        (MINT.format("22", "noble"), True, "Linux Mint 22", ONLY_JAMMY),
        (DEBIAN.format("11"), True, "Debian GNU/Linux 11", "Paddock does not build on its ROS 1"),
        (FEDORA, False, "Fedora Linux 41", NO_APT),
        (ARCH, False, "Arch Linux", NO_APT),
        (None, False, os.uname().sysname, NO_APT),  # macOS: Darwin
    ],
)
@pytest.mark.parametrize("arguments", [(), ("demo",), ("--packages",)])
def test_a_system_without_ros_1_is_refused(tmp_path, os_release, apt, name, why, arguments):
    system = ros_rig.System(tmp_path, os_release, apt)
    done = system.run(*arguments)
    assert (done.returncode, done.stdout, done.stderr) == (1, "", REFUSAL.format(name, why))
    assert system.installed() is None
    assert [path for path in (system.root / ".cache").rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("arguments", [("--help",), ("help",)])
def test_a_refused_system_has_help(tmp_path, arguments):
    done = ros_rig.System(tmp_path, FEDORA, apt=False).run(*arguments)
    assert done.returncode == 0 and done.stdout.startswith("usage: ./run")


@pytest.mark.parametrize("os_release", [DEBIAN.format(12), DEBIAN.format(13),
                                        UBUNTU.format("22.04", "jammy"), MINT.format(21, "jammy"),
                                        "ID=debian\nPRETTY_NAME='Debian sid'\n"])  # fmt: skip
def test_other_systems_get_debians_ros(tmp_path, os_release):
    system = ros_rig.System(tmp_path, os_release)
    done = system.run("setup")
    assert "ROS 1" not in done.stdout and "[1/4] " in done.stdout, done.stderr
    assert system.installed() == names("apt-first.txt")  # the rest beside other steps
    system.calls.unlink()
    done = system.use_python().run("--packages")
    assert done.returncode == 0 and "[1/4] " in done.stdout, done.stderr
    rest = set(names("apt.txt", "apt-ros.txt")) - set(names("apt-first.txt"))
    assert system.installed() == sorted(rest) and " update\n" not in system.calls.read_text()


SOME = "new|old\nnewer|newest # why\nplain\n"
UBUNTUS = "onnx  !focal  # PyPI's there\nother # not !focal\n"


@pytest.mark.parametrize("codename, text, known, there, installed", [
    ("bookworm", SOME, "old newer newest plain", "", ["newer", "old", "plain"]),
    # python3-xlib, which many desktops have, is no reason to go without python3-pynput.
    ("bookworm", "new|old\n", "new old", "old", ["new"]),
    ("bookworm", "new|old\n", "old", "old", None),
    ("bookworm", "new|old\n", "", "old", None),
    ("focal", UBUNTUS, "", "", ["other"]),
    ("jammy", UBUNTUS, "", "", ["onnx", "other"]),
])  # fmt: skip
def test_what_a_list_names_is_installed_once(tmp_path, codename, text, known, there, installed):
    release, environ = DEBIAN.format(12), {"KNOWN": known, "INSTALLED": there}
    if codename != "bookworm":  # refused without a ROS of one's own
        release = UBUNTU.format("20.04", codename)
        one = ros_rig.make_ros(tmp_path / "one", ["rospy"])
        environ.update(ros_rig.sourced(one, {}))
    system = ros_rig.System(tmp_path, release).use_python()
    (system.root / "config" / "some.txt").write_text(text)
    done = system.run("--packages", "some.txt", "4", **environ)
    assert system.installed() == installed
    assert (f"[1/4] {len(installed or '')} Debian packages done" in done.stdout) == bool(installed)
    system.calls.unlink(missing_ok=True)
    system.run("--packages", "some.txt", "4", **environ)
    assert system.installed() is None


def test_a_sourced_ros_is_named_first_and_debians_is_not_installed(tmp_path):
    system = ros_rig.System(tmp_path, UBUNTU.format("24.04", "noble"))
    one = ros_rig.make_ros(tmp_path / "one", ["rospy"])
    done = system.run("setup", **ros_rig.sourced(one, {}))
    assert done.stdout.startswith(f"ROS 1: {one}\n[1/4] "), done.stdout + done.stderr
    assert system.installed() == names("apt-first.txt")
    system.calls.unlink()
    system.use_python().run("--packages", **ros_rig.sourced(one, {}))
    assert system.installed() == names("apt.txt")


def test_modules_for_the_systems_python_are_no_use_to_another_one(tmp_path):
    system = ros_rig.System(tmp_path, DEBIAN.format(12))
    own = ros_rig.make_ros(tmp_path / "own", ["rospy"], python="")
    system.use_python().run("--packages", **ros_rig.sourced(own, {}))
    every = names("apt.txt", "apt-first.txt")
    wanted = [name for name in every if not name.startswith("python3-")]
    assert system.installed() == wanted and "python3" in wanted


@pytest.mark.parametrize(
    "changes, found",
    [
        ({}, True),
        ({"ROS_VERSION": "1"}, True),
        ({"ROS_VERSION": "2"}, False),
        ({"ROS_DISTRO": ""}, False),
        ({"CMAKE_PREFIX_PATH": "/usr:/nowhere"}, False),
        ({"CMAKE_PREFIX_PATH": ""}, False),
    ],
)
def test_when_a_ros_is_sourced(tmp_path, changes, found):
    """As commands/ and the file run see it."""
    one = ros_rig.make_ros(tmp_path / "one", ["rospy"])
    environ = {**ros_rig.sourced(one, {}), **changes}
    assert ros.sourced(environ) == (str(one) if found else "")
    system = ros_rig.System(tmp_path, FEDORA, apt=False)
    done = system.run("setup", **environ)
    assert done.stdout.startswith(f"ROS 1: {one}\n") == found
    assert ("has no ROS 1" in done.stderr) != found


@pytest.fixture
def found(monkeypatch, tmp_path):
    """Makes a folder the ROS that is sourced here, with no .venv made for any."""

    def source(folder):
        for name, value in ros_rig.sourced(folder, {}).items():
            monkeypatch.setenv(name, value)
        monkeypatch.delenv("ROS_VERSION", raising=False)
        monkeypatch.setattr(ros, "VENV_STAMP", str(tmp_path / "stamp"))
        monkeypatch.setattr(ros, "PYTHON", str(tmp_path / "none"))
        monkeypatch.setenv("PATH", "/nowhere")
        return folder

    monkeypatch.setattr(ros, "_found", {})
    return source


@pytest.mark.parametrize("python, problem", [
    *((f'[ "$ROS_PROBE" = here ] && echo a banner && echo 3 {minor}', None)
      for minor in (8, 11, 13)),
    ("echo 3 7", "is for Python 3.7, and Paddock needs 3.8 to 3.13: "),
    ("echo 3 14", "is for Python 3.14, and Paddock needs 3.8 to 3.13: "),
    ("echo No module named rospy >&2; exit 1",
     "imports in no Python from 3.8 to 3.13 ({}/bin/python3: No module named rospy): "),
    (None, "imports in no Python from 3.8 to 3.13 (there is none): "),
])  # fmt: skip
def test_its_python_is_the_one_that_imports_its_rospy(found, tmp_path, python, problem):
    """One that is too old, or has none, is one sentence."""
    one = found(ros_rig.make_ros(tmp_path / "one", ["rospy"], python=python))
    if problem is None:
        assert ros.python() == str(one / "bin" / "python3")
        return
    with pytest.raises(CommandError) as raised:
        ros.check()
    said = str(raised.value)
    assert said.startswith(f"rospy of the ROS that is sourced, {one}, {problem.format(one)}")
    assert said.endswith("(Noetic, ROS-O, RoboStack), or a container (docs/container.md), will do")
    assert raised.value.advice == ()


def complete(folder, without=()):
    """A ROS with all that Paddock asks of one, except some."""
    wanted = {name for _, name, _ in ros.listed()} - set(without)
    return ros_rig.make_ros(folder, wanted, python="echo 3 11")


def test_what_a_ros_lacks(found, tmp_path, capsys):
    one = found(complete(tmp_path / "one", ["tf2_ros", "cv_bridge", "rviz"]))
    with pytest.raises(CommandError) as raised:
        ros.check()
    assert str(raised.value) == (
        f"the ROS that is sourced, {one}, lacks tf2_ros, cv_bridge, and Paddock does not mix it "
        "with Debian's ROS"
    )
    for name in ("tf2_ros", "cv_bridge"):
        make_package(one / "share" / name, name)
    capsys.readouterr()
    ros.check()
    assert f"{one} lacks rviz: what needs that will not start\n" in capsys.readouterr().out


def test_stand_ins_give_way_to_the_sourced_ros_alone(found, tmp_path):
    found(ros_rig.make_ros(tmp_path / "one", ["rospy", "xacro", "joy", "gazebo_ros", "rviz"]))
    assert workspace.installed_elsewhere() == ["joy", "xacro"]  # gazebo_ros starts the simulator
    folders, files, listed = workspace.scan()
    before = workspace.build_key(files, listed)
    found(ros_rig.make_ros(tmp_path / "other", ["rospy", "xacro", "joy"]))
    assert workspace.installed_elsewhere() == ["joy", "xacro"]
    assert workspace.build_key(files, listed) != before


@pytest.mark.parametrize("shell", [["bash", "--norc", "-c"], ["zsh", "-f", "-c"]])
def test_gazebo_ros_is_ours_in_our_shells_alone(tmp_path, shell):
    """A ROS that has the real one, as most of Noetic do: who does not start ./run keeps it."""
    noetic = ros_rig.make_ros(tmp_path / "noetic", ["rospy", "gazebo_ros"])
    before = {path: path.stat().st_mtime_ns for path in noetic.rglob("*")}

    def found(environ):
        done = ran(*shell, f". '{noetic}/setup.bash' && exec env -0", env=environ)
        there = dict(entry.split("=", 1) for entry in done.stdout.split("\0")[:-1])
        ours = environment.activated(dict(there))
        find = shutil.which("rospack"), "find", "gazebo_ros"
        return [ran(*find, env=each).stdout for each in (there, ours)]

    plain = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    if "LD_LIBRARY_PATH" in os.environ:  # of the rospack of a ROS that is not Debian's
        plain["LD_LIBRARY_PATH"] = os.environ["LD_LIBRARY_PATH"]
    real, standin = f"{noetic}/share/gazebo_ros\n", f"{ROOT}/src/standins/gazebo_ros\n"
    assert found(plain) == [real, standin]
    assert {path: path.stat().st_mtime_ns for path in noetic.rglob("*")} == before


def test_stand_ins_that_give_way_are_not_found_in_the_sources(found, monkeypatch, tmp_path):
    standins = tmp_path / "standins"
    for name in ("joy", "xacro", "control_msgs", "gazebo_ros", "roslint"):
        make_package(standins / name, name)
    (standins / "control_msgs" / "CATKIN_IGNORE").write_text("")  # somebody's own
    (standins / "README.md").write_text("")
    monkeypatch.setattr(workspace, "STANDINS", str(standins))

    def hidden():
        workspace.hide()
        return sorted(path.parent.name for path in standins.glob("*/CATKIN_IGNORE"))

    found(ros_rig.make_ros(tmp_path / "one", ["rospy", "xacro", "joy", "gazebo_ros"]))
    assert hidden() == hidden() == ["control_msgs", "joy"]  # xacro.py of old launch files is found
    found(ros_rig.make_ros(tmp_path / "other", ["rospy", "roslint"]))
    assert hidden() == ["control_msgs", "roslint"]


def test_debian_packages_of_ros_are_no_answer_for_a_sourced_one(found, tmp_path):
    found(ros_rig.make_ros(tmp_path / "one", ["rospy", "tf2_ros"]))
    assert deps.of_sourced_ros() == {"rospy", "tf2_ros"} and "gazebo_ros" in deps.ours()
    assert deps.resolve(["move_base_msgs"], debians_ros=False) == {"move_base_msgs": []}
    assert deps.resolve(["python3-scipy"], debians_ros=False)["python3-scipy"] == ["python3-scipy"]
    package = tmp_path / "package.xml"
    package.write_text(
        "<package><name>a</name><depend>tf2_ros</depend><depend>rviz</depend>"
        "<depend>gazebo_ros</depend></package>"
    )
    answer = deps.find(str(tmp_path), set, set)
    assert answer.sourced == ["tf2_ros"] and answer.nowhere == {"rviz": ["a"]}
    one = tmp_path / "one"
    assert deps.page(answer) == [
        "packages: a", "in Paddock: gazebo_ros", f"in {one}: tf2_ros",
        f"neither in Debian nor in {one} nor in Paddock:", "  rviz, for a",
    ]  # fmt: skip


ROS_2 = {
    "ROS_VERSION": "2", "ROS_DISTRO": "humble", "AMENT_PREFIX_PATH": "/ws/a:/opt/ros/humble",
    "PYTHONPATH": "/opt/ros/humble/lib/python3.10/site-packages:/mine",
    "LD_LIBRARY_PATH": "/opt/ros/humble/lib:/ws/a/lib",
    "PATH": "/opt/ros/humble/bin:/opt/ros/humbler/bin:/usr/bin",
}  # fmt: skip


def test_a_ros_2_has_no_part_in_commands():
    plain = {"PATH": "/usr/bin:/bin", "HOME": "/tmp"}
    both = {**plain, **ROS_2, "PATH": f"{ROS_2['PATH']}:/bin"}
    first, second = (run("exec", "/usr/bin/env", env=environ) for environ in (plain, both))
    assert first.returncode == 0 and second.returncode == 0, second.stderr
    assert "humble/" not in second.stdout and "ROS_VERSION=2" not in second.stdout
    assert "/mine" in second.stdout and "/opt/ros/humbler/bin" in second.stdout


@pytest.fixture
def own_index():
    """A package index that answers; that of other tests waits until they let it."""
    index = run_rig.PackageIndex()
    index.open.set()
    yield index
    index.close()


def test_set_up_on_a_sourced_ros_and_back(tmp_path, own_index):
    """A small clone on a ROS in a folder of its own, whose packages are links to this one's."""
    root = run_rig.small_clone(tmp_path / "paddock")
    share = pathlib.Path(ros.share())
    one = tmp_path / "one"
    absent = [name for _, name, _ in ros.listed() if not (share / name).is_dir()]
    ros_rig.make_ros(one, set(absent))  # Debian's cv_bridge has no package.xml
    for name in {name for _, name, _ in ros.listed()} - set(absent):
        (one / "share" / name).symlink_to(share / name)
    (one / "setup.bash").write_text(
        f"export ROS_DISTRO={os.environ['ROS_DISTRO']} CMAKE_PREFIX_PATH={one}:$CMAKE_PREFIX_PATH\n"
    )
    if ros.prefix():  # this one itself is no Debian's
        text = (one / "setup.bash").read_text()
        (one / "setup.bash").write_text(f". {ros.prefix()}/setup.bash\n{text}")
    plain = own_index.environment()
    done = run("setup", root=root, env=ros_rig.sourced(one, plain))
    assert done.returncode == 0, done.stdout + done.stderr
    first, *rest = done.stdout.splitlines()
    python = os.path.realpath(ros.PYTHON)
    assert first == f"ROS 1: {one}, as sourced, with {python}"
    assert any(line.startswith("[2/4] Python packages done") for line in rest)
    assert any(line.startswith("[3/4] Workspace done") for line in rest)
    stamp = (root / ".venv" / ".stamp").read_text().splitlines()[0]
    assert stamp == f"{python} {root} {one}"
    cache = (root / "build" / "CMakeCache.txt").read_text()
    assert f"CMAKE_PREFIX_PATH:UNINITIALIZED={one}" in cache or f"PREFIX_PATH:STRING={one}" in cache
    for name in ("ROS_DISTRO", "CMAKE_PREFIX_PATH"):
        plain.pop(name, None)
    again = run("setup", root=root, env=plain)  # remembered, nothing to do
    assert (again.returncode, again.stdout) == (0, f"ready: {root}\n")
    (root / "src" / "probe" / "nodes" / "second").write_text("")
    again = run("setup", root=root, env=plain)
    assert again.stdout.startswith(f"ROS 1: {one}, as when .venv was made; none is sourced, with ")
    assert "[3/4] Workspace done" in again.stdout and "[2/4]" not in again.stdout
