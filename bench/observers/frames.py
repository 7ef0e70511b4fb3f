"""frames RENDERER: turns of pictures received, and of bare getCameraImage beside.

Answers once it is ready; then each line "received SECONDS" or "bare SECONDS" is a turn with one
answer. The bridge is paused while the bare camera draws.
"""

import time

import pybullet
from bullet_sim.description.specs import CameraSpec
from bullet_sim.engine import Engine
from bullet_sim.pose import Pose
from bullet_sim.render.mirror import Mirror
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors import camera
from pairs import rate_of_work

from observers import bare, graph

QUIET = 0.3  # [s] between pausing or going on and the window


class BareCamera:
    """PyBullet's getCameraImage for the car's camera, in this process.

    Args:
        world: World with the car.
        renderer: "egl" or "tiny".
    """

    def __init__(self, world, renderer):
        engine = Engine()
        chosen = engine.start_renderer(renderer)
        mirror = Mirror(engine, chosen)
        mirror.sync_sources(world.sources())
        mirror.apply(world.snapshot())
        car = world.model("racecar")
        spec = next(spec for spec in car.description.sensors if isinstance(spec, CameraSpec))
        index, offset = car.link_in_body(spec.link)
        pose = offset * Pose.from_xyz_rpy(*spec.pose)
        request = CameraRequest.from_spec(spec, car.source.key, index + 1, 1)
        request = CameraRequest(**dict(vars(request), pose=(pose.position, pose.rpy)))
        position, rotation = mirror._camera_pose(request)
        self._size = request.width, request.height
        self._options = {
            "viewMatrix": camera.view_matrix(position, rotation),
            "projectionMatrix": camera.projection_matrix(
                request.horizontal_fov, request.width / request.height, request.near, request.far
            ),
            "shadow": 0,
            "flags": pybullet.ER_NO_SEGMENTATION_MASK,
            "renderer": (
                pybullet.ER_BULLET_HARDWARE_OPENGL if chosen == "egl" else pybullet.ER_TINY_RENDERER
            ),
            "physicsClientId": engine._client,
        }
        self._engine = engine
        self.draw()  # the first one uploads textures

    def draw(self):
        """Draw one picture; returns how many that were."""
        pybullet.getCameraImage(*self._size, **self._options)
        return 1


def main(renderer):
    """Start, then turns until bench.py closes the pipe."""
    graph.join()
    pictures = graph.record("/camera/image", 4)
    graph.wait_for_controllers()
    graph.start_circle(graph.publishers())
    simulation = graph.Simulation()
    time.sleep(1.5)
    simulation.pause()
    bare_camera = BareCamera(bare.bare_world(), renderer)
    graph.say(ready=True)
    while True:
        kind, seconds = graph.hear()
        if kind == "bare":
            time.sleep(QUIET)
            graph.say(rate=rate_of_work(bare_camera.draw, float(seconds)))
            continue
        simulation.unpause()
        time.sleep(QUIET)
        begin, count = time.monotonic(), len(pictures)
        time.sleep(float(seconds))
        rate = (len(pictures) - count) / (time.monotonic() - begin)
        simulation.pause()
        graph.say(rate=rate)
