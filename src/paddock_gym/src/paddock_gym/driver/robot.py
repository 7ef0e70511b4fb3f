"""The node `robot_driver`: commands a robot by a policy of Paddock/Robot-v0."""

import math
import operator
import threading
import time

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from paddock_common.nodes import run
from roslib.message import get_message_class

from paddock_gym.course import motion_from
from paddock_gym.ids import ANY_ROBOT
from paddock_gym.observations import goal_row, over, polar
from paddock_gym.policy.onnx_policy import OnnxPolicy

LONGEST_WAIT = 0.05  # for messages that are due when an action is [s of wall time]
LINKS, LINK_STATES = "/gazebo/link_states", "gazebo_msgs/LinkStates"
PLACES = {  # fields of messages that have other names in observations
    "nav_msgs/Odometry": {
        **{name: f"pose.pose.{name}" for name in ("position", "orientation")},
        **{name: f"twist.twist.{name}" for name in ("linear", "angular")},
    },
    "sensor_msgs/NavSatFix": {"fix": "latitude longitude altitude"},
}
PIXELS = {"32FC1": np.float32, "16UC1": np.uint16, "mono16": np.uint16, "rgb16": np.uint16}


class Source:
    """What gives one observation: a topic, or a link's truth; the latest message counts.

    Args:
        topic, message: its name and type.
        fields: name -> shape of each array of the message, in their order.
        most: that ranges are over [m]; 0: they are as they are.
        raw: depths that are infinite are not 0.
        organized: points that hit nothing are zeros in their places, not left out.
        dtype: of the observation.
        link: MODEL::LINK, of which pose and velocities are observed.
        area: of the goal [m], which is observed from the link.
        goal: x, y [m] in the world.
    """

    def __init__(self, topic=LINKS, message=LINK_STATES, fields=None, most=0.0, raw=False,
                 organized=False, dtype="float64", link="", area=0.0, goal=None):  # fmt: skip
        self._kind, self._fields, self._most, self._dtype = message, fields or {}, most, dtype
        self._finite = dtype == "float32" and not raw
        self._organized = organized
        self._link, self._area, self._goal = link, area, goal
        self._message, self._stamp, self._due = None, math.nan, math.inf
        message_class = get_message_class(message)
        if message_class is None:
            raise ValueError(f"{topic} has messages of {message}, which is not installed")
        rospy.Subscriber(topic, message_class, self.take, queue_size=1, buff_size=2**24)

    def take(self, message):
        """Keep a message."""
        self._message = message
        if hasattr(message, "header"):
            before, self._stamp = self._stamp, message.header.stamp.to_sec()
            period = self._stamp - before
            self._due = self._stamp + period if period > 0.0 else math.inf

    def is_due(self, now):
        """Whether the next message is to come by a simulated time [s], by the last two."""
        return self._due < now + 1e-6

    def read(self):
        """The observation's array; None: there was no message yet."""
        message = self._message
        if message is None:
            return None
        if self._link:
            return self._truth(message)
        parts = [self._array(message, *field) for field in self._fields.items()]
        if self._most:
            return over(parts[0], self._most)
        array = np.concatenate(parts) if len(parts) > 1 else parts[0]
        if array.ndim > 1 and self._finite:
            array = np.nan_to_num(array, posinf=0.0)
        return array.astype(self._dtype)

    def _truth(self, message):
        if self._link not in message.name:
            raise ValueError(f"{LINKS} has no {self._link}: {', '.join(message.name)}")
        index = message.name.index(self._link)
        pose, twist = message.pose[index], message.twist[index]
        vectors = pose.position, pose.orientation, twist.linear, twist.angular
        position, quaternion, linear, angular = map(numbers, vectors)
        if self._goal is None:
            return np.concatenate((position, quaternion, linear, angular))
        motion = motion_from(position, quaternion, linear, angular)
        return goal_row(*polar(self._goal, *motion[:3]), self._area)

    def _array(self, message, name, shape):
        """An array of a message, as the environment has it."""
        if self._kind == "sensor_msgs/Image":
            rows = np.frombuffer(message.data, PIXELS.get(message.encoding, np.uint8))
            rows = rows.reshape(message.height, -1)[:, : int(np.prod(shape[1:]))]
            return rows.reshape(shape)
        if self._kind in CLOUDS:
            return self._points(CLOUDS[self._kind](message), shape)
        if self._kind == "gazebo_msgs/ContactsState":
            if name == "count":
                return np.array([float(len(message.states))])
            wrenches = [state.total_wrench for state in message.states]
            rows = [[*numbers(each.force), *numbers(each.torque)] for each in wrenches]
            return np.sum([np.zeros(6), *rows], axis=0)
        rows = [
            numbers(operator.attrgetter(place)(message))
            for place in PLACES.get(self._kind, {}).get(name, name).split()
        ]
        return np.array(sum(rows, []), float).reshape(shape)

    def _points(self, points, shape):
        """Points (n, 3) as the environment has them: those that hit something first, zeros after
        them; organized: all in their places."""
        hit = np.isfinite(points).all(axis=1)
        if self._organized:
            return np.where(np.isfinite(points), points, np.float32(0.0)).reshape(shape)
        array = np.zeros(shape, np.float32)
        array[: hit.sum()] = points[hit]
        return array


def cloud_points(message):
    """Points (n, 3) float32 [m] of a sensor_msgs/PointCloud2."""
    offsets = {field.name: field.offset for field in message.fields}
    rows = np.frombuffer(message.data, np.uint8).reshape(message.height, message.row_step)
    rows = rows[:, : message.width * message.point_step].reshape(-1, message.point_step)
    columns = [rows[:, offsets[axis] : offsets[axis] + 4] for axis in "xyz"]
    order = ">f4" if message.is_bigendian else "<f4"
    return np.hstack(columns).view(order).astype(np.float32)


CLOUDS = {  # type of messages -> their points
    "sensor_msgs/PointCloud2": cloud_points,
    "sensor_msgs/PointCloud": lambda message: np.array(
        [(point.x, point.y, point.z) for point in message.points], np.float32
    ).reshape(-1, 3),
}


def numbers(value):
    """Numbers of a vector, quaternion, list or number."""
    if hasattr(value, "x"):
        return [getattr(value, letter) for letter in "xyzw" if hasattr(value, letter)]
    return [value] if isinstance(value, (int, float)) else list(value)


class RobotDriver:
    """Publishes the policy's commands at the rate of its training, in simulated time.

    Raises:
        ValueError: a parameter or the policy is not valid.
    """

    def __init__(self):
        self._policy = OnnxPolicy(str(rospy.get_param("~policy")), ANY_ROBOT)
        about = self._policy.description
        self._sources = {}
        for name, source in about.sources.items():
            options = dict(source, goal=self._goal()) if source.get("area") else source
            self._sources[name] = Source(**options)
        self._publishers = {
            topic: (rospy.Publisher(topic, get_message_class(kind), queue_size=1))
            for topic, kind, _ in about.actions.topics
        }
        self._lock = threading.Lock()
        self._wait = min(LONGEST_WAIT, 0.5 / about.control_rate)
        rospy.Timer(rospy.Duration(1.0 / about.control_rate), self._act, reset=True)

    @staticmethod
    def _goal():
        text = str(rospy.get_param("~goal", ""))
        goal = [float(word) for word in text.split()]
        if len(goal) != 2 or not all(map(math.isfinite, goal)):
            raise ValueError(f"goal is {text!r}; it must be x and y [m] in the world")
        return goal

    def _act(self, event):
        with self._lock:
            self._wait_for_due(event.current_real.to_sec())
            observation = {name: source.read() for name, source in self._sources.items()}
            missing = [name for name, array in observation.items() if array is None]
            if missing:
                rospy.logwarn_throttle(10.0, f"robot_driver waits for {', '.join(missing)}")
                return
            for topic, kind, values in self._policy.command(observation):
                self._publishers[topic].publish(message_of(kind, values))

    def _wait_for_due(self, now):
        """Wait a little for messages of now: the environment observes them, and /clock may be
        faster."""
        end = time.monotonic() + self._wait
        while time.monotonic() < end and any(each.is_due(now) for each in self._sources.values()):
            time.sleep(0.001)


def message_of(kind, values):
    """A message of Twist, Float64 or Float64MultiArray with these numbers."""
    message = get_message_class(kind)()
    if isinstance(message, Twist):
        message.linear.x, message.angular.z = values[0], values[-1]
        if len(values) == 3:
            message.linear.y = values[1]
    else:
        message.data = values if kind.endswith("Array") else values[0]
    return message


def main():
    """Runs the node until ROS shuts down."""
    run("robot_driver", RobotDriver)
