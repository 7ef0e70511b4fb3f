"""One robot with its RobotControl, without a ROS master, its messages stored."""

import math
import threading

from bullet_bridge.control import reconfigure
from bullet_bridge.control import robot as control
from bullet_bridge.control.robot import RobotControl
from bullet_bridge.loop.jobs import JobQueue
from bullet_bridge.plugins import base
from bullet_sim.pose import Pose
from bullet_sim.world import World
from controller_manager_msgs import srv
from fake_impl import FakeServer, Topic
from urdf_texts import CONTROL, link

LINK = link("{0}")


def transmissions(kinds, prefix="hardware_interface/"):
    """A <transmission> for each interface.

    Args:
        kinds: joint -> interfaces, as "Velocity Effort".
    """
    return "".join(
        f'<transmission name="{kind}_{joint}"><type>transmission_interface/SimpleTransmission'
        f'</type><joint name="{joint}"><hardwareInterface>{prefix}{kind}JointInterface'
        f'</hardwareInterface></joint><actuator name="m_{joint}"/></transmission>'
        for joint, of_joint in kinds.items()
        for kind in of_joint.split()
    )


def held_robot(parts, link=LINK, control=CONTROL):
    """URDF of the robot 'bot', whose link 'base' is fixed to the world."""
    return (
        '<robot name="bot"><link name="world"/><joint name="held" type="fixed">'
        '<parent link="world"/><child link="base"/></joint>'
        f"{link.format('base')}{''.join(parts)}{control}</robot>"
    )


def _in(params, name, default):
    """A parameter of a mapping that is one, by its full name."""
    outer, _, key = name.rpartition("/")
    return params.get(outer, {}).get(key, default)


class Tuning:
    """Stands in for a server of gains: stores its arguments."""

    def __init__(self, gains, apply):
        self.gains, self.apply, self.closed = gains, apply, False

    def close(self):
        self.closed = True


class Bot:
    """World without gravity, model, RobotControl; endpoints and PID servers by name, the log.

    Args:
        monkeypatch: pytest's.
        urdf: of the robot 'bot'.
        params: parameter server, by full names.
        pose: where it is spawned.
        world: where it is; None: one without gravity and ground.
    """

    def __init__(self, monkeypatch, urdf, params, pose=Pose(), world=None):
        self.endpoints, self.pid_servers, self.log = {}, {}, []

        def make(name, kind, call=None, **_):
            self.endpoints[name] = Topic(name, kind, call)
            return self.endpoints[name]

        def tune(namespace, gains, apply):
            self.pid_servers[namespace] = Tuning(gains, apply)
            return self.pid_servers[namespace]

        for kind in ("Subscriber", "Service"):
            monkeypatch.setattr(control.rospy, kind, make)
        monkeypatch.setattr(base, "publisher", make)
        monkeypatch.setattr(FakeServer, "made", {})
        monkeypatch.setattr(base, "ValuesServer", FakeServer)
        monkeypatch.setattr(reconfigure, "pid_server", tune)
        self.set_params = {}  # by the robot
        monkeypatch.setattr(control.rospy, "set_param", self.set_params.__setitem__)
        monkeypatch.setattr(
            control.rospy,
            "get_param",
            lambda name, default=None: params.get(name, _in(params, name, default)),
        )
        for level in ("loginfo", "logwarn", "logerr"):
            monkeypatch.setattr(control.rospy, level, self._log)
        monkeypatch.setattr(
            control.rospy, "logerr_throttle", lambda _period, text, *rest: self._log(text, *rest)
        )
        still = World(gravity=(0.0, 0.0, 0.0), fixed_joints="merge")  # else long arms fling it
        self.world, self.jobs = world or still, JobQueue()
        self.model = self.world.spawn_urdf("bot", urdf, pose, None)
        self.control = RobotControl(self.jobs, self.world, self.model, "bot/")

    def _log(self, text, *rest):
        self.log.append(text % rest if rest else text)

    def in_thread(self, work):
        """Run something that waits for jobs, as a thread of rospy does; its result."""
        responses = []
        caller = threading.Thread(target=lambda: responses.append(work()))
        caller.start()
        while caller.is_alive():
            self.jobs.run_pending(wait=0.005)
        caller.join()
        self.control.refresh()
        return responses[0]

    def ask(self, service, **fields):
        """Call one of the controller_manager's services."""
        kind = "".join(word.capitalize() for word in service.split("_"))
        request = getattr(srv, f"{kind}Request")(**fields)
        return self.in_thread(
            lambda: self.endpoints[f"/bot/controller_manager/{service}"].call(request)
        )

    def load(self, name):
        return self.ask("load_controller", name=name).ok

    def unload(self, name):
        return self.ask("unload_controller", name=name).ok

    def switch(self, start=(), stop=(), strictness=2):
        return self.ask(
            "switch_controller",
            start_controllers=list(start),
            stop_controllers=list(stop),
            strictness=strictness,
        ).ok

    def start(self, name):
        assert self.load(name) and self.switch(start=[name])

    def states(self):
        """{controller: state}."""
        return {c.name: c.state for c in self.ask("list_controllers").controller}

    def command(self, name, message):
        """A message arrives on the command topic."""
        self.endpoints[f"/bot/{name}/command"].call(message)

    def run(self, steps):
        """Steps as the server makes them."""
        for _ in range(steps):
            step = self.world.step_count
            due = [each.next_due_subscribed(step) for _, each in self.control.schedules()]
            self.control.apply_commands()
            self.world.step()
            if self.world.step_count >= min(due, default=math.inf):
                self.control.publish(self.world.step_count, self.world.time)

    def velocity(self, joint):
        """Velocity of a joint [rad/s]."""
        return self.model.joints.arrays()[1][list(self.model.joints.names).index(joint)]
