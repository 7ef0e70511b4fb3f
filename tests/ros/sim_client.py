"""Shared by the integration tests: waiting with deadlines, recording topics, names.

Every wait polls in wall time and has a deadline; every expectation is computed from stamps.
"""

import math
import threading
import time

import rosgraph
import rospy
from controller_manager_msgs.srv import ListControllers
from gazebo_msgs.srv import GetWorldProperties
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

WALL_LIMIT = 120.0  # longest wait for something that should come at once, with slack [s]
START_LIMIT = 180.0  # longest wait for the world to come up on a loaded machine [s]
WHEELS = tuple(f"{side}_{end}_wheel" for end in ("rear", "front") for side in ("left", "right"))
HINGES = ("left_steering_hinge", "right_steering_hinge")
CONTROLLERS = (
    "joint_state_controller",
    *(f"{wheel}_velocity_controller" for wheel in WHEELS),
    *(f"{hinge}_position_controller" for hinge in HINGES),
)
NO_GAINS = "No p gain specified for pid."  # an error's line of gazebo_ros_control, no fault
CAR_COMMANDS = tuple(f"/racecar/{name}/command" for name in CONTROLLERS[1:])


def wait_until(condition, what, limit=WALL_LIMIT):
    """Waits until a condition holds.

    It is looked at every 5 ms, or less often if that takes long: a service call or a program each
    time would keep processors busy that what is waited for needs.

    Args:
        condition: Function without arguments; its first true value is returned.
        what: The awaited condition, for the error.
        limit: Longest wait in wall time [s].

    Raises:
        AssertionError: The condition did not hold in time.
    """
    deadline = time.monotonic() + limit
    while (begin := time.monotonic()) < deadline:
        value = condition()
        if value:
            return value
        if rospy.is_shutdown():
            raise AssertionError(f"ROS was shut down while waiting for {what}")
        time.sleep(min(max(0.005, 5.0 * (time.monotonic() - begin)), 0.05))
    raise AssertionError(f"{what}: not within {limit:g} s")


def faults(text):
    """Lines of a launch's output that tell of errors."""
    words = ("Traceback", "[FATAL]", "[ERROR]", "has died")
    return [
        line
        for line in text.splitlines()
        if NO_GAINS not in line and any(word in line for word in words)
    ]


def world_time():
    """The simulator's time [s]; rospy's is that of /clock, which may be late."""
    return rospy.ServiceProxy("/gazebo/get_world_properties", GetWorldProperties)().sim_time


def sleep_sim(seconds, limit=WALL_LIMIT):
    """Waits for simulated time to pass; fails when /clock stands still or runs too slowly.

    Args:
        seconds: Simulated time [s].
        limit: Longest wait in wall time beyond that of a tenth of real time [s].
    """
    wait_until(rospy.get_time, "the first /clock", limit)
    end = rospy.get_time() + seconds
    deadline = time.monotonic() + 10.0 * seconds + limit
    while rospy.get_time() < end:
        if time.monotonic() > deadline:
            raise AssertionError(
                f"/clock moved by less than {seconds:g} s "
                f"in {10.0 * seconds + limit:g} s of wall time"
            )
        time.sleep(0.004)


class Recorder:
    """Records every message of a topic, in the order of arrival."""

    def __init__(self, topic, kind):
        self.topic, self._kind = topic, kind
        self._lock = threading.Lock()
        self._messages = []
        self._subscriber = None
        self.subscribe_again()

    def subscribe_again(self):
        """Subscribes anew.

        rospy overlooks a publisher that registers in the same moment: where the master's answer
        without it is read after the master's word of it, it is not connected (registration.py).
        """
        if self._subscriber is not None:
            self._subscriber.unregister()
        self._subscriber = rospy.Subscriber(self.topic, self._kind, self._keep, queue_size=None)

    def _keep(self, message):
        with self._lock:
            self._messages.append(message)

    @property
    def messages(self):
        """A copy of the messages so far."""
        with self._lock:
            return list(self._messages)

    @property
    def last(self):
        """The newest message, or None."""
        with self._lock:
            return self._messages[-1] if self._messages else None

    @property
    def newest(self):
        """The newest message; waits for the first."""
        wait_until(lambda: self.last is not None, f"a message on {self.topic}")
        return self.last

    def clear(self):
        """Drops the messages so far."""
        with self._lock:
            self._messages.clear()

    def next(self, limit=WALL_LIMIT):
        """Waits for a message that arrives after this call and returns it."""
        seen = len(self.messages)
        wait_until(lambda: len(self.messages) > seen, f"a message on {self.topic}", limit)
        return self.last

    def wait_count(self, count, limit=WALL_LIMIT):
        """Waits for at least `count` messages and returns them."""
        wait_until(lambda: len(self.messages) >= count, f"{count} messages on {self.topic}", limit)
        return self.messages

    def close(self):
        """Unsubscribes."""
        self._subscriber.unregister()


def _list_of(namespace, limit):
    """The service list_controllers of a controller manager; a failure says which services exist."""
    name = f"{namespace}/controller_manager/list_controllers"
    try:
        rospy.wait_for_service(name, timeout=limit)
    except rospy.ROSException as error:
        _, _, services = rosgraph.Master(rospy.get_name()).getSystemState()
        raise AssertionError(f"{error}; services: {sorted(services)}") from None
    return rospy.ServiceProxy(name, ListControllers)


def wait_running(namespace, count, limit=START_LIMIT):
    """Waits until a controller manager has so many controllers, all of them running.

    For clocks that stand, and for what is loaded before it runs: a controller hears commands once
    it is loaded, and starts with a command of 0 later.

    Args:
        namespace: Of the controller manager, such as /bot.
        limit: Longest wait in wall time [s].
    """
    states = _list_of(namespace, limit)
    wait_until(
        lambda: [item.state for item in states().controller] == ["running"] * count,
        f"{count} controllers of {namespace} running",
        limit,
    )


def wait_for_car(limit=START_LIMIT):
    """Waits until the world is up: /clock runs and all seven controllers of the car are running.

    Returns:
        Dict of controller name -> ControllerState.
    """
    clock = Recorder("/clock", Clock)
    clock.wait_count(2, limit)
    clock.close()
    service = _list_of("/racecar", limit)
    states = {}

    def running():
        states.update((item.name, item) for item in service().controller)
        return all(item in states and states[item].state == "running" for item in CONTROLLERS)

    try:
        wait_until(running, "all controllers running", limit)
    except AssertionError as error:
        seen = ", ".join(f"{item} {state.state}" for item, state in states.items()) or "none"
        raise AssertionError(f"{error}; seen: {seen}") from None
    return dict(states)


def command_publishers():
    """Returns a Float64 publisher, already connected, for each wheel and hinge by its name."""
    publishers = {}
    for name in WHEELS + HINGES:
        kind = "velocity" if name in WHEELS else "position"
        publishers[name] = rospy.Publisher(
            f"/racecar/{name}_{kind}_controller/command", Float64, queue_size=10
        )
    for name, publisher in publishers.items():
        wait_connected(publisher, name)
    return publishers


def wait_connected(publisher, what):
    """Waits until a publisher has a subscriber."""
    wait_until(
        lambda: publisher.get_num_connections() > 0,
        f"a subscriber of {publisher.name} ({what})",
        START_LIMIT,
    )


def joint(message, name):
    """Picks a joint out of a sensor_msgs/JointState.

    Returns:
        (position [rad], velocity [rad/s]).
    """
    index = message.name.index(name)
    return message.position[index], message.velocity[index]


def yaw_of(orientation):
    """Returns the heading [rad, left positive] of a geometry_msgs/Quaternion."""
    x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def turned(start, end):
    """Returns the turn from one heading to another [rad], within ±pi."""
    return math.remainder(end - start, 2.0 * math.pi)
