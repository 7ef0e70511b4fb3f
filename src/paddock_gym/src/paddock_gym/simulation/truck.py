"""The Cyber Truck with or without its trailer on a plane."""

import dataclasses
import pathlib

import xacro
import yaml
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose, multiply, quaternion_from_rpy
from cybertruck.drive.model import CyberModel, RateLimiter, TruckGeometry
from cybertruck.trailer import paths
from cybertruck.trailer.geometry import Geometry
from cybertruck.trailer.kinematics import rear_axle

from paddock_gym.simulation.scene import make_world

DRIVE_PERIOD = 0.008  # of the drive node, whose rate limits apply [s]
TIME_STEP = 0.004  # [s]; drives end within 0.04 % of where the worlds' 1 ms leads
PERIODS = 12  # of the drive node in an action
HITCH = "hitch_yaw_joint"
HINGES = ("front_left_steer_joint", "front_right_steer_joint")
REAR = ("rear_left_wheel_joint", "rear_right_wheel_joint")
SETTLING = 1.0  # [s]


def share_folder():
    """Folder of cybertruck's files: urdf, config, meshes."""
    module = pathlib.Path(paths.__file__).resolve()
    source, installed = module.parents[3], module.parents[5] / "share" / "cybertruck"
    return source if (source / "urdf").is_dir() else installed


class Truck:
    """The truck, with or without trailer, driven as the node `drive` drives it.

    Args:
        trailer: with or without.

    Attributes:
        period: of an action [s].
    """

    def __init__(self, trailer=True):
        folder = share_folder()
        values = yaml.safe_load((folder / "config" / "truck.yaml").read_text(encoding="utf-8"))
        names = ("wheelbase", "hitch_offset", "tongue_length", "max_steering")
        self.geometry = Geometry(**{name: values[name] for name in names})
        self.period = PERIODS * DRIVE_PERIOD
        truck = TruckGeometry(**values)
        self._kinematics, self._limiter = CyberModel(truck), RateLimiter(truck)
        self.world = make_world()
        text = (folder / "worlds" / "plane.world").read_text(encoding="utf-8")
        described = sdf.parse_world(text, self._resolve)
        self.world.load(dataclasses.replace(described, step=TIME_STEP))
        text = xacro.process_file(
            str(folder / "urdf" / "cybertruck.urdf.xacro"),
            mappings={"trailer": str(trailer).lower(), "lidar": "false"},
        ).toxml()
        self.model = self.world.spawn_urdf("cybertruck", text, Pose(), self._resolve)
        self.world.engine.unlocked = True  # one thread alone has this world
        self._rear, self._hinges = map(self.model.manager.hardware.handles, (REAR, HINGES))
        self._write(0.0, 0.0)
        self.world.step(round(SETTLING / TIME_STEP))
        self.world.step_count = 0
        self._rest_pose, self._rest_state = self.model.pose, self.world.save_state()

    @staticmethod
    def _resolve(uri):
        return uri.replace("package://cybertruck", str(share_folder()))

    def place(self, x, y, trailer_heading, hitch_angle):
        """Put the trailer's axle at a pose [m], [rad] with a hitch angle [rad], at rest."""
        self.place_truck(*rear_axle(x, y, trailer_heading, hitch_angle, self.geometry))
        self.model.joints.set_positions({HITCH: float(hitch_angle)})

    def place_truck(self, x, y, heading):
        """Put the truck's rear axle at a pose [m], [rad], at rest, with a hitch angle of 0."""
        self.world.restore_state(self._rest_state)
        rotation = quaternion_from_rpy(0.0, 0.0, float(heading))
        position = (float(x), float(y), self._rest_pose.position[2])
        self.model.set_state(Pose(position, multiply(rotation, self._rest_pose.orientation)))
        self.model.joints.set_positions(dict.fromkeys(self.model.joints.names, 0.0))
        self._limiter.reset()
        self._write(0.0, 0.0)

    def rear_axle_pose(self):
        """(x, y [m], heading [rad]) of the truck's rear axle."""
        pose = self.model.pose
        return (*pose.position[:2], pose.rpy[2])

    def trailer_axle_pose(self):
        """(x, y [m], heading [rad]) of the trailer's axle."""
        pose = self.model.link_state("trailer_axle")[0]
        return (*pose.position[:2], pose.rpy[2])

    def hitch_angle(self):
        """Angle between trailer and truck [rad]."""
        return self.model.joints.positions_of([HITCH])[0]

    def drive(self, steering, speed, periods=PERIODS):
        """Drive for one action, or some periods, with a steering angle [rad] and a speed [m/s]."""
        for _ in range(periods):
            self._write(*self._limiter.advance(steering, speed, DRIVE_PERIOD))
            self.world.step(round(DRIVE_PERIOD / TIME_STEP))

    def _write(self, steering, speed):
        wheels = self._kinematics.wheels(steering, speed)
        for hinge, angle in zip(self._hinges, (wheels.left_steering, wheels.right_steering)):
            hinge.set_position(angle)
        for wheel, rate in zip(self._rear, (wheels.left_rear, wheels.right_rear)):
            wheel.set_velocity(rate)

    def close(self):
        """Free the engine."""
        self.world.close()
