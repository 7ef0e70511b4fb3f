"""The reference: PyBullet's stepping alone, in this process, of the world that the bridge has."""

import pathlib

import rospkg
import rospy
import yaml
from bullet_sim.pose import Pose
from bullet_sim.world import World
from gazebo_msgs.srv import GetPhysicsProperties
from pairs import rate_of_work
from worlds.ground import GROUND

from observers.circle import COMMANDS

STEPS_A_CALL = 100
CAR = {"model": "racecar", "description": "/robot_description", "namespace": "/racecar", "x": 0.0}


def resolve(uri):
    """Path of a package:// or file:// URI's file; a path as it is."""
    scheme, _, rest = uri.partition("://")
    if scheme != "package":
        return rest or uri
    package, _, path = rest.partition("/")
    return str(pathlib.Path(rospkg.RosPack().get_path(package), path))


def bare_world(cars=(CAR,), track=True):
    """The core with the physics, track, cars and commands of a running bridge.

    The joints are driven by PyBullet's own motors, whatever controllers the bridge has.

    Args:
        cars: dicts of model (name), description (ROS parameter with the URDF), x (place ahead of
            the start [m]).
        track: the track's ground, or a plain one.

    Returns:
        World; close it at the end.
    """
    share = pathlib.Path(rospkg.RosPack().get_path("track_model"))
    controllers = yaml.safe_load((share / "config" / "agent_control.yaml").read_text())["racecar"]
    physics = rospy.ServiceProxy("/gazebo/get_physics_properties", GetPhysicsProperties)()
    gravity = physics.gravity
    world = World(physics.time_step, (gravity.x, gravity.y, gravity.z))
    if track:
        world.spawn_sdf("track", rospy.get_param("/track_description"), Pose(), resolve)
    else:
        world.spawn_sdf("ground", GROUND, Pose(), resolve)
    for car in cars:
        model = world.spawn_urdf(
            car["model"], rospy.get_param(car["description"]), Pose((car["x"], 0.0, 0.0)), resolve
        )
        for name, _ in COMMANDS:
            model.manager.load(name, controllers[name])
        model.manager.switch([name for name, _ in COMMANDS], [])
        for name, value in COMMANDS:
            model.manager.command(name, [value])
    return world


def speed_of(world, name="racecar"):
    """Speed of a car over the ground [m/s]."""
    car = world.model(name)
    linear = car.link_state(car.description.root)[1]
    return float((linear[0] ** 2 + linear[1] ** 2) ** 0.5)


def pace_of(world, seconds):
    """Simulated seconds per wall second of stepping for some wall time [s]."""

    def work():
        world.engine.step(STEPS_A_CALL)
        return STEPS_A_CALL * world.time_step

    return rate_of_work(work, seconds)
