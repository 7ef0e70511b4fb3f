"""Observers that alternate between the bridge and the bare stepping of the same world.

free OPTIONS: rounds of the bridge, as fast as possible, and of bare stepping. OPTIONS is JSON:
topics (subscribed), cars (see bare_world). First answers its pid and the physics step; then
takes a line with JSON: roles (role -> pids) and threads (name -> pid, tid). Then each line
"bridge SECONDS" or "bare SECONDS" is a round with one answer. The bridge is paused while the bare
engine runs, and the other way round.

scale COUNT...: cars with lidars in one world, spawned one by one; rounds of it and a bare car. For
each count: answers once they drive, then each line "cars SECONDS" or "bare SECONDS" is a round with
one answer; the line "next" goes on to the next count.
"""

import json
import os
import pathlib
import time

import rospkg
import rospy
import yaml
from bullet_sim.pose import Pose
from bullet_sim.world import World
from controller_manager_msgs.srv import LoadController, SwitchController, SwitchControllerRequest
from gazebo_msgs.srv import GetPhysicsProperties, SpawnModel, SpawnModelRequest
from pairs import rate_of_work
from usage import Monitor, between
from worlds.car_description import COMMANDS, describe
from worlds.core import GROUND

from observers import graph

STEPS_A_CALL = 100
CAR = {"model": "racecar", "description": "/robot_description", "namespace": "/racecar", "x": 0.0}
UP_TO_SPEED = 1.0  # [s] simulated time until the cars drive steadily
QUIET = 0.2  # [s] without a message after a pause: what was under way has arrived
MAX_LOOKS = 25  # for that, if something is sent during a pause, too
SETTLE = 0.3  # [s] after going on, until the window begins


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
    world.step()  # the first step chooses the friction model and the coefficients
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


class FreeRounds:
    """Alternates between the bridge and the bare engine."""

    def __init__(self, topics, cars):
        self._received = {topic: graph.record(topic) for topic in topics}
        self._cars = cars
        for car in cars:
            graph.wait_for_controllers(car["namespace"])
        self._simulation = graph.Simulation()
        for car in cars:
            graph.start_circle(graph.publishers(car["namespace"]))
        self._simulation.wait(UP_TO_SPEED)
        self._simulation.pause()
        self._settled_counts()
        self.world = bare_world(cars)
        self.world.step(round(UP_TO_SPEED / self.world.time_step))
        self.monitor = None

    def bridge(self, seconds):
        """A window of the bridge: pace, speed, who had the CPU; and from going on to the pause the
        simulated time and its messages, however late they come."""
        before, first = graph.counts(self._received), self._simulation.time()
        self._simulation.unpause()
        time.sleep(SETTLE)
        reading = self.monitor.read()
        pace, _ = self._simulation.pace(seconds)
        spent, shares = between(reading, self.monitor.read()), self._simulation.shares()
        speeds = [graph.car_speed(car["model"]) for car in self._cars]
        self._simulation.pause()
        sim, after = self._simulation.time() - first, self._settled_counts()
        counts = {topic: count - before[topic] for topic, count in after.items()}
        moved = {"pace": pace, "sim": sim, "speeds": speeds}
        return {**moved, "received": counts, "spent": spent, "shares": shares}

    def _settled_counts(self):
        """Messages of each topic once what was under way has arrived; the simulation is paused."""
        counts = graph.counts(self._received)
        for _ in range(MAX_LOOKS):
            time.sleep(QUIET)
            before, counts = counts, graph.counts(self._received)
            if counts == before:
                break
        return counts

    def bare(self, seconds):
        """A window of bare stepping: pace, speed, who had the CPU meanwhile."""
        reading = self.monitor.read()
        pace = pace_of(self.world, seconds)
        spent = between(reading, self.monitor.read())
        speeds = [speed_of(self.world, car["model"]) for car in self._cars]
        return {"pace": pace, "speeds": speeds, "spent": spent}


def free(options):
    """Start, then rounds until bench.py closes the pipe."""
    options = json.loads(options)
    graph.join()
    rounds = FreeRounds(options["topics"], options["cars"])
    graph.say(pid=os.getpid(), step=rounds.world.time_step)
    tracked = graph.receive_json()
    rounds.monitor = Monitor(tracked["roles"], tracked["threads"])
    graph.serve({"bridge": rounds.bridge, "bare": rounds.bare})


def add(number):
    """Spawn a car and start its controllers; it drives a circle. Returns its scans' list."""
    name = f"car{number}"
    text = describe(namespace=f"/{name}", topic=f"/{name}/scan", lidar_samples=360, camera=False)
    pose = SpawnModelRequest(model_name=name, model_xml=text, robot_namespace=name)
    pose.initial_pose.position.x = 3.0 * (number % 6)
    pose.initial_pose.position.y = 3.0 * (number // 6)
    pose.initial_pose.orientation.w = 1.0
    answer = rospy.ServiceProxy("/gazebo/spawn_urdf_model", SpawnModel)(pose)
    if not answer.success:
        graph.fail(answer.status_message)
    config = rospy.get_param("/racecar")
    names = [controller for controller, _ in COMMANDS] + ["joint_state_controller"]
    for controller in names:
        rospy.set_param(f"/{name}/{controller}", config[controller])
        rospy.ServiceProxy(f"/{name}/controller_manager/load_controller", LoadController)(
            controller
        )
    switched = rospy.ServiceProxy(
        f"/{name}/controller_manager/switch_controller", SwitchController
    )(names, [], SwitchControllerRequest.STRICT, False, 0.0)
    if not switched.ok:
        graph.fail(f"controllers of {name} do not start")
    graph.start_circle(graph.publishers(f"/{name}"))
    return graph.record(f"/{name}/scan")


class ScaleRounds:
    """Alternates between the bridge's cars and one bare car."""

    def __init__(self):
        self._simulation, self._scans = graph.Simulation(), []
        rospy.set_param("/bare_description", describe(lidar_samples=360, camera=False))
        self._bare = bare_world(
            ({"model": "racecar", "description": "/bare_description", "x": 0.0},), track=False
        )

    def grow(self, count):
        """Spawn what is missing, let them drive, pause."""
        self._simulation.unpause()
        while len(self._scans) < count:
            self._scans.append(add(len(self._scans)))
        self._simulation.wait(UP_TO_SPEED)
        self._simulation.pause()

    def cars(self, seconds):
        """A window of the bridge: pace, scans per simulated second and car, speed of the last."""
        self._simulation.unpause()
        time.sleep(SETTLE)
        before = sum(map(len, self._scans))
        pace, sim = self._simulation.pace(seconds)
        scans = sum(map(len, self._scans)) - before
        speed = graph.car_speed(f"car{len(self._scans) - 1}")
        self._simulation.pause()
        return {"pace": pace, "speed": speed, "scan_rate": scans / len(self._scans) / sim}

    def bare(self, seconds):
        """A window of one car's bare stepping."""
        time.sleep(SETTLE)
        return {"pace": pace_of(self._bare, seconds)}


def scale(*counts):
    """Rounds for each count."""
    graph.join()
    rospy.wait_for_service("/gazebo/spawn_urdf_model", graph.START_LIMIT)
    limit = time.monotonic() + graph.START_LIMIT
    while not rospy.has_param("/racecar/joint_state_controller"):
        if time.monotonic() > limit:
            graph.fail(f"no parameters of the car's controllers after {graph.START_LIMIT:g} s")
        time.sleep(0.05)
    rounds = ScaleRounds()
    kinds = {"cars": rounds.cars, "bare": rounds.bare}
    for count in map(int, counts):
        rounds.grow(count)
        graph.say(cars=count)
        while (words := graph.receive()) != ["next"]:
            kind, seconds = words
            graph.say(**kinds[kind](float(seconds)))
