"""Subscriptions reconnect in each interleaving in which rospy drops a publisher."""

import queue
import subprocess
import sys
import threading
import time

import pytest
import testing

LIMIT = 40.0  # [s] for immediate messages; dropped ones never arrive
# A node that prints what it receives. `delay` makes rospy late at one place.
NODE = """
import sys, threading, time
import rospy
from rospy.impl import registration
from rospy.impl.tcpros_base import TCPROSTransport
from paddock_common import nodes
from std_msgs.msg import Int32
def log(text):
    sys.stdout.write(text + "\\n")  # in one write
    sys.stdout.flush()
{delay}
nodes.init_node("node", disable_signals=True)
subscriber = rospy.Subscriber("/command", Int32, lambda message: log(str(message.data)))
log("subscribed")
rospy.spin()
"""
# A closed connection is noticed a second later, as by a thread that gets no CPU time.
LATE_END = """
close = TCPROSTransport.close
def late(self):
    if self.direction == "i" and not self.done:
        time.sleep(1.0)
    close(self)
TCPROSTransport.close = late
"""
# The master's response is read after its update about a publisher that registers in between; the
# thread that reads both waits for the subscription meanwhile: it checks all topics twice a second.
LATE_RESPONSE = """
original = registration.xmlrpcapi
class Late:
    def __init__(self, master):
        self.master = master
    def __getattr__(self, name):
        return getattr(self.master, name)
    def registerSubscriber(self, *args):
        response = self.master.registerSubscriber(*args)
        if args[1] == "/command":
            time.sleep(1.5)
            log("responded")
            manager = next(iter(registration.get_registration_listeners().listeners))
            while not any(topic == "/command" for topic, _ in manager.updates):
                time.sleep(0.01)
        return response
registration.xmlrpcapi = lambda uri, cache=True: Late(original(uri, cache))
"""
# A client with a publisher `made`.
CLIENT = """
import sys, time
import rospy, rospy.core
from rospy.impl.tcpros_pubsub import TCPROSHandler
from std_msgs.msg import Int32
made = None
def advertise():
    global made
    made = rospy.Publisher("/command", Int32, queue_size=10)
def await_connection():
    start = time.monotonic()
    while not made.get_num_connections():
        assert time.monotonic() - start < {limit}, "no subscriber"
        time.sleep(0.005)
    return time.monotonic() - start
{delay}
rospy.init_node("client", disable_signals=True)
{life}
"""
ADVERTISE = """
advertise()
await_connection()
made.publish(1)
sys.stdin.read()  # until the test is over
"""
TWICE = """
advertise()
await_connection()
made.publish(1)
time.sleep(0.3)
{between}
made.unregister()
advertise()
for _ in range(int({limit} / 0.1)):
    made.publish(2)
    time.sleep(0.1)
"""
# The publisher drops its connection, which stays open: the node does not notice.
DROP = """
kept = list(made.impl.connections)
made.impl.connections = []
"""
# The publisher unregisters during the handshake; later it registers again.
UNREGISTER_FIRST = """
handshake = TCPROSHandler.topic_connection_handler
def unregister_first(self, sock, address, header):
    if header.get("topic") == "/command" and not done:
        done.append(1)
        made.unregister()
    return handshake(self, sock, address, header)
done = []
TCPROSHandler.topic_connection_handler = unregister_first
"""
REGISTER_AGAIN = """
advertise()
while not done:
    time.sleep(0.01)
time.sleep(2.0)
advertise()
for _ in range(int({limit} / 0.1)):
    made.publish(2)
    time.sleep(0.1)
"""


class Process:
    """A running script, and the lines that it prints."""

    def __init__(self, script, environment):
        self.process = subprocess.Popen(
            [sys.executable, "-c", script],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._lines = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.process.stdout:
            self._lines.put(line.strip())

    def expect(self, expected, limit=LIMIT):
        end = time.monotonic() + limit
        while time.monotonic() < end:
            try:
                if self._lines.get(timeout=max(0.0, end - time.monotonic())) == expected:
                    return
            except queue.Empty:
                break
        raise AssertionError(f"{expected}: not within {limit:g} s")


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        yield environment


@pytest.fixture
def start(environment):
    """Function that starts a script; killed at the end."""
    made = []

    def popen(script, **values):
        for name, value in {"delay": "", **values, "limit": LIMIT}.items():
            script = script.replace(f"{{{name}}}", str(value))
        made.append(Process(script, environment))
        return made[-1]

    yield popen
    for script in made:
        script.process.kill()
        script.process.wait()


def test_publisher_that_registers_again_before_its_end_is_noticed(start):
    node = start(NODE, delay=LATE_END)
    node.expect("subscribed")
    start(CLIENT, delay="", life=TWICE, between="")
    node.expect("2")


def test_publisher_that_drops_its_connection_and_registers_again(start):
    node = start(NODE, delay="")
    node.expect("subscribed")
    start(CLIENT, delay="", life=TWICE, between=DROP)
    node.expect("2")


def test_publisher_that_unregisters_during_the_handshake(start):
    node = start(NODE, delay="")
    node.expect("subscribed")
    start(CLIENT, delay=UNREGISTER_FIRST, life=REGISTER_AGAIN)
    node.expect("2")


def test_publisher_that_registers_while_the_node_subscribes(start):
    node = start(NODE, delay=LATE_RESPONSE)
    node.expect("responded")
    start(CLIENT, delay="", life=ADVERTISE)
    node.expect("1")
