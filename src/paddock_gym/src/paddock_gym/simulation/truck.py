"""The Cyber Truck with or without its trailer on a plane."""

import pathlib

import yaml
from bullet_sim.pose import Pose, multiply, quaternion_from_yaw
from cybertruck.drive.model import CyberModel, RateLimiter, TruckGeometry
from cybertruck.trailer import paths
from cybertruck.trailer.geometry import Geometry
from cybertruck.trailer.kinematics import rear_axle

from paddock_gym.simulation.recipe import of_package
from paddock_gym.simulation.robot_world import RobotWorld

DRIVE_PERIOD = 0.008  # of the drive node, whose rate limits apply [s]
TIME_STEP = 0.004  # [s]; drives end within 0.04 % of where the worlds' 1 ms leads
PERIODS = 12  # of the drive node in an action
NAME, HITCH = "cybertruck", "hitch_yaw_joint"
HINGES = ("front_left_steer_joint", "front_right_steer_joint")
REAR = ("rear_left_wheel_joint", "rear_right_wheel_joint")
SETTLING = 1.0  # [s]


def share_folder():
    """Folder of cybertruck's files: urdf, config, meshes."""
    module = pathlib.Path(paths.__file__).resolve()
    source, installed = module.parents[3], module.parents[5] / "share" / NAME
    return source if (source / "urdf").is_dir() else installed


def recipe(trailer=True):
    """Recipe of the truck, with or without trailer, on a plane."""
    arguments = {"trailer": str(trailer).lower(), "lidar": "false"}
    return of_package(NAME, str(share_folder()), "plane.world", TIME_STEP, NAME, **arguments)


class Truck:
    """The truck, driven as the node `drive` drives it.

    Args:
        world: RobotWorld of recipe().
    """

    def __init__(self, world):
        text = (share_folder() / "config" / "truck.yaml").read_text(encoding="utf-8")
        values = yaml.safe_load(text)
        names = ("wheelbase", "hitch_offset", "tongue_length", "max_steering")
        self.geometry = Geometry(**{name: values[name] for name in names})
        truck = TruckGeometry(**values)
        self._kinematics, self._limiter = CyberModel(truck), RateLimiter(truck)
        self._world, self._model = world, world.world.model(NAME)
        hardware = self._model.manager.hardware
        self._rear, self._hinges = map(hardware.handles, (REAR, HINGES))
        self._write(0.0, 0.0)

    @classmethod
    def settled(cls, trailer=True):
        """(Truck at rest in a world of its own, state of the world then)."""
        truck = cls(RobotWorld(recipe(trailer)))
        truck._world.advance(round(SETTLING / TIME_STEP))
        truck.rested()
        return truck, truck._world.save()

    def rested(self):
        """Store the pose of the truck, which is at rest; time begins."""
        self._world.world.step_count, self._rest = 0, self._model.pose

    def place(self, x, y, trailer_heading, hitch_angle):
        """Put the trailer's axle at a pose [m], [rad] with a hitch angle [rad], at rest."""
        self.place_truck(*rear_axle(x, y, trailer_heading, hitch_angle, self.geometry))
        self._model.joints.set_positions({HITCH: float(hitch_angle)})

    def place_truck(self, x, y, heading):
        """Put the truck's rear axle at a pose [m], [rad], at rest, with a hitch angle of 0."""
        rotation = multiply(quaternion_from_yaw(float(heading)), self._rest.orientation)
        self._model.set_state(Pose((float(x), float(y), self._rest.position[2]), rotation))
        self._model.joints.set_positions(dict.fromkeys(self._model.joints.names, 0.0))
        self._limiter.reset()
        self._write(0.0, 0.0)

    def rear_axle_pose(self):
        """(x, y [m], heading [rad]) of the truck's rear axle."""
        pose = self._model.pose
        return (*pose.position[:2], pose.rpy[2])

    def trailer_axle_pose(self):
        """(x, y [m], heading [rad]) of the trailer's axle."""
        pose = self._model.link_state("trailer_axle")[0]
        return (*pose.position[:2], pose.rpy[2])

    def hitch_angle(self):
        """Angle between trailer and truck [rad]."""
        return self._model.joints.positions_of([HITCH])[0]

    def drive(self, steering, speed, periods=PERIODS):
        """Drive for one action, or some periods, with a steering angle [rad] and a speed [m/s]."""
        for _ in range(periods):
            self._write(*self._limiter.advance(steering, speed, DRIVE_PERIOD))
            self._world.advance(round(DRIVE_PERIOD / TIME_STEP))

    def _write(self, steering, speed):
        wheels = self._kinematics.wheels(steering, speed)
        for hinge, angle in zip(self._hinges, (wheels.left_steering, wheels.right_steering)):
            hinge.set_position(angle)
        for wheel, rate in zip(self._rear, (wheels.left_rear, wheels.right_rear)):
            wheel.set_velocity(rate)

    def restore(self, state):
        """Return to a state of settled()."""
        self._world.restore(state)

    def close(self):
        """Free the engine."""
        self._world.close()
