"""The Cyber Truck in a world of the core, driven by its own kinematics: no ROS, no waiting."""

from pathlib import Path

import numpy as np
import xacro
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from cybertruck.drive.model import CyberModel, RateLimiter, TruckGeometry
from cybertruck.drive.odometry import Measured

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "cybertruck"
PERIOD = 8  # physics steps of 1 ms between commands, as the drive node's joint states
ITERATIONS = 200  # of the solver, as worlds/yard.world
LIFTED = 2e-4  # [m]; at rest a wheel is 0.15 mm in the ground
HINGES = ("front_left_steer_joint", "front_right_steer_joint")
REAR = ("rear_left_wheel_joint", "rear_right_wheel_joint")
FRONT = ("front_left_wheel_joint", "front_right_wheel_joint")


def description(**arguments):
    """Returns the URDF text; arguments as of urdf/cybertruck.urdf.xacro."""
    path = PACKAGE / "urdf" / "cybertruck.urdf.xacro"
    return xacro.process_file(str(path), mappings=arguments).toxml()


def resolve(uri):
    """Returns the file of a package:// URI."""
    return uri.replace("package://cybertruck", str(PACKAGE))


class Truck:
    """A truck at the origin, its controllers running.

    Args:
        trailer: With or without.
        world_file: SDF world, by default an endless floor.
    """

    def __init__(self, trailer, world_file=None):
        self.world = World()
        if world_file is None:
            self.world.engine.set_solver_iterations(ITERATIONS)
            self.world.spawn(sdf.ground_plane())
        else:
            self.world.load(sdf.parse_world(Path(world_file).read_text(), resolve))
        self.model = self.world.spawn_urdf(
            "cybertruck",
            description(trailer=str(trailer).lower(), trailer_lidar="true"),
            Pose(),
            resolve,
        )
        manager = self.model.manager
        manager.load(
            "steering",
            {"type": "position_controllers/JointGroupPositionController", "joints": list(HINGES)},
        )
        manager.load(
            "axle",
            {"type": "velocity_controllers/JointGroupVelocityController", "joints": list(REAR)},
        )
        manager.switch(["steering", "axle"], [])
        self.kinematics = CyberModel(TruckGeometry())
        self.limiter = RateLimiter(TruckGeometry())
        self.wheels = [name for name in self.model.link_names if name.endswith("_wheel")]
        self.drive(0.0, 0.0, 0.5)
        self._settled, self._stood = self.world.save_state(), self._wheel_heights()

    def settle(self):
        """Puts all back to where it was when the truck was made."""
        assert self.world.restore_state(self._settled) == ""
        self.limiter.reset()

    def command(self, steering, speed):
        """Hands one command to hinges and wheels, within the rates of one period."""
        targets = self.kinematics.wheels(
            *self.limiter.advance(steering, speed, PERIOD * self.world.time_step)
        )
        self.model.manager.command("steering", [targets.left_steering, targets.right_steering])
        self.model.manager.command("axle", [targets.left_rear, targets.right_rear])

    def drive(self, steering, speed, seconds, each=None, every=PERIOD):
        """Drives for a time.

        Args:
            steering: Bicycle's angle [rad].
            speed: [m/s].
            seconds: Simulated time.
            each: Called without arguments after every `every` physics steps.
            every: A divisor of PERIOD.
        """
        for _ in range(round(seconds / (PERIOD * self.world.time_step))):
            self.command(steering, speed)
            for _ in range(PERIOD // every if each else 1):
                self.world.step(every if each else PERIOD)
                if each:
                    each()

    def joints(self):
        """Returns dicts of joint name -> position [rad] and -> velocity [rad/s]."""
        positions, velocities, _ = self.model.joints.arrays()
        names = self.model.joints.names
        return dict(zip(names, positions)), dict(zip(names, velocities))

    def measured(self):
        """Returns odometry's input."""
        positions, velocities = self.joints()
        return Measured(
            *(positions[name] for name in REAR + HINGES), *(velocities[name] for name in REAR)
        )

    @property
    def position(self):
        """World position (3,) of base_footprint [m]."""
        return np.array(self.model.pose.position)

    @property
    def yaw(self):
        """Heading [rad]."""
        return self.model.pose.rpy[2]

    def lifted(self):
        """Lists the wheels that are above where they stood when the truck was made."""
        heights = self._wheel_heights()
        return [name for name, height in heights.items() if height - self._stood[name] > LIFTED]

    def _wheel_heights(self):
        return {name: self.model.link_state(name)[0].position[2] for name in self.wheels}
