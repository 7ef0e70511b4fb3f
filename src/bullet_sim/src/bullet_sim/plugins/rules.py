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


UTILS_OF_MODELS = Rule(MODEL, MODEL, NEAREST)  # GazeboRos of gazebo_ros_utils
UTILS_OF_SENSORS = Rule(ROOT, MODEL, NEAREST)  # GetRobotNamespace of gazebo_ros_utils
BASE = Rule(ROOT, ROOT, NEAREST)
PLAIN = Rule(ROOT, ROOT, OWN)
NONE = Rule()
# By the name of the library, entered with the plugin; those of users' packages have that of NONE.
RULES: dict[str, Rule] = {}


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
