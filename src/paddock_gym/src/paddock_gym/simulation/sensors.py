"""The car's lidar and camera in the world, and an observer camera."""

import math

from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors.lidar import Lidar

OBSERVER_SIZE = (480, 360)  # [px]
# In the car's frame.
OBSERVER_POSE = Pose.from_xyz_rpy((-0.75, 0.0, 0.55), (0.0, math.radians(25.0), 0.0))
OBSERVER_FOV = math.radians(70.0)
CLIP = (0.02, 300.0)  # near and far plane of the images [m]


def spec_of(car, spec_type):
    """The sensor specification of a type in the car's URDF."""
    return next(spec for spec in car.model.description.sensors if isinstance(spec, spec_type))


class CarLidar:
    """The lidar of the URDF; each scan() is one sweep."""

    def __init__(self, world, car):
        self._engine, self._model = world.engine, car.model
        self._lidar = Lidar(spec_of(car, RaySpec))

    def scan(self, rng):
        """Ranges (n,) [m] of a sweep now, with the URDF's noise."""
        position, orientation, _, _ = self._model.link_motion(self._lidar.spec.link)
        # an object closer than range_min touches the car, whose run is over then
        return self._lidar.scan(
            self._engine, position, orientation, rng, self._model.body.number, too_near=False
        )


class CarCamera:
    """The camera of the URDF."""

    def __init__(self, renderer, car):
        self._renderer, spec = renderer, spec_of(car, CameraSpec)
        model = car.model
        part, self._mount = model.link_in_body(spec.link)
        self._request = CameraRequest.from_spec(spec, model.source.key, model.row(part))

    def image(self, jitter=Pose()):
        """Render (120, 160, 3) uint8 RGB now.

        Args:
            jitter: Pose of the camera relative to its mount.
        """
        return self._renderer.render(self._request, self._mount * jitter)


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
