"""The simulator as pages see it: a thread that asks for views while somebody looks."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from typing import Any

import rospy
from bullet_sim.pose import compose, rpy_from_quaternion
from std_srvs.srv import Trigger

from bullet_web.messages import json_of
from bullet_web.scene import Asset, Scene, SceneMaker

RETRY = 1.0  # [s] between two tries to reach a simulator
RECHECK = 0.5  # [s] between two views while paused
CONTACTS = 0.1  # [s] between two looks at the contact points


class Simulator(threading.Thread):
    """Asks `/gazebo/view` at a rate of wall time, and `/gazebo/scene` when it has changed.

    Args:
        rate: views a second.
        name: of the simulator's node.
        on_scene: called with the number of a new scene.
        on_view: called with each view: its fields and its JSON text.
        on_contacts: called with the rows of `/gazebo/contacts`, while they are wanted.
        on_missing: called with the reason while there is no simulator.
        The callbacks run in this thread.
    """

    def __init__(
        self,
        rate: float,
        on_scene: Callable[[int], object],
        on_view: Callable[[dict[str, Any], str], object],
        on_contacts: Callable[[list[list[float]]], object],
        on_missing: Callable[[str], object],
        name: str = "/gazebo",
    ) -> None:
        super().__init__(name="simulator", daemon=True)
        self._period, self._prefix = 1.0 / rate, name
        self._on_scene, self._on_view = on_scene, on_view
        self._on_contacts, self._on_missing = on_contacts, on_missing
        self._watched, self._ended = threading.Event(), False
        self._maker = SceneMaker()
        self._services: dict[str, Any] = {}
        self.assets: dict[str, Asset] = {}  # meshes and images of the newest scene
        self.scene: Scene = {}
        self.number, self.text = 0, b""  # of the scene, for the server
        self.names: dict[int, str] = {}  # of the models by key
        self.last: dict[str, Any] = {}  # the newest view
        self.wake = threading.Event()  # set: ask now
        self.wants_contacts = False
        self._contacts_at = 0.0  # wall time of the last [s]

    def watch(self, on: bool) -> None:
        """Ask, or do not."""
        if on:
            self._watched.set()
        else:
            self._watched.clear()

    def close(self) -> None:
        """End the thread."""
        self._ended = True
        self._watched.set()
        self.wake.set()

    def pose(self, model: str) -> list[float] | None:
        """Position and quaternion of a model in the newest view."""
        for row in self.last.get("bodies", ()):
            if self.names.get(row[0]) == model:
                return row[1:8]
        return None

    def link_pose(self, link: str, model: str = "") -> tuple[float, float, float] | None:
        """x, y [m], yaw [rad] of a link's frame in the newest view.

        None: no model has that link, or it is behind a joint that moves. Of several models that
        of the name counts, else the one that was spawned first.
        """
        rows = {row[0]: row for row in self.last.get("bodies", ())}
        for body in sorted(self.scene.get("bodies", ()), key=lambda body: body["name"] != model):
            row, frame = rows.get(body["key"]), body["frames"].get(link)
            if row is not None and frame is not None and not frame[0]:
                position, orientation = compose(row[1:4], row[4:8], frame[1:4], frame[4:8])
                return position[0], position[1], rpy_from_quaternion(orientation)[2]
        return None

    def run(self) -> None:
        """Ask until the node ends."""
        due = time.monotonic()
        while not self._ended and not rospy.is_shutdown():
            if not self._watched.is_set():
                self._hang_up()
                self._watched.wait()
                due = time.monotonic()
                continue
            try:
                pause = self._look()
            except (rospy.ROSException, rospy.ServiceException, OSError, ValueError) as error:
                self._hang_up()
                self.number = 0
                self._on_missing(f"Waiting for the simulator ({error})")
                pause = RETRY
            now = time.monotonic()
            due = max(due + pause, now)
            self.wake.wait(due - now)
            self.wake.clear()

    def _look(self) -> float:
        """Take a view; returns the time to the next one [s]."""
        text = self._call("view")
        view = json.loads(text)
        if view["scene"] != self.number:
            self._take_scene()
        self.last = view
        self._on_view(view, text)
        now = time.monotonic()
        if self.wants_contacts and now - self._contacts_at >= CONTACTS:
            self._contacts_at = now
            self._on_contacts(json.loads(self._call("contacts"))["contacts"])
        return RECHECK / 5.0 if view["paused"] else self._period

    def _take_scene(self) -> None:
        source = json.loads(self._call("scene"))
        scene = self._maker.make(source)
        self.text = json_of(scene).encode()
        self.names = {body["key"]: body["name"] for body in scene["bodies"]}
        self.assets, self.scene = self._maker.assets, scene
        self.number = scene["number"]
        self._on_scene(self.number)

    def _call(self, name: str) -> str:
        """The JSON of a service of the simulator.

        Raises:
            rospy.ROSException, rospy.ServiceException: there is no simulator, or it has gone.
            ValueError: it answers with an error.
        """
        if name not in self._services:
            service = f"{self._prefix}/{name}"
            rospy.wait_for_service(service, timeout=RETRY)
            self._services[name] = rospy.ServiceProxy(service, Trigger, persistent=True)
        response = self._services[name]()
        if not response.success:
            raise ValueError(response.message)
        return response.message

    def _hang_up(self) -> None:
        """Close the connections; the next call opens them again."""
        for service in self._services.values():
            service.close()
        self._services.clear()
