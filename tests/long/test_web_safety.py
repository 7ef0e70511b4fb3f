"""The page's node beside a real world: wild messages, fifty pages, browsers that stop reading."""

import json
import random
import socket
import time
import unittest

import psutil
import websocket
from geometry_msgs.msg import Twist
from paddock_common.process import free_port
from page_client import PageClient, WebNode
from sim_client import Recorder, wait_for_car, wait_until
from test_messages import VALID

LAUNCH = """<launch>
  <include file="$(find track_model)/launch/world.launch">
    <arg name="headless" value="true"/>
    <arg name="state_publisher" value="false"/>
    <arg name="camera_width" value="320"/>
    <arg name="camera_height" value="240"/>
    <arg name="camera_rate" value="15"/>
  </include>
  <include file="$(find deepracer_control)/launch/control.launch"/>
</launch>
"""
WILD = 10000  # mutated messages
PAGES, CYCLES = 50, 5  # pages that come and go, and how often
STALLED = 10  # browsers that do not read
AT_ONCE = 500  # messages of one page: more than 600 would close it
ODD = [
    None,
    True,
    -1,
    0,
    1e999,
    -1e-300,
    10**400,
    "",
    "x" * 300,
    "\x00",
    "ü",
    [],
    [[]],
    {},
    {"x": 1},
]


def mutated(chance):
    """A message of a page with another character, field or value, or without one."""
    message = dict(chance.choice(VALID))
    if chance.random() < 0.5:
        name = chance.choice([*message, "more"])
        if chance.random() < 0.2:
            message.pop(name, None)
        else:
            message[name] = chance.choice(ODD)
        return json.dumps(message)
    text = list(json.dumps(message))
    for _ in range(chance.randint(1, 4)):
        at = chance.randrange(len(text) + 1)
        text[at : at + chance.randint(0, 3)] = chance.choice('{}[]":,-+.eE0917 \\\x00ünaN')
    return "".join(text)


class Safety(unittest.TestCase):
    """One node for all tests."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.commands = Recorder("/cmd_vel", Twist)
        cls.web = WebNode(f"_port:={free_port()}")
        cls.addClassCleanup(cls.web.end)
        cls.process = psutil.Process(cls.web.process.pid)

    def open(self):
        page = PageClient(self.web.url)
        self.addCleanup(page.close)
        return page

    def raw(self, **options):
        """A WebSocket that does what the test says alone."""
        made = websocket.create_connection(
            self.web.url.replace("http:", "ws:") + "socket",
            timeout=60.0,
            origin="/".join(self.web.url.split("/")[:3]),
            **options,
        )
        self.addCleanup(made.shutdown)
        return made

    def goes_on(self, page):
        """Waits until a page sees simulated time go on."""
        wait_until(lambda: page.views and not page.views[-1]["paused"], "a view that is not paused")
        last = page.views[-1]["time"]
        wait_until(lambda: page.views[-1]["time"] != last, "simulated time")

    def test_ten_thousand_mutated_messages_end_and_stall_nothing(self):
        chance = random.Random(33)
        witness = self.open()
        wait_until(lambda: witness.status.get("topic"), "a topic to drive")
        self.goes_on(witness)
        memory = self.process.memory_info().rss
        sent, refused = 0, 0
        while sent < WILD:
            wild = self.raw()
            seen = len(witness.views)
            for _ in range(AT_ONCE):
                wild.send(mutated(chance))
            sent += AT_ONCE
            wild.settimeout(0.05)
            try:
                while answer := wild.recv():
                    refused += isinstance(answer, str) and '"notice"' in answer
                    wild.send('{"type": "ack"}')
            except (OSError, websocket.WebSocketException):
                pass  # nothing more, or closed
            wild.close()
            wait_until(lambda seen=seen: len(witness.views) > seen, "another view")
        self.assertGreater(refused, 0)
        self.assertIsNone(self.web.process.poll())
        wait_until(lambda: witness.status["driver"] is None, "an empty seat")
        # What was valid happens, at most 20 orders, in their turn; then orders are taken as before.

        def drained():
            witness.act("remove", model="drained")
            time.sleep(0.5)
            return any("'drained'" in text for text in witness.notices)

        wait_until(drained, "an order's turn")
        witness.act("reset")
        witness.act("pace", factor=1)
        witness.act("resume")
        wait_until(lambda: witness.status["pace"] == 1.0, "real time")
        self.goes_on(witness)
        self.commands.clear()
        witness.send("drive", speed=0.2, steering=0.0)
        wait_until(lambda: self.commands.messages, "the command")
        wait_until(lambda: self.commands.newest.linear.x == 0.0, "the watchdog's zero")
        self.assertLess(self.process.memory_info().rss - memory, 60e6)

    def test_fifty_pages_come_and_go_without_leaving_memory(self):
        def cycle():
            pages = [self.raw() for _ in range(PAGES)]
            for page in pages:
                kinds = set()
                while "view" not in kinds:
                    kinds.add(json.loads(page.recv())["type"])
                    page.send('{"type": "ack"}')
            for page in pages:
                page.close()

        for _ in range(2):
            cycle()
        memory, files = self.process.memory_info().rss, self.process.num_fds()
        threads = self.process.num_threads()
        for _ in range(CYCLES):
            cycle()
        page = self.open()  # the node still works
        self.goes_on(page)
        page.close()
        self.assertLess(self.process.memory_info().rss - memory, 10e6)
        wait_until(lambda: self.process.num_fds() <= files + 2, "the end of the connections")
        self.assertLessEqual(self.process.num_threads(), threads + 2)

    def test_ten_browsers_that_stop_reading_slow_nothing(self):
        want = {"camera": "/camera/image", "lidar": "", "data": True, "contacts": True}
        quick = self.open()
        wait_until(lambda: "/camera/image" in quick.status.get("cameras", ()), "the camera")
        quick.send("want", **want)
        self.goes_on(quick)

        def cost():
            """The node's processor time for a view [s]; time goes on, images come."""
            self.goes_on(quick)
            images, views, before = len(quick.binary), len(quick.views), self.process.cpu_times()
            wait_until(lambda: len(quick.views) > views + 100, "100 views")
            wait_until(lambda: len(quick.binary) > images + 10, "10 images")
            after, count = self.process.cpu_times(), len(quick.views) - views
            return (after.user + after.system - before.user - before.system) / count

        alone = cost()
        memory = self.process.memory_info().rss
        stalled = [
            self.raw(sockopt=((socket.SOL_SOCKET, socket.SO_RCVBUF, 4096),)) for _ in range(STALLED)
        ]
        for page in stalled:
            page.send(json.dumps({"type": "want", **want}))
        for _ in range(200):  # half of them say that they have read
            for page in stalled[: STALLED // 2]:
                page.send('{"type": "ack"}')
            time.sleep(0.02)
        beside = cost()
        print(f"a view costs {alone:.4f} s, beside some that do not read {beside:.4f} s")
        self.assertLess(beside, 3.0 * alone)
        self.assertLess(self.process.memory_info().rss - memory, 20e6)
