"""frames KIND: rounds of images received (KIND received), or of bare renderers (egl or gl).

Answers once it is ready; then each line "SECONDS" or, for gl, "SECONDS SHADOWS/ANTIALIAS" (e.g.
true/false) is a round with one answer. The bridge is paused but for the rounds of received images.
"""

import importlib.util
import time
from dataclasses import replace

import pybullet
from bullet_sim.engine.bullet.camera import PyBulletCamera
from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.pose import Pose
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.pybullet_renderer import PyBulletRenderer
from bullet_sim.render.request import CameraRequest, Quality
from pairs import rate_of_work

from observers import graph, stepping

QUIET = 0.3  # [s] between pausing or going on and the window
SNAPSHOTS, STRIDE = 100, 10  # of the driving car, and steps between two of them


class EglCamera(PyBulletCamera):
    """A PyBulletCamera by PyBullet's OpenGL instead of TinyRenderer."""

    renderer = pybullet.ER_BULLET_HARDWARE_OPENGL

    def __init__(self, client):
        super().__init__(client)
        plugin = importlib.util.find_spec("eglRenderer").origin
        if client.api.loadPlugin(plugin, "_eglRendererPlugin") < 0:
            raise SystemExit("PyBullet's EGL renderer does not load: is libegl1 installed?")


class EglRenderer(PyBulletRenderer):
    """A PyBulletRenderer with an EglCamera."""

    camera, offset = EglCamera, (0.0, 0.0)


class BareCamera:
    """The car's camera in this process, drawn by one renderer after the other.

    Args:
        world: World with the car, which drives.
    """

    def __init__(self, world):
        car = world.model("racecar")
        spec = next(spec for spec in car.description.sensors if isinstance(spec, CameraSpec))
        part, offset = car.link_in_body(spec.link)
        pose = offset * Pose.from_xyz_rpy(*spec.pose)
        request = CameraRequest.from_spec(spec, car.source.key, car.row(part), 1)
        self._request = replace(request, pose=(pose.position, pose.rpy))
        self._snapshots = []
        for _ in range(SNAPSHOTS):
            world.step(STRIDE)
            self._snapshots.append(world.snapshot())
        self._sources, self._scene, self._number = world.sources(), world.scene, 0
        self._renderers = {}

    def rate(self, kind, seconds):
        """Pictures per second of one renderer: 'egl', or SHADOWS/ANTIALIAS of ours."""
        if kind not in self._renderers:
            renderer = self._renderers[kind] = self._make(kind)
            renderer.sync_sources(self._sources, self._scene)
            self._draw(renderer)  # the first one uploads textures
        return rate_of_work(lambda: self._draw(self._renderers[kind]), seconds)

    @staticmethod
    def _make(kind):
        if kind != "egl":
            return GlRenderer(Quality(*kind.split("/")))
        return EglRenderer()

    def _draw(self, renderer):
        self._number += 1
        renderer.apply(self._snapshots[self._number % SNAPSHOTS])
        renderer.render(self._request)
        return 1


def frames(kind):
    """Start, then rounds until bench.py closes the pipe."""
    graph.join()
    if kind == "received":
        receive()
    bare_camera = BareCamera(stepping.bare_world())
    graph.say(ready=True)
    while True:
        seconds, *quality = graph.receive()
        time.sleep(QUIET)
        graph.say(rate=bare_camera.rate(*quality or ["egl"], float(seconds)))


def receive():
    """Rounds of received images, with the car driving."""
    images = graph.record("/camera/image", 4)
    graph.wait_for_controllers()
    graph.wait_for(images, "/camera/image")
    graph.start_circle(graph.publishers())
    simulation = graph.Simulation()
    time.sleep(1.5)
    simulation.pause()
    graph.say(ready=True)
    while True:
        (seconds,) = graph.receive()
        simulation.unpause()
        time.sleep(QUIET)
        begin, count = time.monotonic(), len(images)
        time.sleep(float(seconds))
        rate = (len(images) - count) / (time.monotonic() - begin)
        simulation.pause()
        graph.say(rate=rate)
