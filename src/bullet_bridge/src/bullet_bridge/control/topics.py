"""Topics of controllers: commands in, states out."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.controllers import Controller, drive, four_wheel, joint
from bullet_sim.controllers.drive_settings import DriveConfig
from bullet_sim.parts.outputs import Output
from bullet_sim.parts.schedule import SubscribedSchedule
from bullet_sim.registry import ByClass
from control_msgs.msg import JointControllerState, JointTrajectoryControllerState, PidState
from four_wheel_steering_msgs.msg import FourWheelSteering, FourWheelSteeringStamped
from geometry_msgs.msg import TwistStamped
from paddock_common.reconfigure import describe

from bullet_bridge.plugins.base import (
    PluginContext,
    RosPart,
    has_subscribers,
    make_plugin,
)
from bullet_bridge.transport.conversions import header
from bullet_bridge.transport.senders import message_class, sender
from bullet_sim import robots as control

if TYPE_CHECKING:
    from bullet_sim.controllers.joint import Sample
    from bullet_sim.controllers.pid import Pid, PidGains


def controller_state(time: float, sample: Sample, gains: PidGains) -> JointControllerState:
    """control_msgs/JointControllerState of a Sample and PidGains; `time` [s] of the sample."""
    return JointControllerState(
        header=header(time),
        set_point=sample.set_point,
        process_value=sample.process_value,
        process_value_dot=sample.process_value_dot,
        error=sample.error,
        time_step=sample.period,
        command=sample.command,
        p=gains.p,
        i=gains.i,
        d=gains.d,
        i_clamp=gains.i_clamp_max,
        antiwindup=gains.antiwindup,
    )


def pid_state(time: float, period: float, pid: Pid) -> PidState:
    """control_msgs/PidState of a Pid; `time` and `period` [s] of its last computation."""
    return PidState(
        header=header(time),
        timestep=rospy.Duration.from_sec(period),
        error=pid.error,
        error_dot=pid.error_rate,
        p_error=pid.error,
        i_error=pid.integral,
        d_error=pid.error_rate,
        p_term=pid.terms[0],
        i_term=pid.terms[1],
        d_term=pid.terms[2],
        i_max=pid.gains.i_clamp_max,
        i_min=pid.gains.i_clamp_min,
        output=pid.output,
    )


def four_wheel_state(
    time: float, frame: str, odometry: four_wheel.FourWheelOdometry
) -> FourWheelSteeringStamped:
    """four_wheel_steering_msgs/FourWheelSteeringStamped of a FourWheelOdometry."""
    message = FourWheelSteeringStamped(header=header(time, frame))
    data = message.data
    data.speed, data.acceleration, data.jerk = (
        odometry.speed,
        odometry.acceleration,
        odometry.jerk,
    )
    data.front_steering_angle, data.rear_steering_angle = odometry.angles
    data.front_steering_angle_velocity, data.rear_steering_angle_velocity = odometry.rates
    return message


ROS_SIDE: ByClass[type[Topics]] = ByClass()  # of classes of controllers
ros_side = ROS_SIDE.enter


STATE_EVERY = 10  # updates of a PID controller between two messages on its state topic


class Topics(RosPart, control.Topics):
    """Topics in ROS of one controller, of a RobotControl. The base class has none."""

    def __init__(self, robot: Any, controller: Any) -> None:
        RosPart.__init__(self, robot.received)
        super(RosPart, self).__init__(robot, controller)

    def output(self, output: Output) -> Any:
        """What sends on a topic of ROS, see Sender."""
        return sender(self, output)

    def _every_published(self, rate: float, publisher: Any) -> SubscribedSchedule:
        """A SubscribedSchedule [Hz] for a publisher, at most once per physics step."""
        return self._every_while(rate, lambda: has_subscribers(publisher))


@ros_side(joint.JointState)
class JointStates(Topics, control.JointStates):
    """sensor_msgs/JointState of a joint state controller."""


@ros_side(Controller)
class Commands(Topics, control.Commands):
    """Commands into a controller."""

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        for topic, (message, callback) in self.commands().items():
            kind = message_class(message)
            self._subscriber = self.subscribe(topic, kind, callback, tcp_nodelay=True)


@ros_side(joint.PidControl)
class PidCommands(Commands):
    """Commands, and the state topics of a controller with PIDs."""

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        rate = 1.0 / robot.manager.control_period(robot.world.time_step)
        self._state: Any = None
        if not controller.group:
            self._state = self.publisher(f"{self.name}/state", JointControllerState)
            self._schedule = self._every_published(rate / STATE_EVERY, self._state)
        self._inner: list[tuple[SubscribedSchedule, int, Any]] = []
        config = self.config
        for number, (published, gains) in enumerate(zip(config.publish_pid, config.gain_names)):
            if published:
                states = self.publisher(f"{self.name}/{gains}/state", PidState)
                self._inner.append((self._every_published(rate, states), number, states))

    def publish(self, step: int, time: float) -> None:
        """Publish the last update, stamped with the time of its measurement."""
        state_due = self._state is not None and self._schedule.due(step)
        inner_due = [row for row in self._inner if row[0].due(step)]
        if not (state_due or inner_due) or self.controller.sample is None:
            return
        controller = self.controller
        sample = controller.sample
        time -= self._robot.manager.time - sample.time
        if state_due:
            self._state.publish(controller_state(time, sample, controller.pids[0].gains))
        for _, number, states in inner_due:
            states.publish(pid_state(time, sample.period, controller.pids[number]))


@ros_side(drive.Drive)
class Drive(Commands, control.Drive):
    """geometry_msgs/Twist into the controller of a base, odometry and its transform out."""

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        self._limited = None
        if self.config.publish_command:
            self._limited = self.publisher(f"{self.name}/cmd_vel_out", TwistStamped)
            self._limited_schedule = self._every_published(
                1.0 / robot.manager.control_period(robot.world.time_step), self._limited
            )

    def _on_command(self, message: Any) -> None:
        values = (message.linear.x, message.angular.z)
        if self.config.single_publisher and self._subscriber.get_num_connections() > 1:
            rospy.logerr_throttle(
                1.0,
                f"{self.name}/{self.topic} has more than one publisher, "
                "which allow_multiple_cmd_vel_publishers forbids; it brakes",
            )
            values = (0.0, 0.0)
        self._robot.commands[self.config.name] = values

    def publish(self, step: int, time: float) -> None:
        """Publish the odometry of this step and the limited command."""
        if self._limited is not None and self._limited_schedule.due(step):
            message = TwistStamped(header=header(time))
            message.twist.linear.x, message.twist.angular.z = self.controller.limited
            self._limited.publish(message)
        super().publish(step, time)


DIFF_DRIVE = describe(  # diff_drive_controller/DiffDriveController.cfg
    [
        *(
            (f"{name}_multiplier", "double", 1.0, 0.5, 1.5, f"Multiplier of the {text}.")
            for name, text in (
                ("left_wheel_radius", "left wheels' radius"),
                ("right_wheel_radius", "right wheels' radius"),
                ("wheel_separation", "wheel separation"),
            )
        ),
        ("publish_rate", "double", 50.0, 0.0, 2000.0, "Rate of the odometry [Hz]; 0: none."),
        ("enable_odom_tf", "bool", True, False, True, "Publish the odometry's transform."),
    ]
)
_MULTIPLIERS = tuple(  # in the order of DriveConfig's
    f"{name}_multiplier" for name in ("wheel_separation", "left_wheel_radius", "right_wheel_radius")
)
_NEVER = 1e-9  # [Hz] a schedule's rate in place of 0


@ros_side(drive.DiffDrive)
class DiffDrive(Drive, control.DiffDrive):
    """Also parameters by dynamic_reconfigure, and what the wheels do."""

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        config = self.config
        self._wheels: Any = None
        if config.publish_wheels:
            self._wheels = self.publisher(
                f"{self.name}/wheel_joint_controller_state", JointTrajectoryControllerState
            )
            self._wheels_schedule = self._every_published(
                1.0 / robot.manager.control_period(robot.world.time_step), self._wheels
            )
            names = robot.manager.hardware.names
            self._numbers = [names.index(name) for name in config.joints]
        self._parameters = {
            **dict(zip(_MULTIPLIERS, config.multipliers)),
            "publish_rate": config.publish_rate,
            "enable_odom_tf": config.publish_tf,
        }
        self.reconfigure(self.name, DIFF_DRIVE, self._parameters, self._on_parameters)

    def _on_parameters(self, parameters: Any, _level: int) -> Any:
        separation, left, right = (parameters[name] for name in _MULTIPLIERS)
        rate, with_tf = parameters["publish_rate"], parameters["enable_odom_tf"]
        if not all(map(math.isfinite, (separation, left, right, rate))):
            rospy.logerr(
                "%s: multipliers %s and publish_rate %s must be finite numbers; they are unchanged",
                self.name,
                (separation, left, right),
                rate,
            )
            parameters.update(self._parameters)
            return parameters
        self._robot.call(lambda: self._tune((separation, left, right), rate, with_tf))
        self._parameters = {name: parameters[name] for name in self._parameters}
        return parameters

    def _tune(
        self, multipliers: tuple[float, float, float], publish_rate: float, publish_tf: bool
    ) -> None:
        """Change the parameters (simulation thread)."""
        self.controller.tune(multipliers, publish_rate, publish_tf)
        self._asked[self._schedule] = publish_rate or _NEVER
        self._adjust(self._schedule)

    def publish(self, step: int, time: float) -> None:
        """As a Drive; and the wheels of the last update."""
        super().publish(step, time)
        if self._wheels is None or not self._wheels_schedule.due(step):
            return
        positions, _, efforts = self._robot.manager.hardware.joints.columns(self._numbers)
        message = wheel_state(time, self.config, self.controller.wheels, positions, efforts)
        self._wheels.publish(message)


def wheel_state(
    time: float,
    config: DriveConfig,
    wheels: drive.WheelMotion,
    positions: Sequence[float],
    efforts: Sequence[float],
) -> JointTrajectoryControllerState:
    """control_msgs/JointTrajectoryControllerState of the wheels of a DiffDrive.

    Args:
        time: simulated [s].
        positions, efforts: of all wheels [rad, N m]; an effort is not commanded: NaN.
    """
    count = len(config.left)
    message = JointTrajectoryControllerState(
        header=header(time), joint_names=[*config.left, *config.right]
    )
    commanded = (wheels.positions, wheels.velocities, wheels.accelerations, (math.nan, math.nan))
    measured = (positions, wheels.measured_velocities, wheels.measured_accelerations, efforts)
    for name, (left, right), values in zip(
        ("positions", "velocities", "accelerations", "effort"), commanded, measured
    ):
        targets = [left] * count + [right] * count
        setattr(message.desired, name, targets)
        setattr(message.actual, name, list(values))
        setattr(message.error, name, [a - b for a, b in zip(targets, values)])
    return message


@ros_side(four_wheel.FourWheel)
class FourWheelDrive(Drive):
    """Also takes four_wheel_steering_msgs/FourWheelSteering and publishes it on odom_steer.

    As upstream sizes that are measured in the URDF become parameters.
    """

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        config = self.config
        rospy.set_param(f"{self.name}/wheel_steering_y_offset", config.offset)
        for key, value in (
            ("track", config.track + 2.0 * config.offset),
            ("wheel_radius", config.radius),
            ("wheel_base", config.wheel_base),
        ):
            if rospy.get_param(f"{self.name}/{key}", None) is None:
                rospy.set_param(f"{self.name}/{key}", value)
        topic = f"{self.name}/cmd_four_wheel_steering"
        self.subscribe(topic, FourWheelSteering, self._on_angles)
        self._steering = self.publisher(f"{self.name}/odom_steer", FourWheelSteeringStamped)
        self._steering_schedule = self._every_published(self.config.publish_rate, self._steering)
        self.waiting.append(self._steering_schedule)

    def _on_angles(self, message: Any) -> None:
        values = (message.speed, message.front_steering_angle, message.rear_steering_angle)
        self._robot.commands[self.config.name] = values

    def publish(self, step: int, time: float) -> None:
        """Publish the odometry of this step, also as speed and steering angles."""
        super().publish(step, time)
        if self._steering_schedule.due(step):
            self._robot.manager.observe()
            self._steering.publish(
                four_wheel_state(time, self.config.odom_frame, self.controller.odometry)
            )


@ros_side(joint.SensorController)
class Sensors(Topics):
    """Each sensor of one type on a topic named after it, in the robot's namespace.

    A joint's sensor has the joint's name.
    """

    def __init__(self, robot: Any, controller: Any) -> None:
        super().__init__(robot, controller)
        self._sensors, config = [], self.config
        for spec in robot.model.description.sensors:
            if vars(type(spec)).get("INTERFACE") != controller.interface:
                continue
            name = getattr(spec, "joint", spec.name)
            rate = min(config.publish_rate, 1.0 / robot.world.time_step)
            adapted = replace(spec, topic=f"{robot.namespace}/{name}", rate=rate)
            seed = zlib.crc32(f"{config.name}/{name}".encode())
            sensor = make_plugin(PluginContext(robot.world, robot.model, adapted, seed))
            self._sensors.append(sensor)
            self.schedules.append(sensor.schedule)

    def publish(self, step: int, time: float) -> None:
        """Publish the sensors that are due."""
        for sensor in self._sensors:
            if sensor.schedule.due(step):
                sensor.update(time, time - sensor.updated)
                sensor.updated = time

    def restart(self, step: int, fresh: bool = True) -> None:
        for sensor in self._sensors if fresh else ():
            sensor.reset(self._robot.world.time)

    def close(self) -> None:
        for sensor in self._sensors:
            sensor.close()
        super().close()
