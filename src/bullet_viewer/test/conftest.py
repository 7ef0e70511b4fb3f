"""Qt without a screen, and a bridge's end of the socket that serves a real world."""

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
from bullet_viewer.window import Painter, ViewerWindow
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


class Rig:
    """A window, and the world it is shown: the bridge's part, on the test's own thread."""

    def __init__(self):
        self.world = World(gravity=(0.0, 0.0, 0.0))
        self.world.spawn(sdf.ground_plane())
        self.observer = Observer(self.world)
        self.paused = False
        self.views, self.requests = 0, []
        mine, its = socket.socketpair()
        self.connection = Connection(mine.detach())
        self.painter = Painter("tiny")
        self.window = ViewerWindow(Feed(its.detach()), self.painter)
        self.frames = []
        self.painter.drawn.connect(self.frames.append)
        self.window.resize(480, 360)
        self.window.show()
        self.painter.start()

    def box(self, name, place, rgba="1 0 0 1", more=""):
        return self.world.spawn_urdf(name, BOX.format(rgba=rgba, more=more), Pose(place), str)

    def pump(self):
        """Serve messages of the viewer and let Qt work."""
        QApplication.processEvents()
        while not self.connection.closed and self.connection.poll(0.002):
            word, *arguments = self.connection.recv()
            if word == "view":
                self.views += 1
                self.connection.send(("view", self.observer.view(self.paused)))
            elif word == "show":
                self.observer.show(*arguments)
            else:
                self.requests.append((word, *arguments))

    def until(self, condition, what):
        end = time.monotonic() + DEADLINE
        while not condition():
            assert time.monotonic() < end, f"{what}: not within {DEADLINE} s"
            self.pump()

    def picture(self):
        """The view as shown once a picture of the newest state of all is there: QImage."""
        for _ in range(2):  # the one on its way may be older
            count = len(self.frames)
            self.world.step()
            self.until(lambda: len(self.frames) > count, "a picture")
        QApplication.processEvents()
        return self.window.view.grab().toImage()

    def close(self):
        self.window.close()
        if not self.connection.closed:
            self.connection.close()
        self.world.close()


@pytest.fixture
def rig(application):
    rig = Rig()
    yield rig
    rig.close()
