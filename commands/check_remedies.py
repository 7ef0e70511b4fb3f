"""What takes the place of what cannot work here, for ./run check: packages and plugins by name."""

import re
import subprocess

from commands.errors import CommandError
from commands.subcommands import deps

# Packages that neither Debian nor Paddock has -> what does the same.
SAME = {
    "cmd_vel_mux": "twist_mux",
    "key_teleop": "teleop_twist_keyboard",
    "robot_pose_ekf": "robot_localization (ekf_localization_node)",
    "turtlebot_teleop": "teleop_twist_keyboard",
    "yocs_cmd_vel_mux": "twist_mux",
}
# Packages that ./run add brings -> its name there.
ADDED = {
    **dict.fromkeys(
        (
            "amcl",
            "base_local_planner",
            "carrot_planner",
            "clear_costmap_recovery",
            "costmap_2d",
            "dwa_local_planner",
            "fake_localization",
            "global_planner",
            "move_base",
            "navfn",
            "navigation",
            "rotate_recovery",
            "voxel_grid",
        ),
        "navigation",
    ),
    **dict.fromkeys(("gmapping", "openslam_gmapping", "slam_gmapping"), "gmapping"),
    **dict.fromkeys(
        ("rosapi", "rosauth", "rosbridge_library", "rosbridge_msgs", "rosbridge_server"),
        "rosbridge_suite",
    ),
    **dict.fromkeys(
        (
            "turtlebot3_bringup",
            "turtlebot3_description",
            "turtlebot3_gazebo",
            "turtlebot3_msgs",
            "turtlebot3_navigation",
            "turtlebot3_slam",
            "turtlebot3_teleop",
        ),
        "turtlebot3",
    ),
}
# Packages that neither has -> repository of their sources and its branch for ROS 1, where that is
# not the default one: ./run add brings it.
SOURCES = {
    name: repository
    for repository, names in {
        "cartographer-project/cartographer_ros": ("cartographer_ros",),
        "rst-tu-dortmund/costmap_converter": ("costmap_converter",),
        "ros-perception/depthimage_to_laserscan": ("depthimage_to_laserscan",),
        "hrnr/m-explore": ("explore_lite", "multirobot_map_merge"),
        "paulbovbel/frontier_exploration": ("frontier_exploration",),
        "tu-darmstadt-ros-pkg/hector_slam": (
            *("hector_geotiff", "hector_mapping", "hector_slam_launch", "hector_trajectory_server"),
        ),
        "husky/husky": (
            *("husky_base", "husky_control", "husky_description", "husky_gazebo"),
            *("husky_navigation", "husky_viz"),
        ),
        "jackal/jackal": (
            *("jackal_control", "jackal_description", "jackal_navigation", "jackal_tutorials"),
        ),
        "jackal/jackal_simulator": ("jackal_gazebo", "jackal_simulator"),
        "yujinrobot/kobuki": ("kobuki_description", "kobuki_node", "kobuki_safety_controller"),
        "yujinrobot/kobuki_desktop": ("kobuki_gazebo", "kobuki_gazebo_plugins"),
        "ros-perception/laser_filters": ("laser_filters",),
        "clearpathrobotics/LMS1xx#noetic-devel": ("lms1xx",),
        "dfki-ric/mir_robot#noetic": ("mir_description", "mir_gazebo", "mir_navigation"),
        "ros-perception/pointcloud_to_laserscan#lunar-devel": ("pointcloud_to_laserscan",),
        "PR2/pr2_common": ("pr2_description", "pr2_msgs"),
        "locusrobotics/robot_navigation": ("dlux_global_planner", "dwb_local_planner", "nav_core2"),
        "IntelRealSense/realsense-ros#ros1-legacy": ("realsense2_description",),
        "introlab/rtabmap_ros": ("rtabmap_ros",),
        "agilexrobotics/scout_ros": ("scout_base", "scout_bringup", "scout_msgs"),
        "agilexrobotics/ugv_gazebo_sim": ("scout_control", "scout_description", "scout_gazebo_sim"),
        "SteveMacenski/slam_toolbox#noetic-devel": ("slam_toolbox",),
        "rst-tu-dortmund/teb_local_planner": ("teb_local_planner",),
        "turtlebot/turtlebot": ("turtlebot_bringup", "turtlebot_description"),
        "turtlebot/turtlebot_apps": ("turtlebot_navigation",),
        "turtlebot/turtlebot_interactions": ("turtlebot_rviz_launchers",),
        "turtlebot/turtlebot_simulator": ("turtlebot_gazebo",),
        "ros-drivers/velodyne": ("velodyne_pointcloud",),
        "RobotWebTools/web_video_server#ros1": ("web_video_server",),
    }.items()
    for name in names
}
# Libraries of Gazebo plugins that are not here -> what is.
PLUGINS = {
    "hector_gazebo_thermal_camera": "libgazebo_ros_camera.so has the image in its own colors",
}
OWN_PLUGIN = "a Python class can take its place (docs/tutorials/your_own_simulation.md)"
GENERIC = "./run deps PATH names Debian's packages, others have to be in your workspace as sources"
_NOT_FOUND = re.compile(r"Resource not found: ([\w-]+)|\b[Pp]ackage '([\w-]+)' not found")


def for_package(name, existing=deps.existing, resolve=deps.resolve):
    """A sentence's end: where a ROS package comes from, or what does the same.

    Args:
        existing: From names of Debian packages to those that exist.
        resolve: See deps.resolve().
    """
    if name in SAME:
        return f"{SAME[name]} does the same"
    try:
        known = existing(resolve([name])[name])
    except (OSError, subprocess.CalledProcessError, CommandError, SystemExit):  # no apt here
        known = set()
    if known:
        return f"apt-get install {' '.join(sorted(known))}"
    if name in ADDED:
        return f"./run add {ADDED[name]}"
    if name in SOURCES:
        repository, _, branch = SOURCES[name].partition("#")
        return f"./run add https://github.com/{repository}.git{branch and f'#{branch}'}"
    return GENERIC


def finding(text):
    """What a sentence says is missing, without the ones that there are or may be meant."""
    return text.partition("; ")[0]


def for_plugin(library):
    """A sentence's end: what takes the place of a plugin's library (libNAME.so)."""
    name = re.sub("^lib", "", library).partition(".so")[0]
    return PLUGINS.get(name, OWN_PLUGIN)


def named_packages(text):
    """Names of the packages that a message of roslaunch misses."""
    return [first or second for first, second in _NOT_FOUND.findall(text or "")]


def missing_packages(found):
    """Names of the packages that are not there, of what check_observer.py has written."""
    names = [
        package for package, is_there, *_ in found.get("builders", {}).values() if not is_there
    ]
    return list(dict.fromkeys([*names, *named_packages(found.get("refused"))]))
