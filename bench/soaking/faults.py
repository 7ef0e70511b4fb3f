"""The faults: what each does to a session, and undoes. FAULTS is the table of them.

A fault is a function of a Session and a random.Random that returns what it did, a line.
"""

import random
import signal
import subprocess
import sys
import time

from figures import BenchError
from usage import procfs

from soaking.limits import CompetingLoad

END_LIMIT = 30.0  # [s] for the simulator to end when its core has died; more under other load
NODES = ("control", "teleop", "drive", "odom_tf", "robot_state_publisher")
STOPPABLE = (*NODES, "bridge", "relay", "render_worker", "rosout", "roslaunch")
SLOW = """
import os, sys, time, rospy
rospy.init_node("slow", anonymous=True, disable_rosout=True, disable_signals=True)
for topic in sys.argv[1:]:
    rospy.Subscriber(topic, rospy.AnyMsg, lambda _: time.sleep(0.5), queue_size=1)
print("ready", flush=True)
time.sleep(60)
"""
LOUD = ("/camera/image", "/clock", "/racecar/joint_states", "/scan", "/gazebo/link_states")


class Failure(Exception):
    """A guarantee was not kept; the text says which."""


def ask(session, **question):
    """Makes the operator do something; returns its answer.

    Raises:
        Failure: It could not, or it hung.
    """
    try:
        return session.operator.request(**question)
    except BenchError as error:
        raise Failure(str(error)) from None


def rounds(table, seed):
    """An endless order of faults: each round has all of them, as often as the table says.

    Args:
        table: dict of fault -> how often.
        seed: Number; the same one gives the same order.

    Yields:
        (fault, seed of its own).
    """
    rng = random.Random(seed)
    while True:
        one_round = [fault for fault, count in table.items() for _ in range(count)]
        rng.shuffle(one_round)
        for fault in one_round:
            yield fault, rng.random()


def kill_simulator(session, rng):
    """SIGKILL of the simulator: roslaunch ends everything."""
    before = time.monotonic()
    session.send("bridge", signal.SIGKILL)
    return _shut_down(session, before, "the simulator killed", "REQUIRED process")


def kill_roslaunch(session, rng):
    """SIGKILL of roslaunch: the simulator and what it started have to notice."""
    before = time.monotonic()
    number = rng.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT))
    session.send("roslaunch", number)
    said = "roslaunch has left" if number == signal.SIGKILL else "killing on exit"
    return _shut_down(session, before, f"roslaunch got {number.name}", said)


def kill_master(session, rng):
    """SIGKILL of the ROS master, which may be started again at once."""
    before = time.monotonic()
    session.send("roscore", signal.SIGKILL)
    session.send("rosmaster", signal.SIGKILL)
    session.send("rosout", signal.SIGKILL)
    again = rng.random() < 0.5
    if again:
        time.sleep(rng.uniform(0.0, 3.0))
        session.start_core()
    words = "the ROS master killed" + (" and started again" if again else "")
    return _shut_down(session, before, words, "ROS master")


def _shut_down(session, before, words, said):
    """Waits for the session's end; a zombie, or an end without a reason, is a failure."""
    load = CompetingLoad()
    while session.pid("bridge") is not None:
        load.sample(session.pids())
        seconds = time.monotonic() - before
        if seconds > END_LIMIT * load.slowdown():
            raise Failure(f"{words}; after {seconds:.0f} s the simulator is still there")
        time.sleep(0.05)
    found, _ = session.wait_ended(begin=before)
    if found.left:
        raise Failure(f"{words}; after {found.seconds:.0f} s still there: {found.left}")
    status = session.launch.wait(END_LIMIT)
    if said not in session.output():
        raise Failure(f"{words}; the log does not say '{said}'")
    return f"{words}: all ended within {found.seconds:.1f} s, status {status}"


# Fault that ends a session -> how often it comes in a round.
SHUTDOWNS = {kill_simulator: 1, kill_roslaunch: 1, kill_master: 1}


def kill_node(session, rng):
    """SIGKILL of a node beside the simulator, which starts again."""
    role = rng.choice(NODES)
    recipe = session.recipe(role)
    if recipe is None:
        raise Failure(f"{role} does not run")
    session.send(role, signal.SIGKILL)
    time.sleep(rng.uniform(0.2, 2.0))
    session.start_again(recipe)
    return f"{role} killed and started again"


def kill_helper(session, rng):
    """SIGKILL of the relay or the render worker, which the simulator has to tolerate."""
    role = rng.choice(("relay", "render_worker", "render_worker"))
    pids = session.send(role, signal.SIGKILL)
    return f"{role} {'killed' if pids else 'was not there to be killed'}"


def stop_process(session, rng):
    """SIGSTOP of any process, SIGCONT after some seconds."""
    role, seconds = rng.choice(STOPPABLE), rng.uniform(0.5, 6.0)
    session.send(role, signal.SIGSTOP)
    time.sleep(seconds)
    session.send(role, signal.SIGCONT)
    return f"{role} stopped for {seconds:.1f} s"


def stop_master(session, rng):
    """SIGSTOP of the ROS master for ten seconds."""
    session.send("rosmaster", signal.SIGSTOP)
    session.send("roscore", signal.SIGSTOP)
    time.sleep(10.0)
    session.send("roscore", signal.SIGCONT)
    session.send("rosmaster", signal.SIGCONT)
    return "the ROS master stopped for 10 s"


def dead_subscriber(session, rng):
    """A subscriber that is killed, one that is stopped and one that is slow."""
    number = rng.choice((signal.SIGKILL, signal.SIGSTOP, signal.SIGTERM))
    topics = rng.sample(LOUD, 3)
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW, *topics],
        env=session.environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    with process:
        process.stdout.readline()
        time.sleep(rng.uniform(1.0, 4.0))
        process.send_signal(number)
        time.sleep(rng.uniform(0.5, 4.0))
        process.kill()
    return f"slow subscriber of {', '.join(topics)}, then {number.name}"


def spawn_delete(session, rng):
    """Models that come and go."""
    count = rng.randint(1, 12)
    failed = ask(session, what="balls", count=count)["failed"]
    if failed:
        raise Failure(f"spawning and deleting {count} balls: {failed[0]}")
    return f"{count} balls spawned and deleted"


def reset(session, rng):
    """A reset, with time or without."""
    service = rng.choice(("restart", "reset_world"))
    ask(session, what="empty", service=service)
    return service


def pause(session, rng):
    """A pause with steps in it."""
    ask(session, what="empty", service="pause_physics")
    count = rng.randint(1, 400)
    answer = ask(session, what="step", count=count)
    time.sleep(rng.uniform(0.0, 3.0))
    ask(session, what="empty", service="unpause_physics")
    if not answer["success"]:
        raise Failure(f"{count} steps while paused: {answer['text']}")
    return f"paused, {count} steps"


def fuzzed_calls(session, rng):
    """Service calls with fuzzed values."""
    count = rng.randint(20, 100)
    slowest = ask(session, what="fuzzed_calls", seed=rng.random(), count=count)["slowest"]
    ask(session, what="empty", service="restart")
    ask(session, what="clean")
    return f"{count} fuzzed calls, the slowest took {slowest:.2f} s"


def fuzzed_commands(session, rng):
    """Commands with fuzzed values."""
    topics = ask(session, what="fuzzed_commands", seed=rng.random(), count=200)["topics"]
    ask(session, what="empty", service="restart")
    return f"200 fuzzed messages on {', '.join(topics)}"


def noise(session, rng):
    """Random bytes at the simulator's ports."""
    ask(session, what="noise", seed=rng.random(), count=30)
    return "random bytes, 30 connections"


def set_real_time_factor(session, rng):
    """Another real time factor for some seconds."""
    factor = rng.choice((0.0, 0.1, 0.5, 2.0, 10.0))
    answer = ask(session, what="real_time_factor", factor=factor)
    if not answer["success"]:
        raise Failure(f"real time factor {factor}: {answer['text']}")
    time.sleep(rng.uniform(1.0, 5.0))
    ask(session, what="real_time_factor", factor=1.0)
    return f"real time factor {factor:g}"


def freeze(session, rng):
    """SIGSTOP of everything at once, as when the machine sleeps."""
    seconds, pids = rng.uniform(3.0, 15.0), session.pids()
    for number in (signal.SIGSTOP, signal.SIGCONT):
        for pid in pids:
            procfs.send(pid, number)
        time.sleep(seconds if number == signal.SIGSTOP else 0.0)
    return f"everything stopped for {seconds:.1f} s"


def page(session, rng):
    """A page looks at the world, and its node is killed."""
    seconds = rng.uniform(0.1, 5.0)
    views = ask(session, what="page", seconds=seconds)["views"]
    return f"a page for {seconds:.1f} s, {views} views, then SIGKILL of its node"


# Fault -> how often it comes in a round. Those that end a session are in SHUTDOWNS.
FAULTS = {
    kill_node: 4,
    kill_helper: 2,
    stop_process: 4,
    stop_master: 1,
    dead_subscriber: 3,
    spawn_delete: 4,
    reset: 3,
    pause: 3,
    fuzzed_calls: 4,
    fuzzed_commands: 3,
    noise: 2,
    set_real_time_factor: 3,
    page: 2,
    freeze: 1,
}
