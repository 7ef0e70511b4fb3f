"""The node `web`: connects pages with the simulator and the ROS graph.

Everything that pages share is changed in the thread of the asyncio loop alone; what rospy's threads
and the simulator's bring is handed over by `call_soon_threadsafe`.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import os
import socket
import threading
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import roslib.message
import rospkg
import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Twist
from paddock_common.settings import Checked, flag, number, read, text
from paddock_common.waiting import flush

from bullet_web import files, graph, window
from bullet_web.actions import ActionError, Actions
from bullet_web.driving import Drive, Seat
from bullet_web.messages import json_of
from bullet_web.navigation import Navigation
from bullet_web.sensors import Sensors
from bullet_web.server import LOOPBACK, File, Page, Server, listen, machine_address
from bullet_web.simulator import Simulator
from paddock_common import nodes

PASSWORD = "PADDOCK_WEB_PASSWORD"  # of the environment, with share
SHORTEST = 6  # characters of a password
TICK = 0.05  # [s] between two looks of the watchdog
LOOK = 2.0  # [s] between two looks at the ROS graph
DATA = 0.2  # [s] between two messages for the plots
SAME = 1e-6  # [m] between two goals that are one
QUEUE = 20  # actions that may wait
END_LIMIT = 2.0  # [s] for the last command
SENSORS = ("camera", "lidar")  # of which a page wants a topic each
WINDOW_LIMIT = 30.0  # [s] for a browser that was started to open the page


@dataclass(frozen=True)
class Settings(Checked):
    """Settings of the node.

    Attributes:
        port: for browsers; 0: the first free one of server.PORTS.
        share: let other machines in, by password.
        rate: views of the world a second, at most.
        timeout: wall time without a command after which the driver's hands count as gone [s].
        topic: of the commands; empty: /cmd_vel, or the first Twist topic with a subscriber.
        open: open the page in a browser window here.
    """

    port: int = number(0, min=0, max=65535)
    share: bool = flag(False)
    rate: float = number(30.0, above=0.0, max=120.0, unit="Hz")
    timeout: float = number(0.5, above=0.0, max=10.0, unit="s")
    topic: str = text("", empty=True)
    open: bool = flag(False)


def password_of(share: bool) -> str:
    """The password of the environment; empty without share.

    Raises:
        ValueError: there is none, or it is too short.
    """
    given = os.environ.pop(PASSWORD, "")
    if not share:
        return ""
    if len(given) < SHORTEST:
        raise ValueError(
            f"share needs a password of at least {SHORTEST} characters in {PASSWORD}, which has "
            f"{len(given)}"
        )
    return given


class WebNode:
    """Content of a Server: the world, the driver's seat, sensors, actions.

    Args:
        loop: asyncio loop of the server.
    """

    def __init__(self, settings: Settings, loop: asyncio.AbstractEventLoop) -> None:
        self.files = files.read(files.LIVE)
        self._settings, self._loop = settings, loop
        self._server = Server(self, password_of(settings.share))
        self._seat = Seat(self._publish, timeout=settings.timeout)
        self._graph = graph.Graph()
        self._topic = settings.topic
        self._publishers: dict[str, Any] = {}
        self._simulator = Simulator(
            settings.rate,
            self._safely(self._new_scene),
            self._safely(self._new_view),
            self._safely(self._new_contacts),
            self._safely(self._no_simulator),
        )
        self._navigation = Navigation(self._safely(self._new_layer), self._simulator.link_pose)
        self._actions = Actions(
            lambda: set(self._simulator.names.values()),
            self._simulator.pose,
            self._simulator.link_pose,
            self._navigation,
        )
        self._sensors = Sensors(self._safely(self._new_sensor_data))
        self._worker = ThreadPoolExecutor(1, "web-actions")  # one action after the other
        self._looker = ThreadPoolExecutor(1, "web-graph")
        self._queued = 0
        self._missing = "Waiting for the simulator"
        self._pace = 1.0
        self._data: dict[str, Any] = {}  # of the referee
        self._goal: tuple[float, float] | None = None  # of the truck, in the world [m]
        self._has_goal = self._sent_data = False
        self._subscribers: dict[str, Any] = {}  # for the plots
        self._stopped, self._left = asyncio.Event(), threading.Event()
        self._page_came, self._no_window = asyncio.Event(), ""  # or why no window opens

    # life ---------------------------------------------------------------------------------------
    async def run(self, listening: socket.socket) -> None:
        """Serve until ROS shuts down.

        The address goes to the terminal and not to the log: those who know it can drive.
        """
        self._server.start(listening)
        rospy.on_shutdown(self._end)
        self._simulator.start()
        tasks = [
            asyncio.ensure_future(self._every(TICK, self._watch)),
            asyncio.ensure_future(self._every(LOOK, self._look)),
            asyncio.ensure_future(self._every(DATA, self._send_data)),
        ]
        if self._settings.open:
            tasks.append(asyncio.ensure_future(self._open_window(self.address(listening))))
        else:
            print(f"the page, in a browser: {self.address(listening)}", flush=True)
        await self._stopped.wait()
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        self._server.stop()
        self._sensors.close()
        self._navigation.close()
        self._simulator.close()

    def _end(self) -> None:
        """Send the last zero before ROS closes the topics; runs in the thread of the shutdown."""
        self._safely(self._leave)()
        self._left.wait(END_LIMIT)
        if self._publishers:
            flush(*self._publishers.values())
        self._safely(self._stopped.set)()

    def _leave(self) -> None:
        self._seat.stop()
        self._left.set()

    def address(self, listening: socket.socket) -> str:
        """What a browser opens."""
        host = machine_address() if self._settings.share else LOOPBACK
        return f"http://{host}:{listening.getsockname()[1]}/{self._server.token}/"

    async def _open_window(self, address: str) -> None:
        """Tell the address and show the page in a browser window, or say why none opens."""
        text = f"the page, in a browser: {address}"
        try:
            window.find_browser()
            redirect = window.Redirect(address, rospkg.get_ros_home())
        except (window.NoWindow, OSError) as error:
            print(f"{text} (no window opens here: {error})", flush=True)
            return
        print(text, flush=True)

        def show() -> None:
            try:
                window.show(redirect.path)
            except window.NoWindow as error:
                self._no_window = str(error)
                self._safely(self._page_came.set)()

        try:
            # A browser that stays in the foreground returns when its window is closed.
            threading.Thread(target=show, name="browser", daemon=True).start()
            await asyncio.wait_for(self._page_came.wait(), WINDOW_LIMIT)
        except asyncio.TimeoutError:
            self._no_window = f"no browser has opened the page within {WINDOW_LIMIT:g} s"
        finally:
            redirect.remove()
        if self._no_window:
            print(f"no window: {self._no_window}; open {address} in a browser", flush=True)

    async def _every(self, period: float, work: Callable[[], Awaitable[None] | None]) -> None:
        while True:
            result = work()
            if result is not None:
                await result
            await asyncio.sleep(period)

    def _safely(self, function: Callable[..., Any]) -> Callable[..., None]:
        """The function, to be called from another thread; runs in the loop's."""

        def call(*arguments: Any) -> None:
            with contextlib.suppress(RuntimeError):  # the loop is closed: the node ends
                self._loop.call_soon_threadsafe(function, *arguments)

        return call

    # Content ------------------------------------------------------------------------------------
    def scene(self, number: int) -> bytes | None:
        """JSON of the present scene."""
        return self._simulator.text if number == self._simulator.number else None

    def asset(self, name: str) -> File | None:
        """A mesh or an image of the present scene."""
        asset = self._simulator.assets.get(name)
        return None if asset is None else File(asset.type, asset.data)

    def opened(self, page: Page) -> None:
        """A page has come: the simulator is asked from now on."""
        self._page_came.set()
        self._simulator.watch(True)
        if self._missing:
            page.put("waiting", json_of({"type": "waiting", "text": self._missing}))
        if self._simulator.number:
            page.put("scene", self._scene_message())
        self._send_status()
        self._loop.create_task(self._look())

    def closed(self, page: Page) -> None:
        """A page has gone; without any the simulator is not asked."""
        self._seat.release(page.number)
        if not self._server.pages:
            self._simulator.watch(False)
        self._subscribe()
        self._send_status()

    def received(self, page: Page, message: dict[str, Any]) -> None:
        """Do what a page asks for."""
        kind = message["type"]
        if kind == "drive":
            before = self._seat.driver
            self._seat.command(page.number, message["speed"], message["steering"])
            if self._seat.driver != before:
                self._send_status()
        elif kind == "want":
            self._want(page, message)
        elif kind in ("take", "release"):
            (self._seat.take if kind == "take" else self._seat.release)(page.number)
            self._send_status()
        elif self._seat.driver not in (None, page.number):
            page.notify(f"Page {self._seat.driver} drives: press Take over first.")
        elif kind == "topic":
            self._choose_topic(page, message["topic"])
        else:
            self._act(page, message)

    # views --------------------------------------------------------------------------------------
    def _put(self, kind: str, message: str | bytes, want: str = "") -> None:
        """Send a message to all pages, or to those that want something."""
        for page in self._server.pages.values():
            if not want or page.wanted.get(want):
                page.put(kind, message)

    def _new_scene(self, _: int) -> None:
        self._put("scene", self._scene_message())

    def _scene_message(self) -> str:
        return json_of({"type": "scene", "number": self._simulator.number})

    def _new_view(self, view: dict[str, Any], source: str) -> None:
        self._missing = ""
        if view["pace"] != self._pace:
            self._pace = view["pace"]
            self._send_status()
        self._put("view", f'{{"type": "view", "view": {source}}}')

    def _new_contacts(self, rows: list[list[float]]) -> None:
        self._put("contacts", json_of({"type": "contacts", "rows": rows}), "contacts")

    def _no_simulator(self, reason: str) -> None:
        self._missing = reason
        self._put("waiting", json_of({"type": "waiting", "text": reason}))

    def _send_status(self) -> None:
        graph = self._graph
        status = {
            "type": "status",
            "driver": self._seat.driver,
            "drives": [drive.described() for drive in graph.drives],
            "topic": self._drive.topic if self._drive else None,
            "cameras": graph.cameras,
            "lidars": graph.lidars,
            "layers": graph.layers,
            "goal": graph.goal or bool(graph.navigators),
            "pace": self._pace,
        }
        for page in self._server.pages.values():
            page.put("status", json_of({**status, "you": page.number}))

    async def _look(self) -> None:
        """Look at the ROS graph, while there are pages."""
        if not self._server.pages:
            return
        try:
            look = self._loop.run_in_executor(self._looker, graph.look, rospy.get_name())
            present = await look
            await self._loop.run_in_executor(self._looker, self._navigation.flush)
        except Exception as error:  # of the master: XML-RPC's, sockets', rosgraph's
            rospy.logwarn_throttle(60.0, f"the ROS master does not answer: {error}")
            return
        if present != self._graph:
            self._graph = present
            self._subscribe()
            self._send_status()
        if self._drive is not None:
            self._publisher(self._drive.topic)

    # driving ------------------------------------------------------------------------------------
    @property
    def _drive(self) -> Drive | None:
        """How the chosen topic is commanded."""
        drives = self._graph.drives
        chosen = [drive for drive in drives if drive.topic == self._topic]
        if self._topic and not chosen:
            return Drive(self._topic) if self._topic == self._settings.topic else None
        return next(iter(chosen or drives), None)

    def _choose_topic(self, page: Page, topic: str) -> None:
        if topic not in [drive.topic for drive in self._graph.drives]:
            page.notify(f"{topic} is no topic of type {graph.TWIST} with a subscriber")
            return
        self._seat.stop()
        self._topic = topic
        self._publisher(topic)
        self._send_status()

    def _publisher(self, topic: str) -> Any:
        if topic not in self._publishers:
            self._publishers[topic] = rospy.Publisher(topic, Twist, queue_size=10)
        return self._publishers[topic]

    def _publish(self, speed: float, steering: float) -> None:
        drive = self._drive
        if drive is None:
            return
        message = Twist()
        message.linear.x, message.angular.z = drive.twist(speed, steering)
        try:
            self._publisher(drive.topic).publish(message)
        except rospy.ROSException as error:
            rospy.logwarn_throttle(10.0, f"the command is not sent: {error}")

    def _watch(self) -> None:
        if self._seat.check() and self._seat.driver in self._server.pages:
            self._server.pages[self._seat.driver].notify("No command arrived in time: stopped.")

    # sensors and plots --------------------------------------------------------------------------
    def _subscribe(self) -> None:
        """Subscribe to what pages want and the graph has."""
        present = {"camera": self._graph.cameras, "lidar": self._graph.lidars}
        pages = self._server.pages.values()
        self._sensors.set_wanted(
            {
                (self._graph.types[page.wanted[want]], page.wanted[want])
                for page in pages
                for want, topics in present.items()
                if page.wanted.get(want) in topics
            }
        )
        layers = {topic for page in pages for topic in self._layers_of(page)}
        self._navigation.set_wanted({topic: self._graph.types[topic] for topic in layers})
        navigates = bool(layers or self._graph.navigators)
        self._navigation.watch(self._graph.navigators, bool(pages) and navigates)
        self._simulator.wants_contacts = any(page.wanted.get("contacts") for page in pages)
        wanted = any(page.wanted.get("data") for page in pages)
        goal = bool(pages) and self._graph.goal
        self._follow("/goal/pose", PoseStamped, self._new_goal, goal)
        self._follow("/goal/status", GoalStatus, self._new_goal_status, goal)
        if wanted and self._graph.referee:
            kind = roslib.message.get_message_class("track_model/LapStatus")
            if kind is not None:
                self._follow("/referee/status", kind, self._new_lap, True)
        else:
            self._follow("/referee/status", None, self._new_lap, False)

    def _layers_of(self, page: Page) -> list[str]:
        """Topics of navigation that a page wants and the graph has."""
        wanted = page.wanted.get("layers", "").split()
        return [topic for topic in wanted if topic in self._graph.layers]

    def _want(self, page: Page, message: dict[str, Any]) -> None:
        before, sensors = self._layers_of(page), {page.wanted.get(want) for want in SENSORS}
        page.wanted = message
        self._subscribe()
        for topic in {message.get(want) for want in SENSORS} - sensors:
            shown = self._sensors.last(topic or "")
            if shown:  # a still picture comes once, and another page may have it already
                page.put(*shown)
        for topic in set(self._layers_of(page)) - set(before):
            last = self._navigation.last(topic)
            if last:  # a map is published once
                page.put(f"layer {topic}", last)

    def _new_layer(self, topic: str, message: bytes) -> None:
        for page in self._server.pages.values():
            if topic in self._layers_of(page):
                page.put(f"layer {topic}", message)

    def _send_frames(self) -> None:
        """Tell pages where the frames of what they show are in the world."""
        frames = self._navigation.layer_frames()
        if not frames:
            return
        anchors = self._navigation.anchors(frames)
        self._put("frames", json_of({"type": "frames", "frames": anchors}), "layers")

    def _follow(self, topic: str, kind: Any, callback: Callable[[Any], None], wanted: bool) -> None:
        if wanted and topic not in self._subscribers:
            self._subscribers[topic] = rospy.Subscriber(
                topic, kind, self._safely(callback), queue_size=1
            )
        elif not wanted and topic in self._subscribers:
            self._subscribers.pop(topic).unregister()

    def _new_sensor_data(self, kind: str, topic: str, message: bytes) -> None:
        want = "camera" if kind == "image" else "lidar"
        for page in self._server.pages.values():
            if page.wanted.get(want) == topic:
                page.put(kind, message)

    def _new_goal(self, message: Any) -> None:
        place = message.pose.position.x, message.pose.position.y
        goal = self._actions.goal
        if goal is not None and math.dist(place, goal[0]) < SAME:
            place = goal[1]  # as it was clicked, in the world
        self._goal = place

    def _new_goal_status(self, message: Any) -> None:
        self._has_goal = message.status in (GoalStatus.ACTIVE, GoalStatus.SUCCEEDED)

    def _new_lap(self, message: Any) -> None:
        times = [
            f"lap {message.laps + 1}: {message.lap_time:.1f} s"
            if message.running
            else "no lap yet",
            f"last {message.last_lap_time:.2f} s" if message.last_lap_time else "",
            f"best {message.best_lap_time:.2f} s" if message.best_lap_time else "",
        ]
        self._data["lateral_error"] = message.lateral_error
        self._data["lap"] = ", ".join(filter(None, times))

    def _send_data(self) -> None:
        self._send_frames()
        place: tuple[float, ...] | None = self._goal if self._has_goal else None
        if place is None:
            place = self._navigation.goal_in_world()
        goal = {"goal": place[:2]} if place else {}
        data = {**self._data, **goal}
        if not data and not self._sent_data:
            return
        self._sent_data = bool(data)  # what is no longer there is told once
        self._put("data", json_of({"type": "data", **data}))

    # actions ------------------------------------------------------------------------------------
    def _act(self, page: Page, message: dict[str, Any]) -> None:
        if self._queued >= QUEUE:
            page.notify(f"{QUEUE} actions wait already")
            return
        self._queued += 1
        self._loop.create_task(self._execute(page, message))

    async def _execute(self, page: Page, message: dict[str, Any]) -> None:
        execute = self._actions.execute
        try:
            done = await self._loop.run_in_executor(self._worker, execute, message)
        except ActionError as error:
            page.notify(str(error))
        except Exception as error:  # a service's answer that nobody has foreseen
            rospy.logerr("%s has failed: %s: %s", message, type(error).__name__, error)
            page.notify(f"{message['action']}: {error}")
        else:
            if done:
                page.notify(done, good=True)
            self._simulator.wake.set()
        finally:
            self._queued -= 1


def main() -> int:
    """Run the node `web`; returns its exit code, for nodes.leave(): a scene may still be made."""

    def make() -> tuple[WebNode, socket.socket]:
        settings = read(Settings, rospy.get_param)
        listening = listen(settings.port, settings.share)
        return WebNode(settings, loop), listening

    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    node, listening = nodes.start("web", make, (ValueError, OSError), disable_rostime=True)
    loop.run_until_complete(node.run(listening))
    return 0
