"""Starts a launch file, watches what comes up for a while, and writes it as JSON.

    observer.py RESULT LOG PORT SECONDS PACKAGE FILE [ARG:=VALUE ...]

Runs with the workspace active and ROS_MASTER_URI set to the port; ./run check starts it.
"""

import contextlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
from urllib.parse import urlsplit

import launch_log
import rospy
import sources
from controller_manager_msgs.srv import ListControllers
from gazebo_msgs.srv import GetModelState, GetPhysicsProperties
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Empty, Trigger

START_LIMIT = 60.0  # wall time until the simulator answers [s]
SETTLED = 4.0  # wall time without a new model after which spawning is over [s]
SPAWN_LIMIT = 40.0  # wall time for spawning [s]
FIRST_LIMIT = 20.0  # wall time for the first message of each sensor [s]
STOP_LIMIT = 20.0  # wall time for the launch to end [s]


class ClockWatch:
    """Simulated time as /clock has it; None before the first message."""

    def __init__(self):
        self.now = None
        self._subscriber = rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=1)

    def _on_clock(self, message):
        self.now = message.clock.to_sec()


class Watch:
    """Counts the messages of one topic and the simulated time between first and last."""

    def __init__(self, topic, clock):
        self.count, self.first, self.last, self._clock = 0, None, None, clock
        self._subscriber = rospy.Subscriber(topic, rospy.AnyMsg, self._on_message, queue_size=100)

    def _on_message(self, _message):
        now = self._clock.now
        self.first = now if self.first is None else self.first
        self.count, self.last = self.count + (self.first is not None), now

    def rate(self):
        """Messages per simulated second, None below two."""
        if self.count < 2 or self.last <= self.first:
            return None
        return (self.count - 1) / (self.last - self.first)


def call(service, kind, *arguments):
    """Calls a service; None where it does not answer."""
    try:
        rospy.wait_for_service(service, 5.0)
        return rospy.ServiceProxy(service, kind)(*arguments)
    except (rospy.ROSException, rospy.ServiceException):
        return None


def find_simulator():
    """Name of the simulator's node, which launch files may put into a namespace, or None."""
    services = {name for name, _ in rospy.get_master().getSystemState()[2][2]}
    for name in sorted(services):
        node, _, service = name.rpartition("/")
        if service == "describe" and f"{node}/spawn_urdf_model" in services:
            return node
    return None


def wait_for_simulator(launch):
    """Waits until the simulator answers; returns its name or None."""
    deadline = time.monotonic() + START_LIMIT
    while time.monotonic() < deadline and launch.poll() is None:
        node = find_simulator()
        if node is not None:
            return node
        time.sleep(0.3)
    return None


def describe(simulator):
    """The simulator's own description of what is in the world, or None."""
    answer = call(f"{simulator}/describe", Trigger)
    return json.loads(answer.message) if answer is not None and answer.success else None


def is_spawning():
    """Whether a spawn_model of this master's launch still runs."""
    port = b":%d" % urlsplit(os.environ["ROS_MASTER_URI"]).port
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended, or is somebody else's
            words = (folder / "cmdline").read_bytes().split(b"\0")
            if any(os.path.basename(word) == b"spawn_model" for word in words[:3]):
                variables = (folder / "environ").read_bytes().split(b"\0")
                if any(v.startswith(b"ROS_MASTER_URI=") and port in v for v in variables):
                    return True
    return False


def wait_for_models(launch, simulator):
    """Waits until no more models come; returns the last description."""
    found, since, deadline = None, time.monotonic(), time.monotonic() + SPAWN_LIMIT
    while time.monotonic() < deadline and launch.poll() is None:
        now = describe(simulator)
        if (now is not None and now != found) or is_spawning():
            found, since = now, time.monotonic()
        moving = [model for model in (found or {}).get("models", ()) if not model["static"]]
        if found is not None and time.monotonic() - since > SETTLED * (1 if moving else 3):
            break
        time.sleep(0.5)
    return found


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


def wait_for_first(launch, watches):
    """Waits until each sensor has sent something: pictures start with their first subscriber."""
    deadline = time.monotonic() + FIRST_LIMIT
    while time.monotonic() < deadline and launch.poll() is None:
        if all(watch.count for watch in watches):
            return
        time.sleep(0.1)


def observe(launch, seconds):
    """Watches the running launch; returns what goes into the result.

    The seconds begin when every sensor has sent its first message, or after FIRST_LIMIT.
    """
    simulator = wait_for_simulator(launch)
    if simulator is None:
        return {"simulator": False}
    clock = ClockWatch()
    found = wait_for_models(launch, simulator)
    if found is None:
        return {"simulator": False}
    found["was_paused"] = unpause(simulator)
    moving = [model for model in found["models"] if not model["static"]]
    sensors = [sensor for model in found["models"] for sensor in model["sensors"]]
    watches = {sensor["topic"]: Watch(sensor["topic"], clock) for sensor in sensors}
    wait_for_first(launch, watches.values())
    before = {model["name"]: state_of(simulator, model["name"]) for model in moving}
    start, begin = clock.now, time.monotonic()
    while time.monotonic() - begin < seconds and launch.poll() is None:
        time.sleep(0.1)
    elapsed = time.monotonic() - begin
    for sensor in sensors:
        watch = watches[sensor["topic"]]
        sensor.update(count=watch.count, measured=watch.rate())
    for model in moving:
        model.update(before=before[model["name"]], after=state_of(simulator, model["name"]))
        if model["control_namespace"] is not None:
            model["controllers"] = controllers_of(model["control_namespace"])
    advanced = None if start is None or clock.now is None else clock.now - start
    return dict(
        found,
        simulator=True,
        simulated=advanced,
        real_time_factor=None if advanced is None else advanced / elapsed,
        ended=launch.poll() is not None,
    )


def main(result, log, port, seconds, *launch_words):
    """Runs it all; the result is written even if the launch fails."""
    with open(log, "w", encoding="utf-8") as stream:
        launch = subprocess.Popen(
            ["roslaunch", "-p", port, *launch_words],
            stdout=stream,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )
    found = {"simulator": False}
    try:
        deadline = time.monotonic() + START_LIMIT
        while time.monotonic() < deadline and launch.poll() is None:
            try:
                rospy.get_master().getPid()
                break
            except OSError:
                time.sleep(0.2)
        if launch.poll() is None:
            rospy.init_node("paddock_check", anonymous=True, disable_signals=True)
            found = observe(launch, float(seconds))
            rospy.signal_shutdown("the check is over")
    finally:
        stop(launch)
        with open(result, "w", encoding="utf-8") as stream:
            said = launch_log.read(log)
            found.update(said, exit_status=launch.returncode)
            found["builders"] = sources.builders(found)
            json.dump(found, stream)
    return 0


def stop(launch):
    """Ends the launch and what it started."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        try:
            if number == signal.SIGINT:
                launch.send_signal(number)
            else:
                os.killpg(launch.pid, number)
            launch.wait(STOP_LIMIT)
            return
        except (ProcessLookupError, subprocess.TimeoutExpired):
            continue


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
