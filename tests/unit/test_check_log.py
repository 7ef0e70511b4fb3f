"""./run check: what is read of what roslaunch and its nodes have written."""

import json
from types import SimpleNamespace

import pytest
from run_rig import Like

from commands import check_log, check_python, check_roslaunch


@pytest.mark.parametrize(
    "said, words",
    [
        ("TabError: inconsistent use of tabs and spaces", "written for Python 2"),
        ("SyntaxError: Missing parentheses in call to 'print'.", "written for Python 2"),
        ("NameError: name 'raw_input' is not defined", "written for Python 2"),
        ("ModuleNotFoundError: No module named 'Tkinter'", "written for Python 2"),
        ("ModuleNotFoundError: No module named 'serial.tools' (x, line 3)", "python3-serial"),
        ("ModuleNotFoundError: No module named 'car.msg'", "package car is not built"),
        ("ModuleNotFoundError: No module named 'some_net'", "pip install some_net"),
        ("ModuleNotFoundError: No module named 'turtlesim.msg'", "; ./run add turtlesim"),
        ("NameError: name 'speed' is not defined", ""),
    ],
)
def test_what_helps_against_what_python_raised(said, words):
    found = check_python.remedy(said, {"car"}.__contains__, {"python3-serial"}.intersection)
    assert words in found if words else found == ""


def read(tmp_path, text="", **nodes):
    """What is read of a launch's own output and of that of nodes, (lines of died.jsonl, output)."""
    folder = tmp_path / "nodes"
    folder.mkdir(exist_ok=True)
    (tmp_path / "log").write_text(text)
    deaths = []
    for name, (died, said) in nodes.items():
        (folder / f"{name}-1").write_text(said)
        deaths += [json.dumps({"name": name, "package": "p", "program": f"{name}.py", "code": 1,
                               "output": f"{name}-1", "paths": []})] * died  # fmt: skip
    (folder / check_log.DIED).write_text("".join(f"{line}\n" for line in deaths))
    return check_log.read(str(tmp_path / "log"), str(folder), {"car"}.__contains__)


RAISED = """[INFO] [1.0]: started
Traceback (most recent call last):
  File "/ws/devel/lib/car/brake", line 15, in <module>
    exec(compile(fh.read(), python_script, 'exec'), context)
  File "/ws/src/car/scripts/brake", line 3, in <module>
    import x
{}
"""
NO_IMAGE = '[ERROR] [1795828120.5]: failed to open image file "{}/yard.pgm": no'


NO_SCREEN = [
    "_tkinter.TclError: no display name and no $DISPLAY environment variable",
    "xterm: Xt error: Can't open display:",
    "qt.qpa.xcb: could not connect to display",
    "freeglut (a): failed to open display ''",
    "pygame.error: No available video device",
    "ImportError: Cannot load backend 'TkAgg' which requires the 'tk' interactive framework",
    "Unable to init server: Could not connect: Connection refused",
    "termios.error: (25, 'Inappropriate ioctl for device')",
]


@pytest.mark.parametrize(
    "said, why",
    [
        *((f"a\n{said}\n", said) for said in NO_SCREEN),
        (RAISED.format("ModuleNotFoundError: No module named 'car.msg'"),
         "ModuleNotFoundError: No module named 'car.msg' (brake, line 3); package car is not..."),
        (RAISED.format("cv2.error: OpenCV(4.6.0) x.cpp:1: error: (-2)"),
         "cv2.error: OpenCV(4.6.0) x.cpp:1: error: (-2) (brake, line 3)"),
        (RAISED.format("KeyboardInterrupt"), "KeyboardInterrupt (brake, line 3)"),
        ('  File "/ws/src/car/a.py", line 34\n    r = b / t\nTabError: inconsistent use of tabs\n',
         "TabError: inconsistent use of tabs (a.py, line 34); it is written for Python 2..."),
        ("[ERROR] [1.5, 2.0]: no parameter /x\n[ WARN] bye\n", "no parameter /x"),
        ("[FATAL] [1.5]: first\n[ERROR] [1.6]: \x1b[31mlast\x1b[0m\n", "last"),
        ("terminate called after\n  what():  no device\n\n", "what():  no device"),
        # published maps name the image by the path that it had when map_saver wrote them
        (NO_IMAGE.format("/home/somebody/maps"), "failed to open image file...; there is no such "
         "folder here: with 'image: yard.pgm' in the map's YAML file..."),
        (NO_IMAGE.format(""), "failed to open image file \"/yard.pgm\": no"),
        ("", ""),
    ],
)  # fmt: skip
def test_a_node_that_died_has_its_own_reason(tmp_path, said, why):
    nodes = {"brake": (1, said), "other": (0, RAISED.format("OSError: x")), "again": (8, "x")}
    node, again = read(tmp_path, **nodes)["died"]
    assert (node["name"], node["program"], node["times"]) == ("brake", "brake.py", 1)
    assert (again["name"], again["times"], again["why"]) == ("again", 8, "x")
    assert node["why"] == Like(why) and node["screen"] == (why in NO_SCREEN)


def test_each_node_writes_to_a_file_of_its_own(tmp_path):
    class Process:
        def __init__(self, args):
            self.name, self.package, self.args, self.exit_code = "ns/watcher-3", "p", args, 7

        def _configure_logging(self):
            return None, None

        def _log_name(self):
            return "ns-watcher-3"

        def get_exit_description(self):
            return "has died"

    script = tmp_path / "watch.py"
    script.write_text("")
    launch = SimpleNamespace(create_node_process=lambda run_id, node: Process(node.args))
    check_roslaunch.keep_outputs(Process, launch, str(tmp_path))
    words = ["bash", "-c", "sleep 1; $0 $@", str(script)]
    process = launch.create_node_process("1", SimpleNamespace(type="watch.py", args=words))
    out, error = process._configure_logging()
    out.write(b"said")
    out.close()
    assert error is out and (tmp_path / "ns-watcher-3").read_text() == "said"
    assert process.get_exit_description() == "has died"
    (line,) = (tmp_path / check_log.DIED).read_text().splitlines()
    assert json.loads(line) == {
        "name": "ns/watcher", "package": "p", "program": "watch.py", "code": 7,
        "output": "ns-watcher-3", "paths": [str(script)]
    }  # fmt: skip
    process.exit_code = 0
    process.get_exit_description()
    assert len((tmp_path / check_log.DIED).read_text().splitlines()) == 1


def test_files_of_another_machine_are_looked_for_in_packages(tmp_path):
    (tmp_path / "worlds").mkdir()
    (tmp_path / "worlds" / "yard.world").write_text("")
    texts = ["no file /home/ada/ws/src/car/worlds/yard.world.", "/home/ada/ws/src/car/gone.world",
             f"{tmp_path}/worlds/yard.world", '"$(find old_car)/worlds/yard.world": old_car',
             "$(find old_car)/worlds/gone.world"]  # fmt: skip
    assert check_log.moved(texts, {"car": str(tmp_path)}) == {
        "/home/ada/ws/src/car/worlds/yard.world": "$(find car)/worlds/yard.world",
        "$(find old_car)/worlds/yard.world": "$(find car)/worlds/yard.world",
    }
    assert check_log.moved(texts[3:], {"car": str(tmp_path), "bus": str(tmp_path)}) == {}


def test_a_script_without_its_interpreter(tmp_path):
    script = tmp_path / "old.py"
    script.write_text("#!/usr/bin/no_python -u\n")
    text = (
        "Roslaunch got a 'No such file or directory' error while attempting to run:\n\n"
        f"{script} __name:=old\n\nPlease make sure that all the executables exist.\n"
    )
    said = read(tmp_path, text)
    assert said["interpreters"] == [(str(script), "/usr/bin/no_python")]


LOG = """\x1b[1mprocess[gazebo-2]: started with pid [11]\x1b[0m
ERROR: cannot launch node of type [hover/drive]: hover
[ERROR] [1.0, 2.0]: model 'car' is gone
[ERROR] [1.0, 2.0]: No p gain specified for pid.  Namespace: /gazebo_ros_control/pid_gains/a
[view-5] process has died [pid 12, exit code -6, cmd /usr/lib/rviz/rviz -d a __name:=view].
[done-6] process has died [pid 13, exit code 0, cmd /opt/x/done.py __name:=done].
 * Unable to launch [pad-7].
error: package 'lidar' not found
RLException: while processing car.launch:
  Invalid <param> tag: command returned with code [2].
"""


def test_the_launch_log(tmp_path):
    said = read(tmp_path, LOG)
    assert said["died"] == [] and said["unable"] == ["pad"]
    assert said["cannot"] == [("hover", "drive")]
    assert said["errors"] == ["[ERROR] [1.0, 2.0]: model 'car' is gone"], "no gains are no fault"
    assert "Invalid <param> tag" in said["refused"] and "'lidar' not found" in said["refused"]


TRACEBACK = "The traceback for the exception was written to the log file\n"
# Each file that includes the next one.
WITHIN = "RLException: while processing /a/b.launch:\nwhile processing /a/c.machine:\n"


@pytest.mark.parametrize(
    "text, refused",
    [
        (f"Done.\nResource not found: ferry\nROS path [0]=/a\nROS path [1]=/b\n{TRACEBACK}",
         "Resource not found: ferry"),
        (f"Done.\nunused args [x] for include of [a.launch]\n{TRACEBACK}",
         "unused args [x] for include of [a.launch]"),
        ("unused args [x] for include of [a.launch]\n", None),
        ("RLException: multiple files named [a] in package [b]:\n- /b/1\n- /b/2\nPlease specify\n",
         "multiple files named [a] in package [b]: - /b/1 - /b/2"),
        (f"{WITHIN}environment variable 'HULL' is not set. \n\nMachine xml is <machine/>\n",
         "environment variable 'HULL' is not set. (in /a/c.machine)"),
        (f"{WITHIN}Invalid roslaunch XML syntax: [Errno 2] No such file or directory: "
         f"'/home/ada/x.launch'\n{TRACEBACK}",
         "there is no file /home/ada/x.launch"),
    ],
)  # fmt: skip
def test_what_roslaunch_refuses(tmp_path, text, refused):
    """The cause is said alone."""
    assert read(tmp_path, text)["refused"] == refused
