"""soak_hands: calls services and sends commands, as the soak asks for."""

import hashlib
import json
import random
import threading
import time

import rosgraph
import rospy
import rosservice
from controller_manager_msgs.srv import ListControllers
from gazebo_msgs.srv import (
    DeleteModel,
    GetLinkState,
    GetModelProperties,
    GetModelState,
    GetPhysicsProperties,
    GetWorldProperties,
    SetPhysicsProperties,
    SpawnModel,
)
from genpy import Message
from geometry_msgs.msg import Point, Pose, Quaternion, Twist
from std_srvs.srv import Empty, Trigger

from bullet_bridge.srv import Step
from observers import graph
from observers.soak_wild import Wild

BALL = """<sdf version="1.6"><model name="ball"><link name="link"><inertial><mass>1</mass><inertia>
<ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial><collision name="c"><geometry>
<sphere><radius>0.1</radius></sphere></geometry></collision><visual name="v"><geometry><sphere>
<radius>0.1</radius></sphere></geometry></visual></link></model></sdf>"""
CONTROLLERS = {"/racecar": 7, "/cybertruck": 3}
REST = 300  # physics steps after a reset whose result is compared
# What a method may raise where the simulator refuses or does not answer.
REFUSALS = (
    rospy.ServiceException,
    rospy.ROSException,
    rosgraph.MasterException,
    rosservice.ROSServiceException,
    OSError,
)


def call(name, kind, **fields):
    """Calls a service."""
    rospy.wait_for_service(name, 20.0)
    return rospy.ServiceProxy(name, kind)(**fields)


class Driver(threading.Thread):
    """Sends both cars commands that change every second."""

    def __init__(self):
        super().__init__(daemon=True)
        self.active = True
        self._outs = [
            (rospy.Publisher("/cmd_vel", Twist, queue_size=1), 12.0, 1.5),
            (rospy.Publisher("/truck/cmd_vel", Twist, queue_size=1), 1.0, 0.3),
        ]

    def run(self):
        """Until the process ends."""
        rng = random.Random(1)
        while True:
            speed, turn = rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0)
            for _ in range(10):
                time.sleep(0.1)
                for out, fastest, sharpest in self._outs if self.active else ():
                    message = Twist()
                    message.linear.x, message.angular.z = fastest * speed, sharpest * turn
                    out.publish(message)


class Hands(Wild):
    """What can be asked for; each method answers with a dict."""

    def __init__(self):
        self._driver = Driver()
        self._driver.start()

    def ready(self, namespaces=tuple(CONTROLLERS)):
        """Waits until the controllers of the cars run."""
        for namespace in namespaces:
            while graph.running_controllers(namespace) < CONTROLLERS[namespace]:
                time.sleep(0.2)
        return {}

    def controllers(self):
        """How many controllers of each namespace run."""
        found = {}
        for namespace in CONTROLLERS:
            states = call(f"{namespace}/controller_manager/list_controllers", ListControllers)
            found[namespace] = sum(item.state == "running" for item in states.controller)
        return {"missing": [name for name, count in CONTROLLERS.items() if found[name] < count]}

    def empty(self, service):
        """Calls a service without arguments."""
        call(f"/gazebo/{service}", Empty)
        return {}

    def time(self):
        """Simulated time [s]."""
        return {"time": call("/gazebo/get_world_properties", GetWorldProperties).sim_time}

    def picture(self):
        """Waits for a picture of the camera."""
        rospy.wait_for_message("/camera/image", rospy.AnyMsg, 60.0)
        return {}

    def viewer(self):
        """Opens the viewer."""
        answer = call("/gazebo/open_viewer", Trigger)
        return {"success": answer.success, "text": answer.message}

    def step(self, count):
        """Steps the paused world."""
        answer = call("/gazebo/step", Step, n=count)
        return {"success": answer.success, "text": answer.status_message}

    def pace(self, factor):
        """Sets the real time factor; 0: as fast as possible."""
        now = call("/gazebo/get_physics_properties", GetPhysicsProperties)
        answer = call(
            "/gazebo/set_physics_properties",
            SetPhysicsProperties,
            time_step=now.time_step,
            max_update_rate=factor / now.time_step,
            gravity=now.gravity,
            ode_config=now.ode_config,
        )
        return {"success": answer.success, "text": answer.status_message}

    def balls(self, count):
        """Spawns and deletes balls; says which calls failed."""
        failed = []
        for number in range(count):
            pose = Pose(Point(0.3 * number, -6.0, 1.0), Quaternion(w=1.0))
            fields = {"model_name": f"ball{number}", "model_xml": BALL, "initial_pose": pose}
            answer = call("/gazebo/spawn_sdf_model", SpawnModel, **fields)
            if not answer.success:
                failed.append(answer.status_message)
        time.sleep(0.5)
        for number in range(count):
            answer = call("/gazebo/delete_model", DeleteModel, model_name=f"ball{number}")
            if not answer.success:
                failed.append(answer.status_message)
        return {"failed": failed}

    def clean(self):
        """Deletes what wild calls have spawned."""
        names = call("/gazebo/get_world_properties", GetWorldProperties).model_names
        extra = [name for name in names if name not in ("track", "racecar", "cybertruck")]
        for name in extra:
            call("/gazebo/delete_model", DeleteModel, model_name=name)
        return {"deleted": len(extra)}

    def digest(self):
        """Resets, steps and gives a digest of all states; commands rest meanwhile."""
        self._driver.active = False
        time.sleep(0.5)
        call("/gazebo/pause_physics", Empty)
        try:
            call("/gazebo/reset_simulation", Empty)
            answer = call("/gazebo/step", Step, n=REST)
            if not answer.success:
                raise rospy.ServiceException(answer.status_message)
            states = {}
            for model in ("racecar", "cybertruck"):
                states.update(states_of(model))
        finally:
            call("/gazebo/unpause_physics", Empty)
            self._driver.active = True
        text = json.dumps(states, sort_keys=True)
        return {"digest": hashlib.sha256(text.encode()).hexdigest(), "states": states}


def states_of(model):
    """State of a model and of its links -> poses and twists."""
    state = call(
        "/gazebo/get_model_state", GetModelState, model_name=model, relative_entity_name=""
    )
    found = {model: (numbers(state.pose), numbers(state.twist))}
    properties = call("/gazebo/get_model_properties", GetModelProperties, model_name=model)
    for link in (f"{model}::{name}" for name in properties.body_names):
        state = call("/gazebo/get_link_state", GetLinkState, link_name=link).link_state
        found[link] = numbers(state.pose), numbers(state.twist)
    return found


def numbers(message):
    """All numbers of a message, to the last bit."""
    found = []
    for value in (getattr(message, name) for name in message.__slots__):
        found += numbers(value) if isinstance(value, Message) else [float(value).hex()]
    return found


def answer(hands, what, **fields):
    """Does what is asked for.

    Args:
        hands: Hands.
        what: Name of its method.
        **fields: Arguments.

    Returns:
        dict: what the method gave, or error.
    """
    try:
        return getattr(hands, what)(**fields)
    except REFUSALS as error:
        return {"error": f"{what}: {error}"}


def main():
    """Answers until the soak closes its end."""
    graph.join()
    hands = Hands()
    while True:
        graph.say(**answer(hands, **graph.hear_json()))
