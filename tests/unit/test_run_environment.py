"""The environment of ./run exec: as by sourcing devel/setup.bash, with the caller's values kept."""

import pytest
from environment_rig import PLAIN, SOURCE, by_run, variables
from run_rig import ROOT, Like, make_package, program, ran, run

from commands.bootstrap import ros, workspace
from commands.environment import LEFT_OUT

# What is in front of PATH, and where packages are: a ROS that is not Debian's names its folder.
FIRST = f"{ROOT}/.venv/bin:" if workspace.in_ros("xacro") else f"{ROOT}/src/standins/xacro:"
PACKAGES = f"{ROOT}/src:{ros.share()}" if ros.prefix() else f"{ROOT}/src"


def other_workspace(folder):
    """Variables as somebody else's workspace leaves them, and that workspace."""
    for name in ("devel/lib/python3/dist-packages", "src"):
        (folder / name).mkdir(parents=True)
    (folder / "devel" / ".catkin").write_text(str(folder / "src"))
    return {
        "CMAKE_PREFIX_PATH": f"{folder}/devel:/usr",
        "LD_LIBRARY_PATH": f"{folder}/devel/lib:/opt/lib",
        "PYTHONPATH": f"{folder}/devel/lib/python3/dist-packages:/opt/python",
        "ROS_PACKAGE_PATH": f"{folder}/src:/opt/packages",
        "ROS_DISTRO": "noetic",
    }


def by_hand(environ):
    """The variables that sourcing devel/setup.bash leaves, but for those that ./run adds to."""
    environ = {name: value for name, value in environ.items() if name not in LEFT_OUT}
    done = ran("/bin/bash", "-c", SOURCE, env=environ)
    added = ("PATH", "PYTHONPATH", "ROS_PACKAGE_PATH")
    return {name: value for name, value in variables(done).items() if name not in added}


@pytest.mark.parametrize(
    "extra, own",
    [
        ({}, {"LANG": "C.UTF-8", "ROS_IP": "127.0.0.1", "VIRTUAL_ENV": f"{ROOT}/.venv",
              "ROS_LOG_DIR": f"{ROOT}/.cache/ros", "PYTHONNOUSERSITE": "1",
              "OPENBLAS_NUM_THREADS": "1", "PADDOCK_ROOT": str(ROOT), "PYTHONHOME": None}),
        ({"PATH": "/opt/mine:/usr/bin:/bin", "PYTHONHOME": "/opt", "CONDA_PREFIX": "/opt"},
         {"PYTHONHOME": None, "CONDA_PREFIX": None}),
        ({"LD_LIBRARY_PATH": "/opt/lib:", "PKG_CONFIG_PATH": "/opt"}, {}),
        ({"CMAKE_PREFIX_PATH": "/nonexistent", "LD_LIBRARY_PATH": "/nonexistent/lib:/opt/lib"}, {}),
        ({"ROS_IP": "10.0.0.1", "ROS_LOG_DIR": "/tmp/x", "LC_ALL": "C"}, {"LANG": None}),
        ({"ROS_MASTER_URI": "http://a:1"}, {"ROS_MASTER_URI": "http://a:1"}),
        ({"ROS_HOSTNAME": "somewhere", "LANG": "C", "LC_CTYPE": "C.UTF-8"}, {"ROS_IP": None}),
    ],
)  # fmt: skip
def test_as_by_hand(extra, own):
    environ = {**PLAIN, **extra}
    found = by_run(ROOT, environ)
    for name, value in {**by_hand(environ), **own}.items():
        assert found.get(name) == value, name


def test_another_workspace_is_left(tmp_path):
    found = by_run(ROOT, {**PLAIN, **other_workspace(tmp_path)})
    assert found["ROS_PACKAGE_PATH"] == f"{PACKAGES}:/opt/packages"
    assert found["PYTHONPATH"].endswith(f"dist-packages:/opt/python:{ROOT}/config/python")
    assert found["LD_LIBRARY_PATH"].endswith(":/opt/lib")
    assert str(tmp_path) not in " ".join(found.values())


def test_a_workspace_on_top_of_ours_stays_in_front(tmp_path):
    theirs = other_workspace(tmp_path)
    ours = by_run(ROOT, PLAIN)
    chained = {**ours, **{name: f"{value.split(':')[0]}:{ours.get(name, '')}"
                          for name, value in theirs.items() if ":" in value}}  # fmt: skip
    found = by_run(ROOT, chained)
    for name in ("CMAKE_PREFIX_PATH", "LD_LIBRARY_PATH", "PYTHONPATH", "ROS_PACKAGE_PATH"):
        assert found[name] == chained[name], name


def test_the_callers_paths_stay_behind_ours():
    environ = {**PLAIN, "PATH": "/opt/first:/usr/bin:/bin", "ROS_PACKAGE_PATH": "/opt/a:/opt/b"}
    found = by_run(ROOT, environ)
    assert found["PATH"].startswith(FIRST) and f"{ROOT}/.venv/bin:" in found["PATH"]
    assert found["PATH"].endswith(":/opt/first:/usr/bin:/bin")
    assert found["ROS_PACKAGE_PATH"] == f"{PACKAGES}:/opt/a:/opt/b"


def test_a_package_of_the_callers_with_the_name_of_one_of_ours_is_found_in_its_place(tmp_path):
    theirs, others = tmp_path / "ws" / "src", tmp_path / "others"
    for folder, name in ((theirs / "car" / "track_model", "track_model"), (others / "b", "b")):
        (make_package(folder, f" {name} ") / "launch").mkdir()
    launch = theirs / "car" / "track_model" / "launch" / "world.launch"  # a name that ours has, too
    launch.write_text("<launch/>")
    environ = {**PLAIN, "ROS_PACKAGE_PATH": f"{others}:{theirs}"}
    script = "rospack find track_model; roslaunch --files track_model world.launch"
    find = "import roslaunch.substitution_args as s; print(s.resolve_args({!r}))"
    words = "$(find track_model)/launch/world.launch $(find bullet_bridge)/package.xml"
    done = run("exec", "bash", "-c", f'{script}; python3 -c "$0"', find.format(words), env=environ)
    assert done.stdout.split() == [
        str(launch.parents[1]), str(launch), str(launch), f"{ROOT}/src/bullet_bridge/package.xml",
    ], done.stderr  # fmt: skip
    within = by_run(ROOT, by_run(ROOT, environ))
    assert within["ROS_PACKAGE_PATH"] == f"{theirs}:{PACKAGES}:{others}"
    wrong = make_package(tmp_path / "wrong" / "track_model", "track_model")
    (wrong / "package.xml").write_text("<package><name>track_model</name></package>")
    environ["ROS_PACKAGE_PATH"] = str(wrong.parent)
    done = run("exec", "rospack", "find", "track_model", env=environ)
    assert done.stdout == f"{ROOT}/src/track_model\n"
    assert f"{wrong}/package.xml" in done.stderr and "ours is used" in done.stderr


@pytest.mark.parametrize("words, status, said, wrong", [
    (["sh", "-c", "echo out; echo err >&2; exit 7"], 7, "out\n", "err\n"),
    (["no-such-command"], 127, "", "run: cannot run 'no-such-command'..."),
    (["/etc/passwd"], 126, "", "run: cannot run '/etc/passwd'..."),
    (["./script", "a b"], 0, "a b\n", ""),  # a script without a first line is the shell's
])  # fmt: skip
def test_output_and_status_are_the_commands_alone(tmp_path, words, status, said, wrong):
    program(tmp_path / "script", 'echo "$1"\n')
    done = run("exec", *words, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (status, said, Like(wrong))


def test_a_closed_pipe_ends_a_command_silently():
    done = ran("bash", "-c", f"{ROOT}/run exec yes | head -n 1")
    assert (done.stdout, done.stderr) == ("y\n", "")
