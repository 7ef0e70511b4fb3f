"""Starts a launch file, monitors what comes up for a while, and writes it as JSON.

    check_observer.py RESULT LOG PORT SECONDS PACKAGE FILE [ARG:=VALUE ...]

Runs with the workspace active and ROS_MASTER_URI set to the port; ./run check starts it.
"""

import functools
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import time
from urllib.parse import urlsplit

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # until main(): imports would say where they were

import roslib.message  # noqa: E402
import rospkg  # noqa: E402
import rospy  # noqa: E402
from controller_manager_msgs.srv import ListControllers  # noqa: E402
from gazebo_msgs.srv import GetModelState, GetPhysicsProperties  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from std_srvs.srv import Empty, Trigger  # noqa: E402

if __name__ == "__main__":
    del sys.path[0]  # this folder: what is in it are modules of commands
    sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))

from commands import check_log, check_sources, processes, procfs  # noqa: E402
from commands.check_roslaunch import OUTPUTS  # noqa: E402

ROSLAUNCH = str(pathlib.Path(__file__).with_name("check_roslaunch.py"))
START_LIMIT = 60.0  # wall time until the simulator answers [s]
SETTLED = 4.0  # wall time without a new model after which spawning is over [s]
SPAWN_LIMIT = 40.0  # wall time for spawning [s]
FIRST_LIMIT = 20.0  # wall time for the first message of each sensor [s] ...
CAMERA_LIMIT = 60.0  # ... of cameras [s]: the renderer may take as long to start on a busy machine
STOP_LIMIT = 20.0  # wall time for the launch to end [s]
BY_SERVICES = "set_model_state or the like"
REPLAY = "paddock_check_replay"  # its node
REPLAY_RATE = 10.0  # frames of the replay a second of wall time
REPLAY_LIMIT = 60.0  # wall time for the replay's first frame, and for it to be written [s]


class ClockMonitor:
    """Simulated time as /clock has it; None before the first message."""

    def __init__(self):
        self.now = None
        self._subscriber = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=1)

    def _on_clock(self, message):
        self.now = message.clock.to_sec()


class Counter:
    """Counts the messages of one topic and the simulated time between first and last.

    Messages without a header, or with an empty one, are dated by /clock.
    """

    def __init__(self, topic, clock):
        self.count, self.first, self.last, self._clock = 0, None, None, clock
        self._subscriber = rospy.Subscriber(topic, rospy.AnyMsg, self._on_message, queue_size=100)

    def _on_message(self, message):
        now = stamp_of(message) or self._clock.now
        self.first = now if self.first is None else self.first
        self.count, self.last = self.count + (self.first is not None), now

    def rate(self):
        """Messages per simulated second, None below two."""
        if self.count < 2 or self.last <= self.first:
            return None
        return (self.count - 1) / (self.last - self.first)


@functools.lru_cache(maxsize=None)
def has_header(kind):
    """Whether a type of messages is known here and begins with a header."""
    message_class = roslib.message.get_message_class(kind)
    return message_class is not None and message_class._has_header


def stamp_of(message):
    """Stamp [s] of an AnyMsg; None where its type has no header or is not known here."""
    if not has_header(message._connection_header["type"]):
        return None
    seconds, nanoseconds = struct.unpack_from("<II", message._buff, 4)  # after header.seq
    return seconds + 1e-9 * nanoseconds


def call(service, kind, *arguments):
    """Calls a service; None where it does not answer."""
    try:
        rospy.wait_for_service(service, 5.0)
        return rospy.ServiceProxy(service, kind)(*arguments)
    except (rospy.ROSException, rospy.ServiceException):
        return None


def find_simulator():
    """Name of the simulator's node, which launch files may put into a namespace, or None."""
    try:
        services = {name for name, _ in rospy.get_master().getSystemState()[2][2]}
    except OSError:  # the launch has ended, and its master with it
        return None
    for name in sorted(services):
        node, _, service = name.rpartition("/")
        if service == "describe" and f"{node}/spawn_urdf_model" in services:
            return node
    return None


def wait(launch, limit, look):
    """Looks until something is seen, the launch has ended, or a wall time [s] has passed.

    Returns:
        What was seen; None: nothing.
    """
    deadline = time.monotonic() + limit
    while time.monotonic() < deadline and launch.poll() is None:
        seen = look()
        if seen:
            return seen
        time.sleep(0.2)
    return None


def has_master():
    """Whether the master answers."""
    try:
        return bool(rospy.get_master().getPid())
    except OSError:
        return False


def describe(simulator):
    """The simulator's own description of what is in the world, or None."""
    answer = call(f"{simulator}/describe", Trigger)
    return json.loads(answer.message) if answer is not None and answer.success else None


def times_moved(simulator):
    """How often services have placed or pushed each model."""
    models = (describe(simulator) or {}).get("models", ())
    return {model["name"]: model["times_moved"] for model in models}


def is_spawning():
    """Whether a spawn_model of this master's launch still runs."""
    port = f":{urlsplit(os.environ['ROS_MASTER_URI']).port}"
    return any(
        "spawn_model" in map(os.path.basename, procfs.arguments(pid)[:3])
        and port in procfs.environment(pid).get("ROS_MASTER_URI", "")
        for pid in procfs.pids()
    )


def wait_for_models(launch, simulator):
    """Waits until no more models come; returns the last description."""
    description, since, deadline = None, time.monotonic(), time.monotonic() + SPAWN_LIMIT
    while time.monotonic() < deadline and launch.poll() is None:
        now = describe(simulator)
        if (now is not None and now != description) or is_spawning():
            description, since = now, time.monotonic()
        moving = [model for model in (description or {}).get("models", ()) if not model["static"]]
        if description is not None and time.monotonic() - since > SETTLED * (1 if moving else 3):
            break
        time.sleep(0.5)
    return description


def state_of(simulator, model):
    """Position [m], orientation (x, y, z, w) and speed [m/s] of a model, or None."""
    answer = call(f"{simulator}/get_model_state", GetModelState, model, "world")
    if answer is None or not answer.success:
        return None
    p, q, v = answer.pose.position, answer.pose.orientation, answer.twist.linear
    return {
        "position": (p.x, p.y, p.z),
        "orientation": (q.x, q.y, q.z, q.w),
        "speed": (v.x**2 + v.y**2 + v.z**2) ** 0.5,
    }


def unpause(simulator):
    """Lets a world that starts paused go on; returns whether it was paused."""
    answer = call(f"{simulator}/get_physics_properties", GetPhysicsProperties)
    paused = answer is not None and answer.pause
    if paused:
        call(f"{simulator}/unpause_physics", Empty)
        time.sleep(SETTLED)
    return paused


def controllers_of(namespace):
    """(name, type, state) of the controllers in a namespace, None where nobody answers."""
    answer = call(f"{namespace}/controller_manager/list_controllers", ListControllers)
    return None if answer is None else [(c.name, c.type, c.state) for c in answer.controller]


class Drivers:
    """Which nodes command a model: those that send it anything but zeros.

    Args:
        topics: Those that the model's plugins and controllers subscribe to.
    """

    def __init__(self, topics):
        self.names = set()
        self._subscribers = [rospy.Subscriber(topic, rospy.AnyMsg, self._take) for topic in topics]

    def _take(self, message):
        if any(message._buff):
            self.names.add(message._connection_header["callerid"])


def drives(node, models):
    """Whether a node that has died commanded a model, or its script would have."""
    name = f"/{node['name']}"
    if any(name in model.get("driven_by", ()) for model in models):
        return True
    topics = {topic.rpartition("/")[2] for model in models for topic in model.get("commands", ())}
    for path in node.pop("paths"):
        text = pathlib.Path(path).read_text(encoding="utf-8", errors="replace")
        relayed = re.search(r"^python_script = '(.+)'$", text, re.MULTILINE)  # catkin's wrapper
        if relayed and os.path.isfile(relayed[1]):
            text = pathlib.Path(relayed[1]).read_text(encoding="utf-8", errors="replace")
        if "Publisher(" in text and any(re.search(rf"\b{topic}\b", text) for topic in topics):
            return True
    return False


def wait_for_first(launch, sensors, counters):
    """Waits until each sensor has sent something: images start with their first subscriber."""
    begin = time.monotonic()
    while launch.poll() is None:
        silent = [sensor for sensor in sensors if not counters[sensor["topic"]].count]
        limit = CAMERA_LIMIT if all(sensor["is_camera"] for sensor in silent) else FIRST_LIMIT
        if not silent or time.monotonic() > begin + limit:
            return
        time.sleep(0.1)


class Replay:
    """Records what happens in the world while it is watched, with a low priority.

    With that of the others where PADDOCK_NICENESS is 0: beside busy tests it would come too late.

    Args:
        path: Of the HTML file.
        title: Of its page.
    """

    def __init__(self, path, title):
        self._path, self._title, self._process = path, title, None

    def start(self, simulator):
        """Starts recording.

        Args:
            simulator: Name of the simulator's node.
        """
        nice = () if os.environ.get("PADDOCK_NICENESS") == "0" else ("nice", "-n", "10")
        title = self._title.replace(":=", "=")  # rospy refuses a second := in an argument
        self._process = subprocess.Popen(
            [
                *(*nice, "rosrun", "bullet_web", "record"),
                *(f"_out:={self._path}", f"_title:={title}", f"_rate:={REPLAY_RATE}"),
                *(f"_simulator:={simulator}", f"__name:={REPLAY}"),
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def wait_for_first(self, launch):
        """Waits until it has a frame; returns at once if it has ended, which costs the replay."""
        name, process = f"/{REPLAY}/recording", self._process
        wait(launch, REPLAY_LIMIT, lambda: process.poll() is not None or rospy.get_param(name, 0))

    def end(self):
        """Writes it, if it was started; a file that cannot be written is none."""
        if self._process is not None:
            processes.stop([(self._process, False, REPLAY_LIMIT)])


def observe(launch, seconds, replay):
    """Watches the running launch; returns what goes into the result.

    The seconds begin when every sensor has sent its first message, or after FIRST_LIMIT or
    CAMERA_LIMIT, and the replay has its first frame.
    """
    simulator = wait(launch, START_LIMIT, find_simulator)
    if simulator is None:
        return {"simulator": False}
    replay.start(simulator)
    clock = ClockMonitor()
    report = wait_for_models(launch, simulator)
    if report is None:
        return {"simulator": False}
    report["was_paused"] = unpause(simulator)
    moving = [model for model in report["models"] if not model["static"]]
    drivers = {model["name"]: Drivers(model["commands"]) for model in moving}
    sensors = [sensor for model in report["models"] for sensor in model["sensors"]]
    counters = {sensor["topic"]: Counter(sensor["topic"], clock) for sensor in sensors}
    wait_for_first(launch, sensors, counters)
    replay.wait_for_first(launch)
    before = {model["name"]: state_of(simulator, model["name"]) for model in moving}
    placed = times_moved(simulator)
    start, begin = clock.now, time.monotonic()
    while time.monotonic() - begin < seconds and launch.poll() is None:
        time.sleep(0.1)
    elapsed = time.monotonic() - begin
    moved = {name for name, times in times_moved(simulator).items() if times > placed.get(name, 0)}
    for sensor in sensors:
        counter = counters[sensor["topic"]]
        sensor.update(count=counter.count, measured=counter.rate())
    for model in moving:
        model.update(before=before[model["name"]], after=state_of(simulator, model["name"]))
        model["driven_by"] = sorted(drivers[model["name"]].names)
        if model["name"] in moved:
            model["driven_by"].append(BY_SERVICES)
        if model["control_namespace"] is not None:
            model["controllers"] = controllers_of(model["control_namespace"])
    advanced = None if start is None or clock.now is None else clock.now - start
    return dict(
        report,
        simulator=True,
        simulated=advanced,
        real_time_factor=None if advanced is None else advanced / elapsed,
        ended=launch.poll() is not None,
    )


def main(result, log, port, seconds, *launch_words):
    """Runs it all; the result is written even if the launch fails, or Ctrl-C ends the check."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    outputs = os.path.join(os.path.dirname(result), "nodes")
    os.makedirs(outputs)
    with open(log, "w", encoding="utf-8") as stream:
        launch = subprocess.Popen(
            [sys.executable, ROSLAUNCH, "-p", port, *launch_words],
            env={**os.environ, OUTPUTS: outputs},
            stdout=stream,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )
    report = {"simulator": False}
    path = os.path.join(os.path.dirname(result), "replay.html")
    replay = Replay(path, " ".join(launch_words))
    try:
        wait(launch, START_LIMIT, has_master)
        if launch.poll() is None:
            rospy.init_node("paddock_check", anonymous=True, disable_signals=True)
            report = observe(launch, float(seconds), replay)
            rospy.signal_shutdown("the check is over")
    finally:
        replay.end()
        processes.stop([(launch, False, STOP_LIMIT)])  # its supervisor ends what it leaves
        with open(result, "w", encoding="utf-8") as stream:
            rospack = rospkg.RosPack()
            packages = {name: rospack.get_path(name) for name in rospack.list()}
            report.update(
                check_log.read(log, outputs, packages.__contains__), exit_status=launch.returncode
            )
            check_log.append_nodes(log, outputs)
            for node in report["died"]:
                node["drives"] = drives(node, report.get("models", ()))
            report["builders"] = check_sources.builders(report)
            report["moved"] = check_log.moved(texts_of(report), packages)
            json.dump(report, stream)
    return 0


def texts_of(report):
    """Sentences that may name files."""
    parts = [report, *report.get("models", ())]
    texts = [text for part in parts for key in ("warnings", "lost") for text in part.get(key, ())]
    return [report.get("refused") or "", *(node["why"] for node in report["died"]), *texts]


if __name__ == "__main__":
    try:
        sys.exit(main(*sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)
