"""A world of 100 models with 500,000 triangles: loading, drawing, what is spawned later; no ROS."""

import pathlib
import tempfile
import threading
import time

import trimesh
from bullet_sim.pose import Pose
from bullet_sim.render.client import RenderClient
from bullet_sim.render.request import CameraRequest
from bullet_sim.world import World
from figures import BenchError, Spread
from report import Row

MODELS, SIDE = 100, 10  # SIDE in a row
RINGS = (50, 26)  # of a ball: 4,992 triangles
GAP = 3.0  # [m] between two balls
LIMIT = 60.0  # [s] of wall time for an image
SECONDS = 1.0  # of a round
CAMERA = CameraRequest("eye", None, 0, ((-4, 0, 9), (0, 0.5, 0.6)), 640, 480, 1.2, 0.1, 100.0)
MODEL = (
    '<sdf version="1.6"><model name="{name}"><static>true</static><link name="l"><visual name="v">'
    "<geometry><mesh><uri>{path}</uri></mesh></geometry></visual></link></model></sdf>"
)


class Studio:
    """A render worker and the time at which each image of it arrived."""

    def __init__(self):
        self._arrived, self._times = threading.Event(), []
        self._client = RenderClient(on_frame=self._note)
        self._client.start()

    def _note(self, _frame):
        self._times.append(time.monotonic())
        self._arrived.set()

    def image(self, world):
        """Seconds from handing over the world's bodies to their image.

        Raises:
            BenchError: none came.
        """
        begin = time.monotonic()
        self._arrived.clear()
        self._client.set_sources(world.sources(), world.scene)
        self._client.submit(world.snapshot(), [CAMERA])
        if not self._arrived.wait(LIMIT):
            raise BenchError(f"no image of the scenery within {LIMIT:g} s")
        return self._times[-1] - begin

    def rate(self, world):
        """Pictures per second over a round, each ordered once the one before has come."""
        begin = time.monotonic()
        count = 0
        while time.monotonic() < begin + SECONDS:
            self._arrived.clear()
            self._client.submit(world.snapshot(), [CAMERA])
            if not self._arrived.wait(LIMIT):
                raise BenchError(f"no image of the scenery within {LIMIT:g} s")
            count += 1
        return count / (time.monotonic() - begin)

    def close(self):
        """End the worker."""
        self._client.close()


def _spawn(world, mesh, number):
    place = (GAP * (number // SIDE), GAP * (number % SIDE - SIDE / 2), 0.0)
    text = MODEL.format(name=f"ball_{number}", path=mesh.as_uri())
    world.spawn_sdf(f"ball_{number}", text, Pose(place), lambda uri: uri.replace("file://", ""))


def measure(quick, _log):
    """The first image, images per second, and the image after each of some more spawns."""
    rounds = 3 if quick else 9
    with tempfile.TemporaryDirectory() as folder:
        mesh = pathlib.Path(folder, "ball.obj")
        ball = trimesh.creation.uv_sphere(1.0, count=RINGS)
        ball.export(mesh)
        world, studio = World(), Studio()
        try:
            for number in range(MODELS):
                _spawn(world, mesh, number)
            first = studio.image(world)
            rates = [studio.rate(world) for _ in range(rounds)]
            later = []
            for number in range(MODELS, MODELS + rounds):
                _spawn(world, mesh, number)
                later.append(studio.image(world))
        finally:
            studio.close()
            world.close()
    return {
        "triangles": MODELS * len(ball.faces),
        "first_picture_s": first,
        "rate": Spread.of(rates).figures(),
        "after_spawn_s": Spread.of(later).figures(),
    }


def rows(figures):
    """The three."""
    what = f"{MODELS} models, {figures['triangles']:,} triangles"
    rate, later = Spread.read(figures["rate"]), Spread.read(figures["after_spawn_s"])
    yield Row(f"{what}: first image", f"{figures['first_picture_s']:.2f} s")
    yield Row(f"{what}: 640x480 images", f"{rate.text('.1f')} Hz", rate, "Hz")
    yield Row(f"{what}: image after a spawn", f"{later.text()} s", later, "s")
