"""For tests: masters, nodes, ports, and assertions about how nodes end."""

import contextlib
import itertools
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, HTTPServer

from paddock_common.master import ERRORS, proxy

FIRST, LAST = 20000, 32000  # below those that the kernel gives to whoever asks for any port
POLL_PERIOD = 0.005  # [s]
_servers = itertools.count()  # X servers that this process has started


def free_port():
    """Returns an unused TCP port outside the range that the kernel assigns."""
    for port in random.sample(range(FIRST, LAST), 100):
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
    raise OSError(f"no free port found between {FIRST} and {LAST}")


class _Page(BaseHTTPRequestHandler):
    def do_POST(self):
        self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(200)
        self.end_headers()
        self.wfile.write(b"<html><p>hello<br></html>")

    def log_message(self, *_):
        pass


@contextlib.contextmanager
def web_page():
    """Yields the address of a server that gives a web page to whoever calls it by XML-RPC."""
    with HTTPServer(("127.0.0.1", 0), _Page) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


def start_x_server(size):
    """Starts an Xvfb on a display that no other process here has.

    Servers that choose a number themselves (-displayfd alone) take each other's sockets away when
    they start in the same moment.

    Args:
        size: WIDTHxHEIGHT [px].

    Returns:
        Its subprocess.Popen, the display's name.
    """
    display = f":{1000 + (8 * os.getpid() + next(_servers)) % 50000}"
    screen = ("-screen", "0", f"{size}x24")
    reader, writer = os.pipe()
    process = subprocess.Popen(
        # Without -noreset it starts over when its last client leaves, and refuses the next one.
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


def is_running(pid):
    """Returns whether a process runs; one that has ended but was not waited for does not."""
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii", errors="replace") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_ended(pid, limit):
    """Waits until a process has ended.

    Args:
        pid: Process id.
        limit: Longest wait in wall time [s].

    Raises:
        AssertionError: It runs on.
    """
    deadline = time.monotonic() + limit
    while is_running(pid):
        assert time.monotonic() < deadline, f"process {pid} has not ended within {limit:g} s"
        time.sleep(POLL_PERIOD)


def pid_from_killed(code):
    """Runs Python code that prints a process id, kills it, and returns that id.

    Args:
        code: Python source; it has to go on running after it has printed.
    """
    parent = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)),
    )
    with parent:
        pid = int(parent.stdout.readline())
        parent.kill()
    return pid


def stop_session(process, limit):
    """Ends a process and all of its session as Ctrl-C does; kills what does not end.

    Args:
        process: subprocess.Popen with start_new_session=True.
        limit: Wall time from SIGINT to SIGKILL [s].

    Raises:
        AssertionError: It had to be killed.
    """
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
    try:
        process.wait(limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        name = os.path.basename(process.args[0])
        raise AssertionError(f"{name} did not end within {limit:g} s") from None


LIMIT = 120.0  # longest wait for what comes at once on an idle machine [s]
CALL_LIMIT = 10.0  # of a call by XML-RPC [s]
NOISE = ("Traceback", "bad callback", "closed topic", "Exception", "Error")
FLOOD = """
import itertools, sys, time
import roslib.message, rospy
from paddock_common import nodes
def filled(kind):
    message = kind()
    for turned in ("pose.pose.orientation", "pose.orientation", "orientation"):
        part = message
        for name in turned.split("."):
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
kinds = {topic: roslib.message.get_message_class(name) for topic, name in topics.items()}
made = [(rospy.Publisher(t, k, queue_size=5), filled(k)) for t, k in kinds.items()]
for number in itertools.count(1):
    for publisher, message in made:
        if hasattr(message, "header"):
            message.header.stamp = rospy.Time(100 + number // 1000, number % 1000 * 1000000)
        publisher.publish(message)
    time.sleep(0.004)
"""
# Publishers are closed some time before subscribers, and both before rospy is shut down.
SLOW_CLOSE = """
import time
import rospy.topics
def slow(kind, name, wait):
    upstream = getattr(kind, name)
    def then_wait(self):
        upstream(self)
        time.sleep(wait)
    setattr(kind, name, then_wait)
slow(rospy.topics._PublisherImpl, "close", 0.1)
slow(rospy.topics._TopicManager, "close_all", 0.3)
"""


@contextlib.contextmanager
def ros_master():
    """Runs a ROS master on a free port of this machine's loopback.

    Yields:
        Environment of nodes that use it.
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


def wait_for(condition, what, limit=LIMIT):
    """Waits until a condition holds and returns its value.

    Args:
        condition: Function without arguments.
        what: For the error.
        limit: Longest wait in wall time [s].

    Raises:
        AssertionError: It did not hold in time.
    """
    deadline = time.monotonic() + limit
    while not (value := condition()):
        assert time.monotonic() < deadline, f"{what}: not within {limit:g} s"
        time.sleep(0.02)
    return value


def call(uri, name, *arguments):
    """What a method of a master or a node gives by XML-RPC, or None when it does not answer."""
    try:
        with proxy(uri, CALL_LIMIT) as server:
            code, _, value = getattr(server, name)("/test", *arguments)
    except ERRORS:
        return None
    return value if code == 1 else None


def connected(environment, node):
    """Topics that a node receives over a connection, or None when there is no such node yet.

    Args:
        environment: Of ros_master.
        node: Its name with a slash.
    """
    uri = call(environment["ROS_MASTER_URI"], "lookupNode", node)
    info = call(uri, "getBusInfo") if uri else None
    return None if info is None else {row[4] for row in info if row[2] == "i"}


@contextlib.contextmanager
def flood(environment, topics, *values):
    """Publishes on topics some hundred times a second.

    Args:
        environment: Of ros_master.
        topics: Dict of topic -> type.
        values: "field=expression" of messages that have the field.
    """
    named = ",".join(f"{topic}={kind}" for topic, kind in topics.items())
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
def running(environment, command, **options):
    """Runs a node, killed at the end if it has not ended by then.

    Args:
        environment: Of ros_master.
        command: List of words.
        options: Of subprocess.Popen.
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


def slow_close(folder, environment):
    """Environment of nodes that take their time between closing topics and being shut down.

    Args:
        folder: pathlib.Path, to write to.
        environment: Of ros_master.
    """
    (folder / "sitecustomize.py").write_text(SLOW_CLOSE)
    return with_path(environment, folder)


def with_path(environment, folder):
    """Environment of Python processes that look for modules in a folder first."""
    paths = [str(folder), *filter(None, [environment.get("PYTHONPATH")])]
    return dict(environment, PYTHONPATH=os.pathsep.join(paths))


def executable(package, name):
    """Path of a node, as rosrun finds it in a third of a second."""
    import roslib.packages

    [path, *_] = roslib.packages.find_node(package, name)
    return path


def assert_silent_end(environment, node, command, topics, number=signal.SIGINT, **options):
    """Ends a node in the midst of a flood of messages: it must say no word of an error.

    Args:
        environment: Of ros_master, in which the flood runs.
        node: Name of the node with a slash.
        command: List of words that starts it.
        topics: That it has to receive before it is ended.
        number: Of the signal.
        options: Of subprocess.Popen.

    Raises:
        AssertionError: It says what an error says, or does not end.
    """

    def is_under_way():
        heard = connected(environment, node)
        return process.poll() is not None or (heard is not None and heard >= set(topics))

    with running(environment, command, **options) as process:
        wait_for(is_under_way, f"connections of {node}")
        time.sleep(0.2)  # some messages
        process.send_signal(number)
        said, _ = process.communicate(timeout=LIMIT)
    noise = [line for line in said.splitlines() if any(word in line for word in NOISE)]
    assert not noise, f"{node}, ended by {signal.Signals(number).name}, said:\n{said}"
