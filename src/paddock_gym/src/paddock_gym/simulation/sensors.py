"""The car's lidar and camera in the world, and a camera for onlookers."""

import math

from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors.lidar import Lidar

ONLOOKER_SIZE = (480, 360)  # [px]
ONLOOKER = Pose.from_xyz_rpy((-0.75, 0.0, 0.55), (0.0, math.radians(25.0), 0.0))  # from the car
ONLOOKER_FOV = math.radians(70.0)
CLIP = (0.02, 300.0)  # of the pictures [m]


def spec_of(car, kind):
    """The sensor specification of a kind that the car's URDF has."""
    return next(spec for spec in car.model.description.sensors if isinstance(spec, kind))


class CarLidar:
    """The lidar of the URDF, a sweep whenever it is asked for.

    Args:
        world: World.
        car: Car.
    """

    def __init__(self, world, car):
        self._engine, self._model = world.engine, car.model
        self._lidar = Lidar(spec_of(car, RaySpec))

    def scan(self, rng):
        """Ranges (n,) [m] of a sweep now, with the URDF's noise.

        Args:
            rng: numpy.random.Generator.
        """
        position, orientation, _, _ = self._model.link_motion(self._lidar.spec.link)
        # what is nearer than range_min touches the car, whose run is over then
        return self._lidar.scan(
            self._engine, position, orientation, rng, self._model.body, too_near=False
        )


class CarCamera:
    """The camera of the URDF.

    Args:
        painter: Painter of the world.
        car: Car.
    """

    def __init__(self, painter, car):
        self._painter, spec = painter, spec_of(car, CameraSpec)
        model = car.model
        index, self._mount = model.link_in_body(spec.link)
        self._request = CameraRequest.from_spec(spec, model.source.key, index + 1)

    def picture(self, jitter=Pose()):
        """(120, 160, 3) uint8 RGB as the camera sees now.

        Args:
            jitter: Pose of the camera beside its mount.
        """
        return self._painter.picture(self._request, self._mount * jitter)


class Onlooker:
    """Looks at a car from behind and above.

    Args:
        painter: Painter of the world.
        car: Car.
    """

    def __init__(self, painter, car):
        self._painter, self._car = painter, car
        nowhere = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        self._request = CameraRequest(
            "onlooker", None, 0, nowhere, *ONLOOKER_SIZE, ONLOOKER_FOV, *CLIP
        )

    def picture(self):
        """(360, 480, 3) uint8 RGB."""
        motion = self._car.motion()
        frame = Pose.from_xyz_rpy((motion.x, motion.y, 0.0), (0.0, 0.0, motion.yaw))
        return self._painter.picture(self._request, frame * ONLOOKER)
