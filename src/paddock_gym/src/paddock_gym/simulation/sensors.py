"""The car's lidar and camera in the world, and a camera for onlookers."""

import math

import numpy as np
from bullet_sim.description.specs import CameraSpec, RaySpec
from bullet_sim.pose import Pose
from bullet_sim.sensors import camera
from bullet_sim.sensors.lidar import Lidar

ONLOOKER_SIZE = (480, 360)  # [px]
ONLOOKER = Pose.from_xyz_rpy((-0.75, 0.0, 0.55), (0.0, math.radians(25.0), 0.0))  # from the car
ONLOOKER_FOV = math.radians(70.0)
CLIP = (0.02, 60.0)  # of the pictures [m]


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
        return self._lidar.scan(self._engine, position, orientation, rng, self._model.body)


class CarCamera:
    """The camera of the URDF.

    Args:
        world: World.
        car: Car.
    """

    def __init__(self, world, car):
        self._engine, self._model = world.engine, car.model
        self._spec = spec_of(car, CameraSpec)
        self._engine.start_renderer("tiny")
        self.jitter = Pose()  # of the mount, in the camera's frame

    def picture(self):
        """(120, 160, 3) uint8 RGB as the camera sees now."""
        spec = self._spec
        frame = self._model.link_state(spec.link)[0] * self.jitter
        view = camera.view_matrix(frame.position, frame.matrix)
        projection = camera.projection_matrix(
            spec.horizontal_fov, spec.width / spec.height, CLIP[0], CLIP[1]
        )
        return self._engine.render(spec.width, spec.height, view, projection)


def onlooker_picture(world, car):
    """(360, 480, 3) uint8 RGB from behind and above the car."""
    world.engine.start_renderer("tiny")
    x, y, _ = car.model.pose.position
    yaw = car.motion().yaw
    frame = Pose.from_xyz_rpy((x, y, 0.0), (0.0, 0.0, yaw)) * ONLOOKER
    width, height = ONLOOKER_SIZE
    view = camera.view_matrix(np.array(frame.position), frame.matrix)
    projection = camera.projection_matrix(ONLOOKER_FOV, width / height, *CLIP)
    return world.engine.render(width, height, view, projection)
