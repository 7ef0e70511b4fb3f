"""scale SECONDS COUNT...: cars with lidars in one world, spawned by and by."""

import subprocess
import time
import xml.etree.ElementTree as ElementTree

import rospkg
import rospy
from controller_manager_msgs.srv import LoadController, SwitchController, SwitchControllerRequest
from gazebo_msgs.srv import SpawnModel, SpawnModelRequest

from observers import graph


def urdf(namespace):
    """The DeepRacer's description, without a camera, with a lidar of 360 rays at 10 Hz."""
    path = rospkg.RosPack().get_path("track_model") + "/urdf/racecar.urdf.xacro"
    text = subprocess.check_output(
        [
            "xacro",
            path,
            f"robot_namespace:=/{namespace}",
            "lidar_samples:=360",
            f"lidar_topic:=/{namespace}/scan",
        ],
        text=True,
    )
    robot = ElementTree.fromstring(text)
    for block in robot.findall("gazebo"):
        if block.find("sensor[@type='camera']") is not None:
            robot.remove(block)
    return ElementTree.tostring(robot, encoding="unicode")


def add(number):
    """Spawn a car and start its controllers; it drives a circle. Returns its scans' list."""
    name = f"car{number}"
    pose = SpawnModelRequest(model_name=name, model_xml=urdf(name), robot_namespace=name)
    pose.initial_pose.position.x = 3.0 * (number % 6)
    pose.initial_pose.position.y = 3.0 * (number // 6)
    pose.initial_pose.orientation.w = 1.0
    answer = rospy.ServiceProxy("/gazebo/spawn_urdf_model", SpawnModel)(pose)
    if not answer.success:
        raise SystemExit(f"observer: {answer.status_message}")
    config = rospy.get_param("/racecar")
    names = [controller for controller, _ in graph.COMMANDS] + ["joint_state_controller"]
    for controller in names:
        rospy.set_param(f"/{name}/{controller}", config[controller])
        rospy.ServiceProxy(f"/{name}/controller_manager/load_controller", LoadController)(
            controller
        )
    switched = rospy.ServiceProxy(
        f"/{name}/controller_manager/switch_controller", SwitchController
    )(names, [], SwitchControllerRequest.STRICT, False, 0.0)
    if not switched.ok:
        raise SystemExit(f"observer: controllers of {name} do not start")
    graph.start_circle(graph.publishers(f"/{name}"))
    return graph.record(f"/{name}/scan")


def main(seconds, *counts):
    """Answers once per count: pace, cars, scans per simulated second and car."""
    graph.join()
    rospy.wait_for_service("/gazebo/spawn_urdf_model", graph.START_LIMIT)
    limit = time.monotonic() + graph.START_LIMIT
    while not rospy.has_param("/racecar/joint_state_controller") and time.monotonic() < limit:
        time.sleep(0.05)
    scans = []
    for count in map(int, counts):
        while len(scans) < count:
            scans.append(add(len(scans)))
        time.sleep(0.5)
        before = sum(map(len, scans))
        pace, sim = graph.pace_of_bridge(float(seconds))
        heard = sum(map(len, scans)) - before
        graph.say(
            cars=count,
            pace=pace,
            sim=sim,
            scan_rate=heard / count / sim,
            speed=graph.car_speed(f"car{count - 1}"),
        )
        graph.hear()
