"""Wild values: service calls, commands and bytes that nobody means, as the soak asks for."""

import math
import random
import socket
import struct
import time
from urllib.parse import urlparse

import rosgraph
import roslib.message
import rospy
import rosservice
from genpy import Message

NUMBERS = (0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, -1e300, math.inf, -math.inf, math.nan, 1e9)
TEXTS = ("", "racecar", "ball0", "no such thing", "::", "a::b", "/", "ä ö", "x" * 5000,
         "racecar::", "../../etc/passwd", "%s%n", "\x00", "cybertruck::base_link", "<sdf/>",
         "<robot")  # fmt: skip
# Services that a wild call would use as it is meant: they end, stop or change what is watched.
SPARED = ("set_logger_level", "get_loggers", "pause_physics", "step", "set_physics_properties",
          "set_parameters", "unload_controller", "switch_controller", "delete_model",
          "reload_controller_libraries", "open_viewer", "reset_simulation", "reset_world",
          "delete_light", "set_link_properties", "set_joint_properties",
          "set_light_properties")  # fmt: skip


class Wild:
    """What can be asked for; each method answers with a dict."""

    @staticmethod
    def wild_calls(seed, count):
        """Calls services of the simulator with values that nobody means."""
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
    def wild_commands(seed, count):
        """Sends wild values on command topics."""
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
                    link.sendall(rng.randbytes(rng.choice((1, 4, 100, 5000))))
                except OSError:
                    pass  # closed, as it should be
        return {}


def fill(message, rng):
    """Fills a message with wild values, in depth."""
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
