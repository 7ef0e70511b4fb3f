"""Subscriptions keep their publishers in each interleaving in which rospy loses them."""

import queue
import subprocess
import sys
import threading
import time

import pytest

from paddock_common import testing

LIMIT = 40.0  # [s] for what comes at once; what is lost never comes
TIMES = 15
# A node that prints what it hears. `delay` has rospy be late at one place.
NODE = """
import sys, threading, time
import rospy
from rospy.impl import registration
from rospy.impl.tcpros_base import TCPROSTransport
from paddock_common import nodes
from std_msgs.msg import Int32
def say(text):
    sys.stdout.write(text + "\\n")  # in one piece
    sys.stdout.flush()
{delay}
nodes.init_node("node", disable_signals=True)
heard = rospy.Subscriber("/command", Int32, lambda message: say(str(message.data)))
say("subscribed")
rospy.spin()
"""
# What is closed is noticed a second later, as by a thread that gets no processor.
LATE_END = """
close = TCPROSTransport.close
def late(self):
    if self.direction == "i" and not self.done:
        time.sleep(1.0)
    close(self)
TCPROSTransport.close = late
"""
# The master's answer is read after its word of a publisher that registers in between; the thread
# that reads both waits for the subscription meanwhile, for it looks at all topics twice a second.
LATE_ANSWER = """
ask = registration.xmlrpcapi
class Late:
    def __init__(self, master):
        self.master = master
    def __getattr__(self, name):
        return getattr(self.master, name)
    def registerSubscriber(self, *args):
        answer = self.master.registerSubscriber(*args)
        if args[1] == "/command":
            time.sleep(1.5)
            say("answered")
            manager = next(iter(registration.get_registration_listeners().listeners))
            while not any(topic == "/command" for topic, _ in manager.updates):
                time.sleep(0.01)
        return answer
registration.xmlrpcapi = lambda uri, cache=True: Late(ask(uri, cache))
"""
BUSY = """
def work():
    while True:
        pass
sys.setswitchinterval(0.05)
threading.Thread(target=work, daemon=True).start()
"""
# A client: `again` gives up the publisher `made` and makes another.
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
    begin = time.monotonic()
    while not made.get_num_connections():
        assert time.monotonic() - begin < {limit}, "nobody hears"
        time.sleep(0.005)
    return time.monotonic() - begin
{hindrance}
rospy.init_node("client", disable_signals=True)
{life}
"""
ADVERTISE = """
advertise()
await_connection()
made.publish(1)
time.sleep(0.5)
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
# The publisher loses sight of its connection, which stays open: the node hears no end of it.
FORGET = """
kept = list(made.impl.connections)
made.impl.connections = []
"""
# The publisher goes while the node greets it; a second later it comes again.
GO_AT_FIRST = """
greet = TCPROSHandler.topic_connection_handler
def go(self, sock, address, header):
    if header.get("topic") == "/command" and not gone:
        gone.append(1)
        made.unregister()
    return greet(self, sock, address, header)
gone = []
TCPROSHandler.topic_connection_handler = go
"""
COME_AGAIN = """
advertise()
while not gone:
    time.sleep(0.01)
time.sleep(2.0)
advertise()
for _ in range(int({limit} / 0.1)):
    made.publish(2)
    time.sleep(0.1)
"""
# It comes again and again, each time as soon as it is told that the last command was heard.
MANY = """
import select
for number in range({times}):
    advertise()
    while not select.select([sys.stdin], [], [], 0.01)[0]:
        made.publish(number)
    sys.stdin.readline()
    made.unregister()
"""


class Process:
    """A script that runs, and the lines that it says."""

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

    def hear(self, wanted, limit=LIMIT):
        """Waits for a line."""
        end = time.monotonic() + limit
        while time.monotonic() < end:
            try:
                if self._lines.get(timeout=max(0.0, end - time.monotonic())) == wanted:
                    return
            except queue.Empty:
                break
        raise AssertionError(f"{wanted}: not within {limit:g} s")

    def go_on(self):
        """Tells it to go on."""
        self.process.stdin.write("\n")
        self.process.stdin.flush()


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        yield environment


@pytest.fixture
def start(environment):
    """Function that starts a script; killed at the end."""
    made = []

    def popen(script, **words):
        for name, value in [*words.items(), ("limit", LIMIT)]:
            script = script.replace(f"{{{name}}}", str(value))
        made.append(Process(script, environment))
        return made[-1]

    yield popen
    for script in made:
        script.process.kill()
        script.process.wait()


def test_publisher_that_comes_again_before_its_end_is_noticed(start):
    node = start(NODE, delay=LATE_END)
    node.hear("subscribed")
    start(CLIENT, hindrance="", life=TWICE, between="")
    node.hear("2")


def test_publisher_that_forgets_its_connection_and_comes_again(start):
    node = start(NODE, delay="")
    node.hear("subscribed")
    start(CLIENT, hindrance="", life=TWICE, between=FORGET)
    node.hear("2")


def test_publisher_that_goes_while_it_is_greeted(start):
    node = start(NODE, delay="")
    node.hear("subscribed")
    start(CLIENT, hindrance=GO_AT_FIRST, life=COME_AGAIN)
    node.hear("2")


def test_publisher_that_registers_while_the_node_subscribes(start):
    node = start(NODE, delay=LATE_ANSWER)
    node.hear("answered")
    start(CLIENT, hindrance="", life=ADVERTISE)
    node.hear("1")


def test_client_that_closes_and_advertises_again_at_once(start):
    """A busy node hears it each time, within a bounded time."""
    node = start(NODE, delay=BUSY)
    node.hear("subscribed")
    client = start(CLIENT, hindrance="", life=MANY, times=TIMES)
    longest = 0.0
    for number in range(TIMES):
        begin = time.monotonic()
        node.hear(str(number))
        longest = max(longest, time.monotonic() - begin)
        client.go_on()
    print(f"longest without a command: {longest:.2f} s")
