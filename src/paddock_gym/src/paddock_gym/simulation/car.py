"""The DeepRacer on a track: its world, commands and sensors."""

import dataclasses
import math
import pathlib

from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose, multiply, quaternion_from_yaw
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors.lidar import Lidar
from deepracer_control.ackermann import Geometry, wheel_commands

from paddock_gym.course import motion_from
from paddock_gym.simulation.recipe import Spawn, of_package
from track_model import source

GEOMETRY = Geometry()
WHEELS = tuple(
    f"{side}_{end}_wheel_joint" for side in ("left", "right") for end in ("rear", "front")
)
HINGES = ("left_steering_hinge_joint", "right_steering_hinge_joint")
# of the learner's camera [px] and lidar, which looks over 300 degrees
SENSORS = {"camera_width": "160", "camera_height": "120", "lidar_samples": "64"}


def recipe(track, time_step, names=("racecar",)):
    """Recipe of the world of track_model's launch files with cars on a Track.

    Args:
        time_step: physics step [s].
        names: of the cars, which are side by side, a metre apart.
    """
    folder, cars = str(pathlib.Path(source.tracks_directory()).parent), []
    for number, name in enumerate(names):
        sensors = dict(SENSORS, robot_namespace=f"/{name}")
        alone = of_package("track_model", folder, "track.world", time_step, "racecar", **sensors)
        place = Pose((0.0, float(number), 0.0))
        cars.append(dataclasses.replace(alone.spawns[0], name=name, pose=place))
    return dataclasses.replace(alone, spawns=(*cars, Spawn("track", track.sdf())))


class Car:
    """The DeepRacer, commanded as the node `control` commands it in ackermann mode.

    Args:
        world: RobotWorld of recipe().
        model: of the car.
    """

    def __init__(self, world, model):
        self.model, self._world = model, world
        hardware = model.manager.hardware  # what the controllers write to
        self._wheels, self._hinges = map(hardware.handles, (WHEELS, HINGES))
        self._rest = None  # the car's Pose at rest

    def settled(self):
        """Store the pose of the car, which is at rest and heads along x."""
        self._rest = self.model.pose

    def drive(self, speed, steering):
        """Command speed [m/s] and the bicycle's steering angle [rad], positive to the left."""
        yaw_rate = speed * math.tan(steering) / GEOMETRY.wheelbase
        wheels = wheel_commands(speed, yaw_rate, GEOMETRY)
        speeds = (wheels.left_rear, wheels.left_front, wheels.right_rear, wheels.right_front)
        for wheel, value in zip(self._wheels, speeds):
            wheel.set_velocity(value)
        for hinge, angle in zip(self._hinges, (wheels.left_steering, wheels.right_steering)):
            hinge.set_position(angle)

    def motion(self):
        """Motion of base_link."""
        return motion_from(*self.model.link_motion(self.model.description.root))

    def place(self, x, y, yaw):
        """Put the car at rest on the ground at a pose [m], [rad], wheels straight."""
        rotation = multiply(quaternion_from_yaw(yaw), self._rest.orientation)
        self.model.set_state(Pose((x, y, self._rest.position[2]), rotation))
        self.model.joints.set_positions(dict.fromkeys(self.model.joints.names, 0.0))
        self.drive(0.0, 0.0)

    def lidar(self):
        """A function of an rng: ranges (n,) [m] of a sweep now, with the URDF's noise."""
        lidar, model, engine = Lidar(self._spec(RaySpec)), self.model, self._world.world.engine

        def scan(rng):
            position, orientation, _, _ = model.link_motion(lidar.spec.link)
            return lidar.scan(engine, position, orientation, rng)

        return scan

    def camera(self):
        """A function of a Pose of the camera relative to its mount: (120, 160, 3) uint8 RGB now."""
        spec, model, renderer = self._spec(CameraSpec), self.model, self._world.cameras.renderer
        part, mount = model.link_in_body(spec.link)
        request = CameraRequest.from_spec(spec, model.source.key, model.row(part))
        return lambda jitter=Pose(): renderer.render(request, mount * jitter)

    def _spec(self, spec_type):
        """The sensor specification of a type in the car's URDF."""
        return next(spec for spec in self.model.description.sensors if isinstance(spec, spec_type))
