"""Signals that request a stop shut a node down at any time; a master's request, if it is for it."""

import signal
import subprocess
import sys
import threading
import time

import pytest
from paddock_common.master import proxy
from paddock_common.process import StopRequest
from testing import call, ros_master, running, wait_for

LIMIT = 60.0  # [s]
# The main thread holds a lock that the shutdown needs, as in a call of the master.
LOCKED = """
import threading, time
import rospy
from paddock_common import nodes
nodes.handle_signals()
lock = threading.Lock()
def end():
    with lock:
        print("unregistered", flush=True)
rospy.on_shutdown(end)
with lock:
    print("ready", flush=True)
    time.sleep(1.0)
while not rospy.is_shutdown():
    time.sleep(0.01)
"""
# The main thread finishes before the shutdown does.
SLOW = """
import time
import rospy
import rospy.core
from paddock_common import nodes
nodes.handle_signals()
def end(reason):
    time.sleep(0.5)
    print("unregistered", flush=True)
rospy.core.add_shutdown_hook(end)
print("ready", flush=True)
while not rospy.is_shutdown():
    time.sleep(0.01)
"""
# There is no master: the node is never initialized.
STARTING = """
from paddock_common import nodes
print("ready", flush=True)
nodes.init_interruptible("n")
"""


def test_a_stop_request_stores_the_first_signal_and_restores_the_handlers():
    numbers, calls = (signal.SIGUSR1, signal.SIGUSR2), []
    before = [signal.getsignal(number) for number in numbers]
    with StopRequest(numbers, lambda: calls.append(stop.signal)) as stop:
        assert not stop.requested() and stop.signal is None
        for number in numbers[::-1]:
            signal.raise_signal(number)
        assert stop.requested() and stop.signal == signal.SIGUSR2
        assert calls == [signal.SIGUSR2] * 2
    assert [signal.getsignal(number) for number in numbers] == before
    assert stop.requested()


def test_a_stop_request_needs_no_ros():
    script = "import sys, paddock_common.process\nassert 'rospy' not in sys.modules"
    subprocess.run([sys.executable, "-c", script], check=True, timeout=LIMIT)


def stopped(script, number, wait=0.0):
    """Returns the output of a script that gets a signal when it is ready, and its exit status."""
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(wait)
        process.send_signal(number)
        process.send_signal(number)  # a second one has no effect
        output, _ = process.communicate(timeout=LIMIT)
    finally:
        process.kill()
        process.wait()
    return output, process.returncode


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("script", [LOCKED, SLOW])
def test_the_shutdown_is_complete(script, number):
    assert stopped(script, number) == ("unregistered\n", 0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_node_that_is_not_initialized_yet_exits_immediately(monkeypatch, number):
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9")  # no server
    assert stopped(STARTING, number, wait=0.5)[1] == -number


def test_without_a_signal_there_is_no_wait():
    script = "from paddock_common import nodes\nnodes.handle_signals()\nprint('ends')\n"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=LIMIT
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "ends\n", "")


# The main thread is in a function of C that no signal ends.
BUSY = """
import ctypes
from paddock_common import nodes
nodes.handle_signals()
nodes.end_at_latest(0.2, lambda: 5)
lock, mutex = ctypes.CDLL(None).pthread_mutex_lock, ctypes.create_string_buffer(64)
lock(mutex)
print("ready", flush=True)
lock(mutex)
"""


def test_a_node_ends_whatever_its_main_thread_does():
    """A simulator that read a large world ended when it had read it."""
    assert stopped(BUSY, signal.SIGINT) == ("", 5)


NODE = """
import rospy
from paddock_common import nodes
nodes.init_interruptible("one")
print("ready", flush=True)
rospy.spin()
"""


def test_a_master_shuts_down_only_the_node_that_it_means():
    """A node died, and another has its port now when a new one of its name registers."""

    def register_as(name, address):
        with proxy(master, LIMIT) as server:
            assert server.registerPublisher(name, "/t", "std_msgs/String", address)[0] == 1

    with ros_master() as environment, running(environment, [sys.executable, "-c", NODE]) as node:
        assert node.stdout.readline() == "ready\n"
        master = environment["ROS_MASTER_URI"]
        address = call(master, "lookupNode", "/one")
        register_as("/dead", address)
        register_as("/dead", "http://127.0.0.1:9")  # the master sends the first address a request
        wait_for(lambda: call(address, "getPid"), "a response")
        time.sleep(0.5)
        assert node.poll() is None and call(address, "getPid")
        register_as("/one", "http://127.0.0.1:9")
        assert node.wait(LIMIT) == 0
        assert node.stdout.read().count("shutdown request") == 1


# A thread is again and again within OpenCV: Python's own end aborts such a process.
WITHIN = """
import atexit, threading, time
import cv2, numpy as np
import rospy
from paddock_common import nodes
def draw():
    image = np.zeros((60, 60, 3), np.uint8)
    while True:
        cv2.medianBlur(image, 5)
threading.Thread(target=draw, daemon=True).start()
"""
LEAVES = WITHIN + "atexit.register(lambda: print('closed'))\ntime.sleep(0.2)\nnodes.leave(3)\n"
# The main thread leaves as soon as a shutdown is requested, before its hooks are over.
HURRIES = """
import threading, time
import rospy
from std_msgs.msg import Empty
from paddock_common import nodes
asked = threading.Event()
nodes.start("one", lambda: rospy.Subscriber("topic", Empty, print))
def ask():
    print("closing", flush=True)
    time.sleep(0.5)
    asked.set()
rospy.on_shutdown(ask)
rospy.core.add_preshutdown_hook(lambda reason: time.sleep(0.5))
rospy.core.add_shutdown_hook(lambda reason: print("closed"))
print("ready", flush=True)
asked.wait()
nodes.leave(0)
"""
RUNS = (
    WITHIN
    + """
def make():
    rospy.on_shutdown(lambda: print("closed"))
    print("ready", flush=True)
nodes.run("one", make)
"""
)


def test_a_process_whose_thread_is_within_opencv_leaves_well():
    done = subprocess.run(
        [sys.executable, "-c", LEAVES], capture_output=True, text=True, timeout=LIMIT, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (3, "closed\n", "")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_node_whose_thread_is_within_opencv_ends_well(number):
    with ros_master() as environment, running(environment, [sys.executable, "-c", RUNS]) as node:
        assert node.stdout.readline() == "ready\n"
        node.send_signal(number)
        assert (node.wait(LIMIT), node.stdout.read()) == (0, "closed\n")


@pytest.mark.parametrize("number", [None, signal.SIGTERM])
def test_a_node_that_the_master_ends_is_unregistered_before_it_leaves(number):
    """Also where a signal comes meanwhile."""
    with ros_master() as environment:
        master = environment["ROS_MASTER_URI"]
        with running(environment, [sys.executable, "-c", HURRIES]) as node:
            assert node.stdout.readline() == "ready\n"
            request = call(master, "lookupNode", "/one"), "shutdown", "user request"  # rosnode kill
            threading.Thread(target=call, args=request).start()
            assert [node.stdout.readline() for _ in range(2)][1] == "closing\n"
            if number is not None:
                node.send_signal(number)
            assert (node.wait(LIMIT), node.stdout.read()) == (0, "closed\n")
        assert "/one" not in str(call(master, "getSystemState"))


def test_a_node_without_output_leaves_well():
    done = subprocess.run(
        ["sh", "-c", '"$0" -c "$1" >&- 2>&-', sys.executable, LEAVES], timeout=LIMIT, check=False
    )
    assert done.returncode == 3
