"""Controller types as a table."""

from dataclasses import dataclass

from bullet_sim.controllers.pid import PidGains

INTERFACES = {
    "velocity": "hardware_interface::VelocityJointInterface",
    "position": "hardware_interface::PositionJointInterface",
    "effort": "hardware_interface::EffortJointInterface",
    "state": "hardware_interface::JointStateInterface",
    "imu": "hardware_interface::ImuSensorInterface",
    "force_torque": "hardware_interface::ForceTorqueSensorInterface",
}


@dataclass(frozen=True)
class Kind:
    """A controller type.

    Attributes:
        type: its ros_control name.
        interface: what it commands: velocity, position, effort; state: nothing; imu, force_torque:
            sensors that it publishes.
        group: several joints, with a command each.
        goal: what a PID regulates, velocity or position; None: the command goes to the joint.
        drive: 'diff', 'ackermann' or 'four_wheel' for a controller of a whole base; None
            otherwise.
        action: 'trajectory' or 'gripper' for a controller whose goals come by an action.
    """

    type: str
    interface: str
    group: bool = False
    goal: str | None = None
    drive: str | None = None
    action: str | None = None

    @property
    def reports_sensors(self):
        """Whether it publishes a robot's sensors."""
        return self.interface in ("imu", "force_torque")

    @property
    def hardware_interface(self):
        """Name of the ros_control hardware interface, as list_controllers reports it."""
        return INTERFACES[self.interface]


KINDS = {
    kind.type: kind
    for kind in (
        Kind("joint_state_controller/JointStateController", "state"),
        Kind("imu_sensor_controller/ImuSensorController", "imu"),
        Kind("force_torque_sensor_controller/ForceTorqueSensorController", "force_torque"),
        Kind("velocity_controllers/JointVelocityController", "velocity"),
        Kind("velocity_controllers/JointGroupVelocityController", "velocity", True),
        Kind("velocity_controllers/JointPositionController", "velocity", goal="position"),
        Kind("position_controllers/JointPositionController", "position"),
        Kind("position_controllers/JointGroupPositionController", "position", True),
        Kind("effort_controllers/JointEffortController", "effort"),
        Kind("effort_controllers/JointGroupEffortController", "effort", True),
        Kind("effort_controllers/JointPositionController", "effort", goal="position"),
        Kind("effort_controllers/JointGroupPositionController", "effort", True, goal="position"),
        Kind("effort_controllers/JointVelocityController", "effort", goal="velocity"),
        Kind("diff_drive_controller/DiffDriveController", "velocity", drive="diff"),
        Kind(
            "ackermann_steering_controller/AckermannSteeringController",
            "velocity",
            drive="ackermann",
        ),
        Kind("steer_drive_controller/SteerDriveController", "velocity", drive="ackermann"),
        Kind(
            "four_wheel_steering_controller/FourWheelSteeringController",
            "velocity",
            drive="four_wheel",
        ),
        *(
            Kind(f"{name}_controllers/JointTrajectoryController", name, True, action="trajectory")
            for name in ("position", "velocity", "effort")
        ),
        *(
            Kind(f"{name}_controllers/GripperActionController", name, action="gripper")
            for name in ("position", "effort")
        ),
    )
}


@dataclass(frozen=True)
class ControllerSpec:
    """One checked entry of the controllers' YAML.

    Attributes:
        name: the entry's key.
        kind: its row of the table.
        joints: joint names; empty for a state controller that reports all.
        publish_rate: of joint states, odometry or sensors [Hz].
        gains: PidGains of each joint, where the type has a PID.
        publish_pid: whether each joint's PID publishes its inner state.
        extra_joints: (name, position, velocity, effort) added to joint states.
        drive: DriveConfig or FourWheelConfig of a controller of a whole base.
        action: TrajectoryConfig or GripperConfig of a controller with an action.
        claims: (interface, joint names) pairs; empty for a state controller.
        notes: sentences about keys that are accepted without effect.
        warnings: sentences about keys that are ignored.
    """

    name: str
    kind: Kind
    joints: tuple[str, ...] = ()
    publish_rate: float = 50.0
    gains: tuple[PidGains, ...] = ()
    publish_pid: tuple[bool, ...] = ()
    extra_joints: tuple[tuple[str, float, float, float], ...] = ()
    drive: object | None = None
    action: object | None = None
    claims: tuple[tuple[str, tuple[str, ...]], ...] = ()
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def command_sizes(self):
        """Numbers in a command, a tuple of what is taken.

        One a joint; a base: forward and turning velocity; one with four steered wheels also speed,
        front and rear angle.
        """
        if self.kind.drive:
            return (2, 3) if self.kind.drive == "four_wheel" else (2,)
        return (len(self.joints),)
