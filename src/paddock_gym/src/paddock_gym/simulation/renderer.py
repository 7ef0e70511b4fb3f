"""Images of a world, rendered in this process."""

import dataclasses
import math
import os

from bullet_sim.errors import RenderError
from bullet_sim.pose import Pose
from bullet_sim.render.gl.renderer import GlRenderer
from bullet_sim.render.request import CameraRequest, Quality

OBSERVER_SIZE = (480, 360)  # [px]
# In the car's frame.
OBSERVER_POSE = Pose.from_xyz_rpy((-0.75, 0.0, 0.55), (0.0, math.radians(25.0), 0.0))
OBSERVER_FOV = math.radians(70.0)
CLIP = (0.02, 300.0)  # near and far plane of the images [m]
QUALITY = Quality(shadows="false", antialias="false")


class SceneRenderer:
    """Renders images of a world.

    Args:
        world: bullet_sim.world.World; models may be spawned later.

    Attributes:
        backend: "gl" or "tiny".
    """

    def __init__(self, world):
        self._world, self._count = world, 0
        # Mesa renders in the thread that asks it: an observation is too small for several
        os.environ.setdefault("LP_NUM_THREADS", "0")
        try:
            self._renderer, self.backend = GlRenderer(QUALITY), "gl"
        except RenderError:
            from bullet_sim.render.pybullet_renderer import PyBulletRenderer

            self._renderer, self.backend = PyBulletRenderer(), "tiny"

    def render(self, request, pose):
        """Render a camera's image of the world now.

        Args:
            request: CameraRequest; its pose is not used.
            pose: bullet_sim.pose.Pose of the camera in the link or world.

        Returns:
            (H, W, 3) uint8 RGB, top row first.
        """
        request_at = dataclasses.replace(request, pose=(pose.position, pose.rpy))
        return self.render_with_depth(request_at)[0]

    def render_with_depth(self, request):
        """As render(), from the request's pose; and its depths (H, W) float32 [m], or None."""
        if len(self._world.models) != self._count:
            self._count = len(self._world.models)
            self._renderer.sync_sources(self._world.sources(), self._world.scene)
        self._renderer.apply(self._world.snapshot())
        return self._renderer.render_with_depth(request, self._world.step_count)

    def close(self):
        """Free the renderer."""
        self._renderer.close()


class ObserverCamera:
    """A camera behind and above what has a motion(): a function of a Motion without arguments."""

    def __init__(self, renderer, motion):
        self._renderer, self._motion = renderer, motion
        nowhere = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        self._request = CameraRequest(
            "observer", None, 0, nowhere, *OBSERVER_SIZE, OBSERVER_FOV, *CLIP
        )

    def image(self):
        """(360, 480, 3) uint8 RGB."""
        motion = self._motion()
        frame = Pose.from_xyz_rpy((motion.x, motion.y, 0.0), (0.0, 0.0, motion.yaw))
        return self._renderer.render(self._request, frame * OBSERVER_POSE)
