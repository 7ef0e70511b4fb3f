"""The gym is the world of track_model's launch files: the same commands, the same bits."""

import math
import pathlib

import pytest
import xacro
import yaml
from bullet_sim.controllers.manager import Manager
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from deepracer_control.ackermann import Geometry, wheel_commands
from deepracer_control.drivers.pursuit import Path, Pursuit
from paddock_gym.envs.deepracer import DeepRacerEnv
from paddock_gym.envs.robot import REST
from track_model.source import tracks_directory

REAR_AXLE = -0.081663  # x in base_link [m]
SPEED, GRIP = 2.5, 4.0  # [m/s], lateral acceleration at which tires begin to slide [m/s^2]


class Launched:
    """What world.launch has: the world file's models, the track, the car with its controllers."""

    def __init__(self, track, resolve):
        share = pathlib.Path(tracks_directory()).parent
        text = (share / "worlds" / "track.world").read_text(encoding="utf-8")
        self.world = World()
        self.world.load(sdf.parse_world(text, resolve))
        urdf = xacro.process_file(str(share / "urdf" / "racecar.urdf.xacro")).toxml()
        model = pathlib.Path(track.directory, "track.sdf").read_text(encoding="utf-8")
        self.world.spawn_sdf("track", model, Pose(), resolve)
        self.car = self.world.spawn_urdf("racecar", urdf, Pose(), resolve)
        self.world.sort_before_start()
        self.manager: Manager = self.car.manager
        controllers = yaml.safe_load((share / "config" / "agent_control.yaml").read_text())
        for name, values in controllers["racecar"].items():
            self.manager.load(name, values)
        self.manager.switch(controllers["racecar"], ())

    def drive(self, speed, steering):
        """Command what the node control publishes for a /cmd_vel of the policy's driver."""
        geometry = Geometry()
        yaw_rate = speed * math.tan(steering) / geometry.wheelbase
        wheels = wheel_commands(speed, yaw_rate, geometry)
        for side in ("left", "right"):
            for end in ("rear", "front"):
                value = getattr(wheels, f"{side}_{end}")
                self.manager.command(f"{side}_{end}_wheel_velocity_controller", (value,))
            value = getattr(wheels, f"{side}_steering")
            self.manager.command(f"{side}_steering_hinge_position_controller", (value,))


def motion(model):
    """Position, quaternion and velocities of base_link, 13 numbers."""
    return [number for part in model.link_motion("base_link") for number in part]


@pytest.mark.parametrize("walls", [False, True])
def test_a_lap_is_the_same_to_the_bit(walls):
    env = DeepRacerEnv(walls=walls, randomize=())
    launched = Launched(env.task.track, env.world.recipe.resolve)
    launched.world.step(round(REST / launched.world.time_step))
    env.reset(seed=0, options={"start": 0.0})
    env.world.restore(env.saved)  # reset() has put the car to its place, from where it was
    path = Path(env.task.track.centreline, closed=True)
    driver = Pursuit(path, max_speed=SPEED, max_lateral_acceleration=GRIP)
    car, ends, speeds = env.task.car.model, [], []
    assert motion(car) == motion(launched.car)
    while not ends or not ends[-1]:
        x, y, yaw = env.task.motion[:3]
        x, y = x + REAR_AXLE * math.cos(yaw), y + REAR_AXLE * math.sin(yaw)
        speed, curvature = driver.command(x, y, yaw)
        action = env.options.actions.action(speed, math.atan(Geometry().wheelbase * curvature))
        before = env.world.world.step_count
        *_, info = env.step(action)
        launched.drive(*env.options.actions.command(action))
        launched.world.step(env.world.world.step_count - before)
        assert motion(car) == motion(launched.car), f"action {len(ends)}"
        ends.append(info["end"])
        speeds.append(env.task.motion.forward)
    assert ends[-1] == "lap" and max(speeds) > 2.0
    env.close()
    launched.world.close()
