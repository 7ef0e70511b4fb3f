"""Qt without a screen, and a bridge's side of the socket that serves a real world."""

import os
import socket
import time
from multiprocessing.connection import Connection

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.sensors.views import Observer
from bullet_sim.world import World
from bullet_viewer.feed import Feed
from bullet_viewer.window import Renderer, ViewerWindow
from PyQt5.QtWidgets import QApplication

DEADLINE = 90.0  # [s] of wall time for anything the viewer does

BOX = """<robot name="box"><link name="box">
  <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>
  <visual><geometry><box size="0.4 0.4 0.4"/></geometry>
    <material name="c"><color rgba="{rgba}"/></material></visual>
  <collision><geometry><box size="0.4 0.4 0.4"/></geometry></collision></link>{more}</robot>"""


@pytest.fixture(scope="session", name="application")
def _application():
    return QApplication.instance() or QApplication(["test"])


class Viewer:
    """A window, and the world that it shows: the bridge's side, on the test's thread."""

    def __init__(self):
        self.world = World(gravity=(0.0, 0.0, 0.0))
        self.world.spawn(sdf.ground_plane())
        self.observer = Observer(self.world)
        self.paused = False
        self.views, self.requests = 0, []
        bridge_end, viewer_end = socket.socketpair()
        self.connection = Connection(bridge_end.detach())
        self.renderer = Renderer("tiny")
        self.window = ViewerWindow(Feed(viewer_end.detach()), self.renderer)
        self.frames = []
        self.renderer.rendered.connect(self.frames.append)
        self.window.resize(480, 360)
        self.window.show()
        self.renderer.start()

    def box(self, name, position, rgba="1 0 0 1", more=""):
        return self.world.spawn_urdf(name, BOX.format(rgba=rgba, more=more), Pose(position), str)

    def pump(self):
        """Serve messages of the viewer and let Qt work."""
        QApplication.processEvents()
        while not self.connection.closed and self.connection.poll(0.002):
            request, *arguments = self.connection.recv()
            if request == "view":
                self.views += 1
                self.connection.send(("view", self.observer.view(self.paused)))
            elif request == "show":
                self.observer.show(*arguments)
            else:
                self.requests.append((request, *arguments))

    def until(self, condition, label):
        end = time.monotonic() + DEADLINE
        while not condition():
            assert time.monotonic() < end, f"{label}: not within {DEADLINE} s"
            self.pump()

    def image(self):
        """The displayed view after an image of the newest state: QImage."""
        for _ in range(2):  # the one in progress may be older
            count = len(self.frames)
            self.world.step()
            self.until(lambda: len(self.frames) > count, "an image")
        QApplication.processEvents()
        return self.window.view.grab().toImage()

    def close(self):
        self.window.close()
        if not self.connection.closed:
            self.connection.close()
        self.world.close()


@pytest.fixture
def viewer(application):
    viewer = Viewer()
    yield viewer
    viewer.close()
