"""For tests: processes, masters, nodes, and assertions about how nodes shut down."""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import Any, TypeVar
from unittest import TestCase

from paddock_common.master import ERRORS, proxy
from paddock_common.process import free_port

POLL_PERIOD = 0.005  # [s]
T = TypeVar("T")
_servers = itertools.count()  # number of X servers that this process has started


class _Page(BaseHTTPRequestHandler):
    def do_POST(self) -> None:
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(200)
        self.end_headers()
        self.wfile.write(b"<html><p>hello<br></html>")

    def log_message(self, *_: object) -> None:
        pass


@contextlib.contextmanager
def web_page() -> Iterator[str]:
    """Yields the address of a server that responds to XML-RPC calls with a web page."""
    with HTTPServer(("127.0.0.1", 0), _Page) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


def start_x_server(size: str) -> tuple[subprocess.Popen[bytes], str]:
    """Starts an Xvfb on a display that no other process of this machine uses.

    Servers that choose a display number themselves (-displayfd alone) remove each other's sockets
    when they start at the same time.

    Args:
        size: WIDTHxHEIGHT [px].

    Returns:
        Its process, the name of the display.
    """
    display = f":{1000 + (8 * os.getpid() + next(_servers)) % 50000}"
    screen = ("-screen", "0", f"{size}x24")
    reader, writer = os.pipe()
    process = subprocess.Popen(
        # Without -noreset it restarts when its last client disconnects, and refuses the next one.
        ["Xvfb", display, "-displayfd", str(writer), *screen, "-nolisten", "tcp", "-noreset"],
        pass_fds=[writer],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(writer)
    with os.fdopen(reader) as stream:
        number = stream.readline().strip()
    assert number, "Xvfb did not start"
    return process, f":{number}"


def enter_class_context(case: type[TestCase], context: contextlib.AbstractContextManager[T]) -> T:
    """Enters a context for all tests of a class, as enterClassContext() of Python 3.11 does."""
    entered = context.__enter__()
    case.addClassCleanup(context.__exit__, None, None, None)
    return entered


def is_running(pid: int) -> bool:
    """Returns whether a process runs; a zombie does not."""
    return _state(f"/proc/{pid}/stat") not in ("", "Z")


def is_asleep(pid: int) -> bool:
    """Returns whether no thread of a process runs or waits for a processor or a disk; True where it
    has ended, a zombie too, or is stopped."""
    try:
        threads = os.listdir(f"/proc/{pid}/task")
    except OSError:
        return True
    return not any(_state(f"/proc/{pid}/task/{thread}/stat") in ("R", "D") for thread in threads)


def _state(path: str) -> str:
    """Returns the state letter in the stat file of a process or thread; "" where it has ended."""
    try:
        with open(path, encoding="ascii", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0]
    except OSError:
        return ""


def wait_ended(pid: int, limit: float) -> None:
    """Waits until a process has exited.

    Args:
        limit: Longest wait in wall time [s].

    Raises:
        AssertionError: It still runs.
    """
    deadline = time.monotonic() + limit
    while is_running(pid):
        assert time.monotonic() < deadline, f"process {pid} has not ended within {limit:g} s"
        time.sleep(POLL_PERIOD)


def pid_from_killed(code: str) -> int:
    """Runs Python code that prints a process id, kills it, and returns that id.

    Args:
        code: Python source; it has to continue after it has printed.
    """
    parent = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)),
    )
    with parent:
        assert parent.stdout is not None
        pid = int(parent.stdout.readline())
        parent.kill()
    return pid


LIMIT = 120.0  # longest wait for what takes no time on an idle machine [s]
CALL_LIMIT = 10.0  # of a call by XML-RPC [s]
NOISE = ("Traceback", "bad callback", "closed topic", "Exception", "Error")
FLOOD = """
import itertools, sys, time
import roslib.message, rospy
from paddock_common import nodes
def filled(message_type):
    message = message_type()
    for path in ("pose.pose.orientation", "pose.orientation", "orientation"):
        part = message
        for name in path.split("."):
            part = getattr(part, name, None)
        if part is not None:
            part.w = 1.0
    if hasattr(message, "header"):
        message.header.frame_id = "odom"
    for name in sys.argv[2:]:
        path, _, value = name.partition("=")
        if hasattr(message, path):
            setattr(message, path, eval(value))
    return message
nodes.init_node("flood", disable_signals=True)
topics = dict(item.split("=") for item in sys.argv[1].split(","))
types = {topic: roslib.message.get_message_class(name) for topic, name in topics.items()}
publishers = [(rospy.Publisher(t, k, queue_size=5), filled(k)) for t, k in types.items()]
for number in itertools.count(1):
    for publisher, message in publishers:
        if hasattr(message, "header"):
            message.header.stamp = rospy.Time(100 + number // 1000, number % 1000 * 1000000)
        publisher.publish(message)
    time.sleep(0.004)
"""
# Publishers are closed some time before subscribers, and both before rospy is shut down.
SLOW_CLOSE = """
import time
import rospy.topics
def slow(cls, name, wait):
    upstream = getattr(cls, name)
    def then_wait(self):
        upstream(self)
        time.sleep(wait)
    setattr(cls, name, then_wait)
slow(rospy.topics._PublisherImpl, "close", 0.1)
slow(rospy.topics._TopicManager, "close_all", 0.3)
"""


@contextlib.contextmanager
def ros_master() -> Iterator[dict[str, str]]:
    """Runs a ROS master on a free port of this machine's loopback.

    Yields:
        Environment variables of nodes that use it.
    """
    port = free_port()
    environment = dict(
        os.environ,
        ROS_MASTER_URI=f"http://127.0.0.1:{port}",
        ROS_IP="127.0.0.1",
        PYTHONUNBUFFERED="1",
    )
    environment.pop("ROS_HOSTNAME", None)
    master = subprocess.Popen(
        ["rosmaster", "--core", "-p", str(port)],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        wait_for(lambda: call(environment["ROS_MASTER_URI"], "getPid"), "the master")
        yield environment
    finally:
        master.kill()
        master.wait()


def wait_for(condition: Callable[[], T], label: str, limit: float = LIMIT) -> T:
    """Waits until a condition is true and returns its value.

    Args:
        label: Name of the condition in the error message.
        limit: Longest wait in wall time [s].

    Raises:
        AssertionError: It did not become true in time.
    """
    deadline = time.monotonic() + limit
    while not (value := condition()):
        assert time.monotonic() < deadline, f"{label}: not within {limit:g} s"
        time.sleep(0.02)
    return value


def call(uri: str, name: str, *arguments: Any) -> Any:
    """Returns the result of an XML-RPC method of a master or a node, or None without a response."""
    try:
        with proxy(uri, CALL_LIMIT) as server:
            code, _, value = getattr(server, name)("/test", *arguments)
    except ERRORS:
        return None
    return value if code == 1 else None


def connected(environment: dict[str, str], node: str) -> set[str] | None:
    """Returns the topics that a node receives, or None while there is no such node.

    Args:
        environment: As yielded by ros_master.
        node: Its name with a slash.
    """
    uri = call(environment["ROS_MASTER_URI"], "lookupNode", node)
    info = call(uri, "getBusInfo") if uri else None
    return None if info is None else {row[4] for row in info if row[2] == "i"}


@contextlib.contextmanager
def flood(environment: dict[str, str], topics: dict[str, str], *values: str) -> Iterator[None]:
    """Publishes on topics some hundred times a second.

    Args:
        environment: As yielded by ros_master.
        topics: Topic -> message type.
        values: "field=expression" of messages that have the field.
    """
    named = ",".join(f"{topic}={name}" for topic, name in topics.items())
    process = subprocess.Popen([sys.executable, "-c", FLOOD, named, *values], env=environment)
    try:
        wait_for(
            lambda: call(environment["ROS_MASTER_URI"], "lookupNode", "/flood"), "the flood's node"
        )
        yield
    finally:
        process.kill()
        process.wait()


@contextlib.contextmanager
def running(
    environment: dict[str, str], command: list[str], **options: Any
) -> Iterator[subprocess.Popen[str]]:
    """Runs a node; kills it at the end if it still runs.

    Args:
        environment: As yielded by ros_master.
    """
    process = subprocess.Popen(
        command,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        **options,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def slow_close(folder: Path, environment: dict[str, str]) -> dict[str, str]:
    """Returns the environment of nodes with a delay between closing topics and their shutdown.

    Args:
        environment: As yielded by ros_master.
    """
    (folder / "sitecustomize.py").write_text(SLOW_CLOSE)
    return with_path(environment, folder)


def with_path(environment: dict[str, str], folder: Path) -> dict[str, str]:
    """Returns the environment of Python processes that import modules from a folder first."""
    paths = [str(folder), *filter(None, [environment.get("PYTHONPATH")])]
    return dict(environment, PYTHONPATH=os.pathsep.join(paths))


def executable(package: str, name: str) -> str:
    """Returns the path of a node's executable, without the delay of rosrun (0.3 s)."""
    import roslib.packages

    [path, *_] = roslib.packages.find_node(package, name)
    return path


def assert_clean_exit(
    environment: dict[str, str],
    node: str,
    command: list[str],
    topics: Iterable[str],
    number: int = signal.SIGINT,
    **options: Any,
) -> None:
    """Stops a node during a flood of messages: it must print no error.

    Args:
        environment: As yielded by ros_master, in which the flood runs.
        node: Name of the node with a slash.
        command: Program and arguments that start it.
        topics: Topics that it has to receive before it is stopped.

    Raises:
        AssertionError: It prints an error, or does not exit.
    """

    def is_receiving() -> bool:
        received = connected(environment, node)
        return process.poll() is not None or (received is not None and received >= set(topics))

    with running(environment, command, **options) as process:
        wait_for(is_receiving, f"connections of {node}")
        time.sleep(0.2)  # some messages
        process.send_signal(number)
        output, _ = process.communicate(timeout=LIMIT)
    noise = [line for line in output.splitlines() if any(text in line for text in NOISE)]
    assert not noise, f"{node}, stopped by {signal.Signals(number).name}, printed:\n{output}"
