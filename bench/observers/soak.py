"""Observers of the soak: the operator calls and commands, the monitor counts messages."""

import hashlib
import json
import math
import random
import socket
import struct
import threading
import time
from urllib.parse import urlparse

import rosgraph
import roslib.message
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
from std_srvs.srv import Empty

from bullet_bridge.srv import State, Step
from observers import graph
from observers.page import Page, start_node

NUMBERS = (0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, -1e300, math.inf, -math.inf, math.nan, 1e9)
TEXTS = ("", "racecar", "ball0", "no such thing", "::", "a::b", "/", "ä ö", "x" * 5000,
         "racecar::", "../../etc/passwd", "%s%n", "\x00", "cybertruck::base_link", "<sdf/>",
         "<robot")  # fmt: skip
# Services that a fuzzed call would use as it is meant: they end, stop or change what is monitored.
SPARED = ("set_logger_level", "get_loggers", "pause_physics", "step", "set_physics_properties",
          "set_parameters", "unload_controller", "switch_controller", "delete_model",
          "reload_controller_libraries", "reset_simulation", "reset_world",
          "delete_light", "set_link_properties", "set_joint_properties",
          "set_light_properties")  # fmt: skip
BALL = """<sdf version="1.6"><model name="ball"><link name="link"><inertial><mass>1</mass><inertia>
<ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial><collision name="c"><geometry>
<sphere><radius>0.1</radius></sphere></geometry></collision><visual name="v"><geometry><sphere>
<radius>0.1</radius></sphere></geometry></visual></link></model></sdf>"""
CONTROLLERS = {"/racecar": 7, "/cybertruck": 3}
REST = 300  # physics steps from a state whose result is compared
SAVED = "soak"  # name of that state
# What a method may raise where the simulator refuses or does not answer.
REFUSALS = (
    rospy.ServiceException,
    rospy.ROSException,
    rosgraph.MasterException,
    rosservice.ROSServiceException,
    OSError,
)
TOPICS = (
    "/clock",
    "/racecar/odom",
    "/racecar/joint_states",
    "/scan",
    "/camera/image",
    "/cybertruck/joint_states",
    "/trailer_scan",
    "/odom",
    "/tf",
)


def fill(message, rng):
    """Fills a message with fuzzed values, in depth."""
    for name, kind in zip(message.__slots__, message._slot_types):
        value = getattr(message, name)
        if isinstance(value, Message):
            fill(value, rng)
        elif kind in ("float32", "float64"):
            setattr(message, name, rng.choice(NUMBERS))
        elif kind == "string":
            setattr(message, name, rng.choice(TEXTS))
        elif kind == "bool":
            setattr(message, name, rng.random() < 0.5)
        elif kind in ("time", "duration"):
            value.secs, value.nsecs = rng.choice((0, 1, 2**31 - 1)), rng.choice((0, 999999999))
        elif kind.startswith(("int", "uint")) and "[" not in kind:
            top = 2 ** (int(kind.lstrip("uint")) - kind.startswith("int")) - 1
            setattr(message, name, rng.choice((0, 1, top)))
        elif kind.startswith(("float", "string")) and kind.endswith("[]"):
            values = NUMBERS if kind.startswith("float") else TEXTS
            setattr(message, name, rng.choices(values, k=rng.choice((0, 1, 3, 40))))


def call(name, kind, /, **fields):
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


class Operator:
    """What can be requested; each method answers with a dict."""

    def __init__(self):
        self._return = (
            ("/gazebo/reset_simulation", Empty, {}),
            ("/gazebo/save_state", State, {"name": SAVED}),
        )  # services by which digest() comes to its first state
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

    def image(self):
        """Waits for an image of the camera."""
        rospy.wait_for_message("/camera/image", rospy.AnyMsg, 60.0)
        return {}

    def page(self, seconds):
        """A page looks at the world for some seconds of wall time; then its node is killed."""
        node, address = start_node("__name:=soak_page")
        try:
            page = Page(address)
            time.sleep(seconds)
        finally:
            node.kill()
            node.communicate()
        page.close()
        return {"views": page.views}

    def step(self, count):
        """Steps the paused world."""
        answer = call("/gazebo/step", Step, n=count)
        return {"success": answer.success, "text": answer.status_message}

    def real_time_factor(self, factor):
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
        """Deletes what fuzzed calls have spawned."""
        names = call("/gazebo/get_world_properties", GetWorldProperties).model_names
        extra = [name for name in names if name not in ("track", "racecar", "cybertruck")]
        for name in extra:
            call("/gazebo/delete_model", DeleteModel, model_name=name)
        return {"deleted": len(extra)}

    def digest(self):
        """Goes back to the state of the first call, steps and gives a digest of all states.

        Commands rest meanwhile. The state is saved after a reset.
        """
        self._driver.active = False
        time.sleep(0.5)
        call("/gazebo/pause_physics", Empty)
        try:
            for name, kind, fields in (
                *self._return,
                ("/gazebo/step", Step, {"n": REST}),
            ):
                answer = call(name, kind, **fields)
                if not getattr(answer, "success", True):
                    raise rospy.ServiceException(answer.status_message)
            self._return = (("/gazebo/restore_state", State, {"name": SAVED}),)
            states = {}
            for model in ("racecar", "cybertruck"):
                states.update(states_of(model))
        finally:
            call("/gazebo/unpause_physics", Empty)
            self._driver.active = True
        text = json.dumps(states, sort_keys=True)
        return {"digest": hashlib.sha256(text.encode()).hexdigest(), "states": states}

    @staticmethod
    def fuzzed_calls(seed, count):
        """Calls services of the simulator with fuzzed values."""
        rng = random.Random(seed)
        master = rosgraph.Master(rospy.get_name())
        names = sorted(
            name
            for name, nodes in master.getSystemState()[2]
            if "/gazebo" in nodes and name.rpartition("/")[2] not in SPARED
        )
        slowest = 0.0
        for _ in range(count):
            name = rng.choice(names)
            kind = rosservice.get_service_class_by_name(name)
            request = kind._request_class()
            fill(request, rng)
            before = time.monotonic()
            try:
                rospy.ServiceProxy(name, kind)(request)
            except (rospy.ServiceException, rospy.ROSException):
                pass  # refused, as it may be
            slowest = max(slowest, time.monotonic() - before)
        return {"slowest": slowest}

    @staticmethod
    def fuzzed_commands(seed, count):
        """Sends fuzzed values on command topics."""
        rng = random.Random(seed)
        master = rosgraph.Master(rospy.get_name())
        kinds = dict(master.getTopicTypes())
        names = sorted(
            name
            for name, nodes in master.getSystemState()[1]
            if set(nodes) & {"/gazebo", "/control", "/drive"} and name in kinds
            and name not in ("/clock", "/gazebo/set_model_state", "/gazebo/set_link_state")
        )  # fmt: skip
        outs = {}
        for name in rng.sample(names, min(6, len(names))):
            kind = roslib.message.get_message_class(kinds[name])
            if kind is not None:
                outs[name] = rospy.Publisher(name, kind, queue_size=10), kind
        time.sleep(0.5)
        for _ in range(count):
            out, kind = outs[rng.choice(sorted(outs))]
            message = kind()
            fill(message, rng)
            try:
                out.publish(message)
            except (rospy.ROSException, struct.error, UnicodeError):
                pass  # does not serialise
            time.sleep(0.005)
        for out, _ in outs.values():
            out.unregister()
        return {"topics": sorted(outs)}

    @staticmethod
    def noise(seed, count):
        """Writes random bytes to the simulator's ports."""
        rng = random.Random(seed)
        master = rosgraph.Master(rospy.get_name())
        addresses = (master.lookupNode("/gazebo"), master.lookupService("/gazebo/pause_physics"))
        for _ in range(count):
            address = urlparse(rng.choice(addresses))
            with socket.create_connection((address.hostname, address.port), 2.0) as link:
                try:
                    link.sendall(bytes(rng.choices(range(256), k=rng.choice((1, 4, 100, 5000)))))
                except OSError:
                    pass  # closed, as it should be
        return {}


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


def answer(operator, what, **fields):
    """Does what is requested.

    Returns:
        dict: what the method gave, or error.
    """
    try:
        return getattr(operator, what)(**fields)
    except REFUSALS as error:
        return {"error": f"{what}: {error}"}


def operator():
    """Answers until the soak closes its end."""
    graph.join()
    responder = Operator()
    while True:
        graph.say(**answer(responder, **graph.receive_json()))


class Counter:
    """Counts the messages of a topic; of /clock also the newest time."""

    def __init__(self, topic):
        self.count, self.time, self._topic = 0, 0.0, topic
        rospy.Subscriber(topic, rospy.AnyMsg, self._take, buff_size=1 << 22, tcp_nodelay=True)

    def _take(self, message):
        self.count += 1
        if self._topic == "/clock":
            seconds, nanoseconds = struct.unpack_from("<II", message._buff, 0)
            self.time = seconds + 1e-9 * nanoseconds


def monitor():
    """Counts until the soak closes its end."""
    graph.join()
    threading.stack_size(1 << 18)
    counters = {topic: Counter(topic) for topic in TOPICS}
    while True:
        graph.receive_json()
        graph.say(
            wall=time.monotonic(),
            simulated=counters["/clock"].time,
            counts={topic: counter.count for topic, counter in counters.items()},
            complete=all(counter.count > 0 for counter in counters.values()),
        )
