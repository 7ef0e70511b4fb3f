"""Topics of loaded controllers of joints: commands in; joint states and PID states out."""

from control_msgs.msg import JointControllerState, PidState
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

from bullet_bridge.control import messages as control_messages
from bullet_bridge.loop.schedule import SubscribedSchedule
from bullet_bridge.transport.packed import PackedJointState
from bullet_bridge.transport.publishing import publisher

STATE_EVERY = 10  # updates of a PID controller between two messages on its state topic


class Topics:
    """Topics of one controller. The base class has none.

    Args:
        robot: RobotControl: namespace, world, model, manager, arrivals, buffer_command.
        spec: ControllerSpec.

    Attributes:
        schedules: of what it publishes periodically.
    """

    def __init__(self, robot, spec):
        self._robot, self._spec = robot, spec
        self.schedules, self._endpoints = [], []

    def _every(self, rate, *publishers):
        """A SubscribedSchedule [Hz] for publishers, at most once per physics step."""
        return self._every_while(
            rate, lambda: any(publisher.get_num_connections() > 0 for publisher in publishers)
        )

    def _every_while(self, rate, has_subscribers):
        """As _every, due while a function says so."""
        world = self._robot.world
        schedule = SubscribedSchedule(
            min(rate, 1.0 / world.time_step),
            world.time_step,
            world.step_count,
            has_subscribers,
        )
        self.schedules.append(schedule)
        return schedule

    def _publisher(self, topic, kind):
        made = publisher(topic, kind)
        self._endpoints.append(made)
        return made

    @property
    def name(self):
        """Namespace of the controller."""
        return f"{self._robot.namespace}/{self._spec.name}"

    @property
    def controller(self):
        """The Controller."""
        return self._robot.manager.get(self._spec.name)

    def is_periodic(self):
        """Whether the controller publishes periodically."""
        return bool(self.schedules)

    def publish(self, step, time):
        """Publish what is due; called only while the controller runs."""

    def restart(self, step):
        """Restart the schedules at a step, after a reset or a start."""
        for schedule in self.schedules:
            schedule.restart(step)

    def close(self):
        """Unregister the topics."""
        for endpoint in self._endpoints:
            endpoint.unregister()


class JointStates(Topics):
    """sensor_msgs/JointState of a joint state controller."""

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._states = self._publisher(f"{robot.namespace}/joint_states", JointState)
        self._schedule = self._every(spec.publish_rate, self._states)
        names = robot.manager.hardware.names
        self._numbers = [names.index(name) for name in spec.joints or names]
        joints = [names[number] for number in self._numbers]
        self._extra = [row for row in spec.extra_joints if row[0] not in joints]
        self._sender = PackedJointState(self._states, [*joints, *(row[0] for row in self._extra)])

    def publish(self, step, time):
        """Publish joint states that are due."""
        if not self._schedule.due(step):
            return
        columns = self._robot.manager.hardware.joints.columns(self._numbers)
        for number, column in enumerate(columns, 1):
            column += [row[number] for row in self._extra]
        self._sender.send(time, *columns)


class Commands(Topics):
    """std_msgs/Float64, or Float64MultiArray of a group, into a controller."""

    topic = "command"

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._subscriber = robot.arrivals.subscribe(
            f"{self.name}/{self.topic}", self._kind(), self._on_command, tcp_nodelay=True
        )
        self._endpoints.append(self._subscriber)

    def _kind(self):
        return Float64MultiArray if self._spec.kind.group else Float64

    def _on_command(self, message):
        data = message.data
        self._robot.buffer_command(
            self._spec.name, (data,) if isinstance(data, float) else tuple(data)
        )


class PidCommands(Commands):
    """Commands, and the state topics of a controller with PIDs."""

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        rate = 1.0 / robot.manager.control_period(robot.world.time_step)
        self._state = None
        if not spec.kind.group:
            self._state = self._publisher(f"{self.name}/state", JointControllerState)
            self._schedule = self._every(rate / STATE_EVERY, self._state)
        self._inner = []
        for number, wanted in enumerate(spec.publish_pid):
            if wanted:
                states = self._publisher(
                    f"{self._robot.pid_namespace(spec, number)}/state", PidState
                )
                self._inner.append((self._every(rate, states), number, states))

    def publish(self, step, time):
        """Publish the last update, stamped with the time of its measurement."""
        state_due = self._state is not None and self._schedule.due(step)
        inner_due = [row for row in self._inner if row[0].due(step)]
        if not (state_due or inner_due) or self.controller.sample is None:
            return
        controller = self.controller
        sample = controller.sample
        time -= self._robot.manager.time - sample.time
        if state_due:
            self._state.publish(
                control_messages.controller_state(time, sample, controller.pids[0].gains)
            )
        for _, number, states in inner_due:
            states.publish(control_messages.pid_state(time, sample.period, controller.pids[number]))
