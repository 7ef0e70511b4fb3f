"""What each plugin takes from outside its own element: its namespace and the prefix of its frames.

Sources: the plugins of gazebo_ros_pkgs (noetic-devel), hector_gazebo (melodic-devel),
velodyne_simulator, realsense_gazebo_plugin; tf::resolve and tf::getPrefixParam of tf.
"""

from __future__ import annotations

from dataclasses import dataclass

ROOT, MODEL = "root", "model"  # namespaces: Gazebo's own, or the name of the plugin's model
# Where the prefix comes from: the parameter tf_prefix in the plugin's namespace alone, the nearest
# one from there upwards, or the namespace itself unless it is the root.
OWN, NEAREST, NAMESPACE = "own", "nearest", "namespace"


@dataclass(frozen=True)
class Rule:
    """Rule of one plugin.

    Attributes:
        missing: namespace without <robotNamespace>: ROOT or MODEL.
        empty: namespace with an empty <robotNamespace>.
        prefix: of its frames: OWN, NEAREST, NAMESPACE; None: they have none.
    """

    missing: str = ROOT
    empty: str = ROOT
    prefix: str | None = None


_UTILS_OF_MODELS = Rule(MODEL, MODEL, NEAREST)  # GazeboRos of gazebo_ros_utils
_UTILS_OF_SENSORS = Rule(ROOT, MODEL, NEAREST)  # GetRobotNamespace of gazebo_ros_utils
_BASE = Rule(ROOT, ROOT, NEAREST)
_PLAIN = Rule(ROOT, ROOT, OWN)
_NONE = Rule()
RULES = {  # by the name of the library
    "gazebo_ros_camera": _UTILS_OF_SENSORS,
    "gazebo_ros_multicamera": _UTILS_OF_SENSORS,
    "gazebo_ros_triggered_camera": _UTILS_OF_SENSORS,
    "gazebo_ros_triggered_multicamera": _UTILS_OF_SENSORS,
    "gazebo_ros_depth_camera": _UTILS_OF_SENSORS,
    "gazebo_ros_openni_kinect": _UTILS_OF_SENSORS,
    "gazebo_ros_laser": _UTILS_OF_SENSORS,
    "gazebo_ros_gpu_laser": _UTILS_OF_SENSORS,
    "gazebo_ros_diff_drive": _UTILS_OF_MODELS,
    "gazebo_ros_skid_steer_drive": _BASE,
    "gazebo_ros_planar_move": _BASE,
    "gazebo_ros_tricycle_drive": _UTILS_OF_MODELS,
    "gazebo_ros_force_based_move": _BASE,
    "ridgeback_ros_force_based_move": _BASE,
    "nexus_ros_force_based_move": _BASE,
    "robotnik_force_based_move": _BASE,
    "r550_force_based_move": _BASE,
    "diffdrive_plugin_6w": _NONE,  # which publishes nothing
    "diffdrive_plugin_multi_wheel": _BASE,
    "gazebo_ros_prosilica": _NONE,  # which publishes nothing
    "ActorPlugin": _NONE,
    "DiffDrivePlugin": _NONE,
    "InitialVelocityPlugin": _NONE,
    "PedestrianSFMPlugin": _NONE,
    "gazebo_ros_force": _NONE,
    "hector_servo_plugin": _NONE,
    "hector_gazebo_reset_plugin": _NONE,
    "gazebo_ros_elevator": _NONE,
    "gazebo_ros_template": _NONE,
    "gazebo_grasp_fix": _NONE,
    "HarnessPlugin": _NONE,
    "gazebo_ros_harness": _NONE,
    "gazebo_ros_projector": _NONE,
    "BuoyancyPlugin": _NONE,
    "LiftDragPlugin": _NONE,
    "livox_laser_simulation": _NONE,
    "gazebo_ros_vacuum_gripper": _NONE,
    "gazebo_ros_wheel_slip": _NONE,
    "WheelSlipPlugin": _NONE,
    "gazebo_ros_block_laser": _PLAIN,
    "gazebo_ros_bumper": _PLAIN,
    "gazebo_ros_f3d": _PLAIN,
    "gazebo_ros_ft_sensor": _PLAIN,
    "gazebo_ros_p3d": _PLAIN,
    "gazebo_ros_range": _PLAIN,
    "gazebo_ros_hand_of_god": _NONE,
    "gazebo_ros_imu": _NONE,
    "gazebo_ros_imu_sensor": Rule(MODEL, ROOT),
    "gazebo_ros_joint_pose_trajectory": _NONE,
    "gazebo_ros_joint_state_publisher": Rule(MODEL, MODEL),
    "gazebo_ros_control": Rule(MODEL, ROOT),
    "hector_gazebo_ros_gps": _NONE,
    "hector_gazebo_ros_imu": _NONE,
    "hector_gazebo_ros_magnetic": _NONE,
    "hector_gazebo_ros_sonar": _NONE,
    "gazebo_ros_velodyne_laser": Rule(ROOT, ROOT, NAMESPACE),
    "gazebo_ros_velodyne_gpu_laser": Rule(ROOT, ROOT, NAMESPACE),
    "realsense_gazebo_plugin": _NONE,
    "roboticsgroup_gazebo_mimic_joint_plugin": _NONE,
    "roboticsgroup_upatras_gazebo_mimic_joint_plugin": _NONE,
    "paddock_state_publisher": _BASE,  # as robot_state_publisher has it
}


def rule_of(library: str) -> Rule:
    """Rule of a plugin by its library's name; that of plugins of users' packages is Rule()."""
    return RULES.get(library, _NONE)


@dataclass(frozen=True)
class FramePrefix:
    """Where a plugin finds the prefix of its frames.

    Attributes:
        source: OWN, NEAREST or NAMESPACE.
        namespace: of the plugin, without slashes at its ends; empty: the root.
    """

    source: str
    namespace: str

    def of(self, parameter: str) -> str:
        """What goes before a frame's name: "", or "PREFIX/".

        Args:
            parameter: value of tf_prefix as this has it looked up; empty: there is none.
        """
        prefix = parameter
        if self.source == NAMESPACE and self.namespace:
            prefix = self.namespace
        prefix = prefix[1:] if prefix.startswith("/") else prefix
        prefix = prefix.rstrip("/") if self.source == NAMESPACE else prefix
        return f"{prefix}/" if prefix else ""


class FrameName(str):
    """Name of a frame as a file has it, without a leading slash.

    Attributes:
        prefix: goes before it; None: nothing does, since the plugin or the name has none.
    """

    prefix: FramePrefix | None = None

    def __new__(cls, name: str, prefix: FramePrefix | None = None) -> FrameName:
        made = super().__new__(cls, name)
        made.prefix = prefix
        return made
