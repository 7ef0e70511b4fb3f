"""scale COUNT...: cars with lidars in one world, spawned by and by; turns of it and of a bare car.

For each count: answers once they drive, then each line "cars SECONDS" or "bare
SECONDS" is a turn with one answer; the line "next" goes on to the next count.
"""

import time

import rospy
from controller_manager_msgs.srv import LoadController, SwitchController, SwitchControllerRequest
from gazebo_msgs.srv import SpawnModel, SpawnModelRequest
from worlds.car_description import describe

from observers import bare, graph
from observers.circle import COMMANDS

UP_TO_SPEED = 1.0  # [s] simulated time until the cars drive steadily
SETTLE = 0.3  # [s] between pausing or going on and the window


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


class Turns:
    """Alternates between the bridge's cars and one bare car."""

    def __init__(self):
        self._simulation, self._scans = graph.Simulation(), []
        rospy.set_param("/bare_description", describe(lidar_samples=360, camera=False))
        self._bare = bare.bare_world(
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
        return {"pace": bare.pace_of(self._bare, seconds)}


def main(*counts):
    """Turns for each count."""
    graph.join()
    rospy.wait_for_service("/gazebo/spawn_urdf_model", graph.START_LIMIT)
    limit = time.monotonic() + graph.START_LIMIT
    while not rospy.has_param("/racecar/joint_state_controller"):
        if time.monotonic() > limit:
            graph.fail(f"no parameters of the car's controllers after {graph.START_LIMIT:g} s")
        time.sleep(0.05)
    turns = Turns()
    kinds = {"cars": turns.cars, "bare": turns.bare}
    for count in map(int, counts):
        turns.grow(count)
        graph.say(cars=count)
        while (words := graph.hear()) != ["next"]:
            kind, seconds = words
            graph.say(**kinds[kind](float(seconds)))
