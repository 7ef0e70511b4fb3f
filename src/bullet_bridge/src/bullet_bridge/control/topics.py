"""Topics of loaded controllers: commands in; joint states, PID states and odometry out."""

import math

import rospy
from control_msgs.msg import JointControllerState, PidState
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray
from tf2_msgs.msg import TFMessage

from bullet_bridge.control import messages as control_messages
from bullet_bridge.loop.schedule import HeardSchedule
from bullet_bridge.transport.packed import PackedJointState
from bullet_bridge.transport.publishing import publisher

STATE_EVERY = 10  # updates of a PID controller between two messages on its state topic


class Topics:
    """Topics of one controller; this one has none.

    Args:
        robot: RobotControl: namespace, world, model, manager, arrivals, keep_mail.
        spec: ControllerSpec.
    """

    def __init__(self, robot, spec):
        self._robot, self._spec = robot, spec
        self._schedules, self._wires = [], []

    def _every(self, rate, *wires):
        """A HeardSchedule [Hz] of publishers, at most once per physics step."""
        world = self._robot.world
        schedule = HeardSchedule(
            min(rate, 1.0 / world.time_step),
            world.time_step,
            world.step_count,
            lambda: any(wire.get_num_connections() > 0 for wire in wires),
        )
        self._schedules.append(schedule)
        return schedule

    def _publisher(self, topic, kind):
        wire = publisher(topic, kind)
        self._wires.append(wire)
        return wire

    @property
    def name(self):
        """Namespace of the controller."""
        return f"{self._robot.namespace}/{self._spec.name}"

    @property
    def controller(self):
        """The Controller."""
        return self._robot.manager.get(self._spec.name)

    def is_timed(self):
        """Whether something is published now and then."""
        return bool(self._schedules)

    def next_due(self, look=True):
        """First physics step after which something is to be published, or infinity.

        Args:
            look: look anew who subscribes.
        """
        step = self._robot.world.step_count
        return min(
            [schedule.next_heard(step, look) for schedule in self._schedules], default=math.inf
        )

    def publish(self, step, time):
        """Publish what is due (only called while the controller runs)."""

    def restart(self, step):
        """Count on from a step, after a reset or a start."""
        for schedule in self._schedules:
            schedule.restart(step)

    def close(self):
        """Withdraw the topics."""
        for wire in self._wires:
            wire.unregister()


class JointStates(Topics):
    """sensor_msgs/JointState of a joint state controller."""

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._states = self._publisher(f"{robot.namespace}/joint_states", JointState)
        self._schedule = self._every(spec.publish_rate, self._states)
        names = robot.model.joints.names
        self._kept = [names.index(name) for name in spec.joints or names]  # their numbers
        shown = [names[number] for number in self._kept]
        self._extra = [row for row in spec.extra_joints if row[0] not in shown]
        self._sender = PackedJointState(self._states, [*shown, *(row[0] for row in self._extra)])

    def publish(self, step, time):
        """Publish joint states that are due."""
        if not self._schedule.due(step):
            return
        columns = self._robot.model.joints.columns(self._kept)
        for number, column in enumerate(columns, 1):
            column += [row[number] for row in self._extra]
        self._sender.send(time, *columns)


class Commands(Topics):
    """std_msgs/Float64, or Float64MultiArray of a group, into a controller."""

    topic = "command"

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._subscriber = robot.arrivals.subscribe(
            f"{self.name}/{self.topic}", self._kind(), self._take, tcp_nodelay=True
        )
        self._wires.append(self._subscriber)

    def _kind(self):
        return Float64MultiArray if self._spec.kind.group else Float64

    def _take(self, message):
        data = message.data
        self._robot.keep_mail(self._spec.name, (data,) if isinstance(data, float) else tuple(data))


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
                wire = self._publisher(f"{self._robot.pid_namespace(spec, number)}/state", PidState)
                self._inner.append((self._every(rate, wire), number, wire))

    def publish(self, step, time):
        """Publish the last update, with the time at which its measurement was taken."""
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
        for _, number, wire in inner_due:
            wire.publish(control_messages.pid_state(time, sample.period, controller.pids[number]))


class Drive(Commands):
    """geometry_msgs/Twist into the controller of a base, odometry and its transform out."""

    topic = "cmd_vel"

    def __init__(self, robot, spec):
        super().__init__(robot, spec)
        self._odometry = self._publisher(f"{self.name}/odom", Odometry)
        drive = spec.drive
        self._transform = self._publisher("/tf", TFMessage) if drive.publish_tf else None
        self._outputs = [wire for wire in (self._odometry, self._transform) if wire is not None]
        self._schedule = self._every(spec.publish_rate, *self._outputs)
        self._limited = None
        if drive.publish_command:
            self._limited = self._publisher(f"{self.name}/cmd_vel_out", TwistStamped)
            self._limited_schedule = self._every(
                1.0 / robot.manager.control_period(robot.world.time_step), self._limited
            )

    def _kind(self):
        return Twist

    def _take(self, message):
        values = (message.linear.x, message.angular.z)
        if self._spec.drive.single_publisher and self._subscriber.get_num_connections() > 1:
            rospy.logerr_throttle(
                1.0,
                f"{self.name}/{self.topic} has more than one publisher, "
                "which allow_multiple_cmd_vel_publishers forbids; it brakes",
            )
            values = (0.0, 0.0)
        self._robot.keep_mail(self._spec.name, values)

    def publish(self, step, time):
        """Publish odometry of this very step, and the limited command."""
        if self._limited is not None and self._limited_schedule.due(step):
            self._limited.publish(control_messages.limited_twist(time, *self.controller.limited))
        if not self._schedule.due(step):
            return
        wires = [wire for wire in self._outputs if wire.get_num_connections()]
        self._robot.manager.observe()
        message = control_messages.drive_odometry(time, self._spec.drive, self.controller.odometry)
        for wire in wires:
            wire.publish(
                message
                if wire is self._odometry
                else TFMessage([control_messages.odometry_transform(message)])
            )


def topics_of(robot, spec):
    """The Topics of a ControllerSpec."""
    if spec.kind.interface == "state":
        return JointStates(robot, spec)
    if spec.kind.drive:
        return Drive(robot, spec)
    return (PidCommands if spec.kind.goal else Commands)(robot, spec)
