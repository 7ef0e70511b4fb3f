"""The truck with its trailer in the simulation core, without ROS: description, wheels, controller.

The tracker gets the true poses. Commands are processed as in the drive node: at its period, through
its rate limits and wheel geometry, to the same controllers.
"""

import numpy as np
import yaml
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from cybertruck.drive.model import CyberModel, RateLimiter, TruckGeometry
from cybertruck.trailer.geometry import Geometry
from cybertruck.trailer.kinematics import rear_axle
from truck_sim import PACKAGE, description, resolve

DRIVE_PERIOD = 0.008  # of the drive node [s]
CONTROL_PERIODS = 4  # periods of the drive node in one of the tracker
HITCH = "hitch_yaw_joint"


def truck_numbers():
    """Contents of config/truck.yaml."""
    return yaml.safe_load((PACKAGE / "config" / "truck.yaml").read_text())


def truck_geometry():
    """The trailer's Geometry of config/truck.yaml."""
    numbers = truck_numbers()
    return Geometry(
        **{
            name: numbers[name]
            for name in ("wheelbase", "hitch_offset", "tongue_length", "max_steering")
        }
    )


class Rig:
    """Truck and trailer on a plane."""

    def __init__(self, time_step=0.001):
        """Takes the physics step [s]; 1 ms is that of the worlds."""
        self._steps = round(DRIVE_PERIOD / time_step)
        self.geometry = truck_geometry()
        numbers = TruckGeometry(**truck_numbers())
        self._model, self._limiter = CyberModel(numbers), RateLimiter(numbers)
        self.world = World(time_step)
        self.world.spawn(sdf.ground_plane())
        text = description(trailer="true", lidar="false")
        self.truck = self.world.spawn_urdf("cybertruck", text, Pose(), resolve)
        config = yaml.safe_load((PACKAGE / "config" / "controllers.yaml").read_text())
        names = ("steering_controller", "axle_controller")
        for name in names:
            self.truck.manager.load(name, config["cybertruck"][name])
        self.truck.manager.switch(list(names), [])

    def close(self):
        """Frees the engine."""
        self.world.close()

    def place(self, x, y, trailer_heading, hitch_angle):
        """Puts the trailer's axle at a pose [m, m, rad] with a hitch angle [rad], and settles."""
        self.world.reset()
        rear_x, rear_y, heading = rear_axle(x, y, trailer_heading, hitch_angle, self.geometry)
        self.truck.set_state(Pose.from_xyz_rpy((rear_x, rear_y, 0.0), (0.0, 0.0, heading)))
        self.truck.joints.set_positions({HITCH: hitch_angle})
        self._limiter.reset()
        self.drive(0.0, 0.0, 0.2)

    def state(self):
        """x, y of the rear axle [m], θ1 and ψ [rad], as an array (4,)."""
        pose = self.truck.pose
        hitch_angle = self.truck.joints.positions_of([HITCH])[0]
        return np.array((*pose.position[:2], pose.rpy[2], hitch_angle))

    def trailer(self):
        """(x, y [m], θ2 [rad]) of the trailer's axle, from its own link."""
        pose, _, _ = self.truck.link_state("trailer_axle")
        return (*pose.position[:2], pose.rpy[2])

    def drive(self, steering, speed, seconds):
        """Drives with a steering angle [rad] and a speed [m/s] for a time [s]."""
        period = DRIVE_PERIOD
        for _ in range(max(1, round(seconds / period))):
            turned, rolled = self._limiter.advance(steering, speed, period)
            targets = self._model.wheels(turned, rolled)
            manager = self.truck.manager
            manager.command("steering_controller", (targets.left_steering, targets.right_steering))
            manager.command("axle_controller", (targets.left_rear, targets.right_rear))
            self.world.step(self._steps)

    def back_up(self, tracker, time_limit):
        """Drives with a tracker until it ends.

        Returns:
            (n, 5) array: arc [m], lateral error [m], heading error [rad], ψ [rad], mode. The last
            row is where the rig came to rest.
        """
        period = CONTROL_PERIODS * DRIVE_PERIOD
        rows, still = [], 0
        for _ in range(round(time_limit / period)):
            hitch_angle = self.state()[3]
            status = tracker.step(*self.trailer(), hitch_angle)
            rows.append((status.arc, status.lateral, status.heading, hitch_angle, status.mode))
            still = still + 1 if status.speed == 0.0 else 0
            if still * period > 0.5:
                break
            self.drive(float(status.steering), float(status.speed), period)
        return np.array(rows, dtype=float)
