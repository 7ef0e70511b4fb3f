"""Pictures of a world in this process: OpenGL, or PyBullet's TinyRenderer where there is none."""

import dataclasses

from bullet_sim.engine import Engine
from bullet_sim.errors import RenderError
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.pybullet_renderer import Mirror
from bullet_sim.render.request import Quality

QUALITY = Quality(shadows="false", antialias="false")


class Painter:
    """Draws a world.

    Args:
        world: bullet_sim.world.World; models may still come.

    Attributes:
        kind: "gl" or "tiny".
    """

    def __init__(self, world):
        self._world, self._count = world, 0
        try:
            self._renderer, self.kind = GlRenderer(QUALITY), "gl"
        except RenderError:
            self._renderer, self.kind = _tiny(), "tiny"

    def picture(self, request, pose):
        """A camera's picture of the world now.

        Args:
            request: CameraRequest; its own pose does not count.
            pose: bullet_sim.pose.Pose of the camera in the link or world.

        Returns:
            (H, W, 3) uint8 RGB, top row first.
        """
        if len(self._world.models) != self._count:
            self._count = len(self._world.models)
            self._renderer.sync_sources(self._world.sources(), self._world.scene)
        self._renderer.apply(self._world.snapshot())
        placed = dataclasses.replace(request, pose=(pose.position, pose.rpy))
        return self._renderer.render(placed, self._world.step_count)

    def close(self):
        """Free the renderer."""
        self._renderer.close()


def _tiny():
    engine = Engine()
    return Mirror(engine, engine.start_renderer("tiny"))
