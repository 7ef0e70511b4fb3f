"""Every command of every page: whether it runs as a test, and if not, why.

`lines()` collects what a reader can type: the lines of boxes and the commands in running text.
Tutorials' boxes and those of other_pages.txt are run by test_pages.py. All else has to match a
pattern of UNRUN, which names the test that does the same, or what forbids a test.
"""

import re
from pathlib import Path

import page as tutorial

ROOT = tutorial.ROOT
OTHERS = Path(__file__).with_name("other_pages.txt")
TOOLS = r"(?:\./run|PADDOCK/run|/opt/paddock/run|(?:roslaunch|rosrun|rosservice|rostopic|rosparam"
TOOLS += r"|rosbag|git|podman|docker|buildah|apt|apt-get|sudo|export|source|cd|rm|mkdir|touch|ssh"
TOOLS += r"|sed|pip|python3?|make|catkin_make|timeout)(?= )|\.(?= [\w.~/-]*/)"
TOOLS += r"|[A-Z_]+=\S+(?= \./run))"
BOX = re.compile(rf"^    ({TOOLS}[^\n]*)$", re.MULTILINE)
INLINE = re.compile(rf"`({TOOLS}[^`]*)`")
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
SHELL = re.compile(r"^```(?:bash|sh|shell|console)\n(.*?)^```", re.DOTALL | re.MULTILINE)


# pattern of commands -> how else they are tried, or why not. The first that matches counts.
UNRUN = {
    r"[A-Z]{3,}\b(?!=)(?!_)|\.\.\.|<[(\w]": "the reader's own names stand in it",
    r"/opt/ros/|/opt/paddock|~/catkin_ws|devel/setup": "a ROS or a workspace that the reader has",
    r"^(podman|sudo|apt-get)|apt ": "changes the machine; .github/workflows builds the image",
    r"^./run container\b": "builds an image: test_run_container.py",
    r"^(rm|mkdir|sed|cd|ssh|export|pip|\.|source|make|catkin_make|rosparam) ": "a tool that is not "
    "ours",
    r"husky|turtlebot3|my_car|my_lab|TURTLEBOT": "packages that the reader fetches; test_check.py",
    r"^./run (setup|bare|docs|ci|soak|bench|test|ruff)\b": "./run bare and CI do them",
    r"ruff|pytest": "./run test lint and ./run test themselves",
    r"^./run (train|evaluate|sweep|cluster)|policy": "trains: ./run test learning",
    r"environment_beside_launch": "tests/long/test_environment_beside_launch.py",
    r"^./run desk|DESK_": "Chromium and a screen: ./run test desk",
    r"^./run (web|world gui|truck web)|bullet_web web|web:=true|--share": "./run test web",
    r"^./run (add|exec catkin_make install)": "fetches or builds for minutes: test_run_add.py, "
    "tests/long/test_install_space.py",
    r"^./run map": "src/paddock_navigation/test/test_maps.py",
    r"paddock_navigation|move_base|map_saver|map_server": "after ./run add: tests/ros/map_rig.py",
    r"^./run check": "test_check.py, and the tutorial about a package",
    r"^./run (teleop|demo|lap|truck --back|$)|^./run \w+:=|MASTER_URI=|^./run$": "test_window.py, "
    "test_lap.py, tests/long, and ./run demo in CI",
    r"platforms\.py|states_beside_gazebo|conformance/run": "needs the network, Gazebo, or clones",
    r"paths_beside|pictures|results_page|rooms\.py|solver_data": "writes into docs/: "
    "test_bench_paths.py, test_bench_pictures.py, test_documents.py",
    r"example\.py": "test_documents.py runs it",
    r"list_controller_types": "tests/ros/own_classes_rig.py",
    r"roscore|rosbag play": "for rviz on a screen; rosbag's own",
    r"^./run replay|bullet_web (replay|record)": "test_bag.py, test_replay.py; a tutorial",
    r"joystick|joy_node": "a game pad: tests/ros/test_joystick.py, "
    "src/standins/joy/test/test_joy_node.py",
    r"keyboard": "a terminal's keys: test_keyboard.py",
    r"goal|put_back": "drives on: test_goal.py, test_drive.py",
    r"steering_map|plot_pose|plot\.launch": "test_cybertruck_physics.py, tests of cybertruck",
    r"^./run (world|truck)\b|exec (bash|roslaunch|rostopic pub)|^roslaunch |rqt": "launches: "
    "tests/ros/ start these files, test_documents.py looks each argument up",
    r"spawn_model|gzserver|bullet_bridge bridge": "test_spawner.py, "
    "test_world_files.py, tests/long",
    r"my\.yaml|route|xacro": "files of the reader: test_track.py, test_ros_packages.py",
    r"topics: \[/|rosservice call /gazebo/step": "lockstep: test_lockstep.py, test_step.py",
    r"^./run( --help| \w+|)$": "named in a sentence",
}


def lines(path):
    """Lists what a reader can type of a page, without comments and what tutorials run."""
    text = path.read_text()
    if path not in tutorial.PAGES:  # those run their own
        text = SHELL.sub(lambda box: re.sub("^", "    ", box[1], flags=re.MULTILINE), text)
    text = re.sub(r" \\\n\s*", " ", FENCE.sub("", text))
    found = BOX.findall(text) + [" ".join(each.split()) for each in INLINE.findall(text)]
    return [re.sub(r"\s+#.*", "", line).replace("\\|", "|").strip() for line in found]


def run_elsewhere():
    """The commands of other_pages.txt."""
    typed = [box for box in tutorial.boxes(OTHERS) if box.kind in ("run", "terminal")]
    return {line for box in typed for line in box.text.splitlines()}


def reason(line, run=frozenset()):
    """Why a line is not run by test_pages.py; "" where it is, None where nothing says so."""
    if line in run or f"./run exec {line}" in run:
        return ""
    return next((why for pattern, why in UNRUN.items() if re.search(pattern, line)), None)


def named_tests():
    """The files of tests that the reasons of UNRUN name."""
    words = re.findall(r"\b(?:tests/)?(?:\w+/)*\w+\.py\b", " ".join(UNRUN.values()))
    return sorted(set(words))
