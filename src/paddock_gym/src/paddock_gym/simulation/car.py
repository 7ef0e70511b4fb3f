"""One car in a world: commands, motion, pose."""

import math

from bullet_sim.pose import Pose, multiply
from deepracer_control.ackermann import Geometry, wheel_commands

from paddock_gym.course import motion_from
from paddock_gym.simulation import description

GEOMETRY = Geometry()
WHEELS = tuple(
    f"{side}_{end}_wheel_joint" for side in ("left", "right") for end in ("rear", "front")
)
HINGES = ("left_steering_hinge_joint", "right_steering_hinge_joint")


class Car:
    """The DeepRacer, commanded as the node `control` commands it in ackermann mode.

    Args:
        pose: bullet_sim.pose.Pose to spawn it at.
    """

    def __init__(self, world, name, pose, urdf):
        self._world = world
        self.model = world.spawn_urdf(name, urdf, pose, description.resolve)
        hardware = self.model.manager.hardware  # what the controllers write to
        self._wheels, self._hinges = map(hardware.handles, (WHEELS, HINGES))
        self._root = self.model.description.root
        self._rest = None  # height and tilt of the car at rest

    def settled(self):
        """Store height and tilt of the car, which is at rest and heads along x."""
        pose = self.model.pose
        self._rest = pose.position[2], pose.orientation

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
        return motion_from(*self.model.link_motion(self._root))

    def place(self, x, y, yaw):
        """Put the car at rest on the ground at a pose [m], [rad], wheels straight."""
        height, tilt = self._rest
        rotation = (0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))
        self.model.set_state(Pose((x, y, height), multiply(rotation, tilt)))
        self.model.joints.set_positions(dict.fromkeys(self.model.joints.names, 0.0))
        self.drive(0.0, 0.0)

    def touched(self, harmless):
        """Whether the car has a contact that counts as a crash.

        Args:
            harmless: set of links, as (number of the body, name), whose contacts do not count.
        """
        body = self.model.body
        return any(
            (touch.body, touch.other) not in harmless and touch.body != body.number
            for touch in body.touching()
        )
