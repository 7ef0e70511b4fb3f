"""What the observers share: joining the graph, topics, the car's circle, the bare core."""

import json
import os
import socket
import struct
import sys
import time
from urllib.parse import urlparse

import rospkg
import rospy
from bullet_bridge.resolve import Resolver
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.pose import Pose
from bullet_sim.world import World
from controller_manager_msgs.srv import ListControllers
from gazebo_msgs.srv import GetModelState, GetWorldProperties
from std_msgs.msg import Float64

WHEELS = [f"{side}_{end}_wheel" for side in ("left", "right") for end in ("rear", "front")]
HINGES = [f"{side}_steering_hinge" for side in ("left", "right")]
SPEED, ANGLE = 20.0, 0.25  # wheel speed [rad/s], hinge angle [rad]: a circle
COMMANDS = [(f"{name}_velocity_controller", SPEED) for name in WHEELS] + [
    (f"{name}_position_controller", ANGLE) for name in HINGES
]
CONTROLLERS = 7
START_LIMIT = 120.0  # [s]
STEPS_A_CALL = 100  # of the bare core


def say(**values):
    """Answer bench.py."""
    print(json.dumps(values), flush=True)


def hear():
    """The next line from bench.py, or exit when it has gone."""
    line = sys.stdin.readline()
    if not line:
        os._exit(0)
    return line.split()


def join():
    """Become a node, without a subscription to /clock of its own."""
    address = urlparse(os.environ["ROS_MASTER_URI"])
    limit = time.monotonic() + START_LIMIT
    while True:
        try:
            socket.create_connection((address.hostname, address.port), 1).close()
            break
        except OSError:
            if time.monotonic() > limit:
                sys.exit("observer: no master")
            time.sleep(0.02)
    rospy.init_node(
        "bench", anonymous=True, disable_rostime=True, disable_rosout=True, disable_signals=True
    )


def record(topic, offset=None):
    """Subscribe to raw messages; returns the list that gets (receipt [s], stamp [s]).

    Args:
        offset: of the stamp in the serialised message [bytes]; None: no stamp is read.
    """
    found = []

    def take(message):
        now = time.monotonic()
        stamp = 0.0
        if offset is not None:
            seconds, nanoseconds = struct.unpack_from("<II", message._buff, offset)
            stamp = seconds + nanoseconds * 1e-9
        found.append((now, stamp))

    rospy.Subscriber(topic, rospy.AnyMsg, take, buff_size=1 << 22, tcp_nodelay=True)
    return found


def running_controllers(namespace="/racecar"):
    """How many controllers run; 0 while the manager is not there."""
    try:
        listed = rospy.ServiceProxy(
            f"{namespace}/controller_manager/list_controllers", ListControllers
        )()
    except (rospy.ServiceException, rospy.ROSException):
        return 0
    return sum(controller.state == "running" for controller in listed.controller)


def wait_for_controllers():
    """Returns when all controllers run, as time.monotonic."""
    limit = time.monotonic() + START_LIMIT
    while running_controllers() < CONTROLLERS:
        if time.monotonic() > limit:
            sys.exit(f"observer: {running_controllers()} of {CONTROLLERS} controllers run")
        time.sleep(0.03)
    return time.monotonic()


def publishers(namespace="/racecar"):
    """[(publisher, value)] of the circle."""
    return [
        (rospy.Publisher(f"{namespace}/{name}/command", Float64, queue_size=1), value)
        for name, value in COMMANDS
    ]


def start_circle(outputs):
    """Send the circle's commands once all of them are heard."""
    limit = time.monotonic() + START_LIMIT
    for publisher, _ in outputs:
        while not publisher.get_num_connections():
            if time.monotonic() > limit:
                sys.exit(f"observer: nobody listens to {publisher.name}")
            time.sleep(0.01)
    for publisher, value in outputs:
        publisher.publish(value)


def car_speed(name="racecar"):
    """Speed of the car over the ground [m/s]."""
    state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)(name, "")
    return (state.twist.linear.x**2 + state.twist.linear.y**2) ** 0.5


def sim_time():
    """Simulated time [s]."""
    return rospy.ServiceProxy("/gazebo/get_world_properties", GetWorldProperties)().sim_time


def pace_of_bridge(seconds):
    """(simulated seconds per wall second, simulated seconds) of a window of wall time [s]."""
    sim, begin = sim_time(), time.monotonic()
    time.sleep(seconds)
    after, end = sim_time(), time.monotonic()
    return (after - sim) / (end - begin), after - sim


def bare_world():
    """The core with the world, track, car, controllers and commands of the running bridge."""
    resolve = Resolver()
    path = rospkg.RosPack().get_path("track_model") + "/worlds/track.world"
    world = World()
    with open(path, "rb") as file:
        world.load(parse_world(file.read(), resolve, path))
    world.spawn_sdf("track", rospy.get_param("/track_description"), Pose(), resolve)
    car = world.spawn_urdf("racecar", rospy.get_param("/robot_description"), Pose(), resolve)
    for name, _ in COMMANDS:
        car.manager.load(name, rospy.get_param(f"/racecar/{name}"))
    car.manager.switch([name for name, _ in COMMANDS], [])
    for name, value in COMMANDS:
        car.manager.command(name, [value])
    return world


def bare_speed(world):
    """Speed of the bare core's car over the ground [m/s]."""
    car = world.model("racecar")
    linear = car.link_state(car.description.root)[1]
    return float((linear[0] ** 2 + linear[1] ** 2) ** 0.5)


def pace_of_engine(world, seconds):
    """Simulated seconds per wall second of PyBullet's stepping alone."""
    steps, begin = 0, time.monotonic()
    while time.monotonic() - begin < seconds:
        world.engine.step(STEPS_A_CALL)
        steps += STEPS_A_CALL
    return steps * world.time_step / (time.monotonic() - begin)
