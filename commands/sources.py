"""Where sources of ROS packages are: the lists of ./run add, and repositories by package.

config/sources/NAME.repos are files of vcstool; their comments are the fields of Listed.
"""

import glob
import os
import re
from dataclasses import dataclass

from commands.errors import CommandError, UsageError
from commands.paths import ROOT, read, relative

FOLDER = os.path.join(ROOT, "config", "sources")
DATABASE = os.path.join(ROOT, "config", "gazebo_models.txt")
URL = re.compile(r"(?:[a-z+]+://|[\w.-]+@[\w.-]+:).+")
# Packages that no list is there for -> repository of their sources on GitHub and its branch for
# ROS 1, where that is not the default one.
ELSEWHERE = {
    name: repository
    for repository, names in {
        "cartographer-project/cartographer_ros": ("cartographer_ros",),
        "ros-perception/depthimage_to_laserscan": ("depthimage_to_laserscan",),
        "clearpathrobotics/fath_pivot_mount_description": ("fath_pivot_mount_description",),
        "ros-drivers/flir_camera_driver#noetic-devel": ("flir_camera_description",),
        "paulbovbel/frontier_exploration": ("frontier_exploration",),
        "yujinrobot/kobuki": ("kobuki_description", "kobuki_node", "kobuki_safety_controller"),
        "yujinrobot/kobuki_desktop": ("kobuki_gazebo", "kobuki_gazebo_plugins"),
        "ros-perception/laser_filters": ("laser_filters",),
        "clearpathrobotics/LMS1xx#noetic-devel": ("lms1xx",),
        "dfki-ric/mir_robot#noetic": ("mir_description", "mir_gazebo", "mir_navigation"),
        "naturerobots/move_base_flex#noetic": ("mbf_abstract_nav", "mbf_costmap_nav"),
        "OctoMap/octomap_mapping#kinetic-devel": ("octomap_mapping", "octomap_server"),
        "ros-perception/pointcloud_to_laserscan#lunar-devel": ("pointcloud_to_laserscan",),
        "ros-drivers/pointgrey_camera_driver#noetic-devel": ("pointgrey_camera_description",),
        "PR2/pr2_common": ("pr2_description", "pr2_msgs"),
        "locusrobotics/robot_navigation": ("dlux_global_planner", "dwb_local_planner", "nav_core2"),
        "IntelRealSense/realsense-ros#ros1-legacy": ("realsense2_description",),
        "ros/ros_tutorials#noetic-devel": ("roscpp_tutorials", "rospy_tutorials", "turtlesim"),
        "introlab/rtabmap_ros": ("rtabmap_ros",),
        "ros-visualization/rqt_robot_steering": ("rqt_robot_steering",),
        "agilexrobotics/scout_ros": ("scout_base", "scout_bringup", "scout_msgs"),
        "uos/sick_tim#noetic": ("sick_tim",),
        "SteveMacenski/slam_toolbox#noetic-devel": ("slam_toolbox",),
        "turtlebot/turtlebot": ("turtlebot_bringup", "turtlebot_description"),
        "turtlebot/turtlebot_apps": ("turtlebot_navigation",),
        "turtlebot/turtlebot_interactions": ("turtlebot_rviz_launchers",),
        "turtlebot/turtlebot_simulator": ("turtlebot_gazebo",),
        "ros-drivers/velodyne": ("velodyne_pointcloud",),
        "RobotWebTools/web_video_server#ros1": ("web_video_server",),
    }.items()
    for name in names
}


@dataclass(frozen=True)
class Repository:
    """A repository of sources.

    Attributes:
        name: Its folder in src/.
        kind: As vcstool names it: git, tar, zip.
        url: Where it is.
        version: Branch, tag or commit; of an archive the folder in it. Empty: the default branch.
    """

    name: str
    kind: str
    url: str
    version: str = ""


@dataclass(frozen=True)
class Listed:
    """What a file of config/sources/ says.

    Attributes:
        about: What it is, in one line.
        version: Why these branches.
        next: Commands to type then.
        repositories: Tuple of Repository.
        needs: Names of other files without which it is not built.
        without: Packages of the repositories that are disabled.
        packages: Those that it is there for.
    """

    about: str
    version: str
    next: tuple
    repositories: tuple
    needs: tuple = ()
    without: tuple = ()
    packages: tuple = ()


def listed():
    """Lists the names of config/sources/."""
    return sorted(
        os.path.basename(path)[: -len(".repos")] for path in glob.glob(f"{FOLDER}/*.repos")
    )


def entries_of(names):
    """Returns what names stand for, each after what it needs.

    Args:
        names: Of the list, or URLs.

    Returns:
        List of Listed.
    """
    result = {}
    for name in names:
        entry = entry_of(name)
        result.update({needed: entry_of(needed) for needed in entry.needs if needed not in result})
        result[name] = entry
    return list(result.values())


def entry_of(name):
    """Returns what a name of the list or a URL stands for.

    Raises:
        UsageError: It is neither.
    """
    if URL.fullmatch(name):
        url, _, version = name.partition("#")
        folder = folder_of(url)
        if not re.fullmatch(r"[\w.-]+", folder):
            raise UsageError(f"URL is {name!r}; its last part must name the repository")
        return Listed("", "", (), (Repository(folder, "git", url, version),))
    if name not in listed():
        raise UsageError(
            f"name is {name!r}; there are {', '.join(listed())}, or the URL of a repository"
        )
    return read_list(os.path.join(FOLDER, f"{name}.repos"))


def database():
    """Names of the models of Gazebo's database, which Gazebo downloads where a file names them."""
    return frozenset(read(DATABASE).split())


def folder_of(url):
    """Returns the name of the folder into which git clones a URL."""
    return re.sub(r"\.git$", "", url.rstrip("/").rpartition("/")[2].rpartition(":")[2])


def read_list(path):
    """Reads a file of vcstool whose comments are the fields of Listed.

    Raises:
        CommandError: It is not in that format.
    """
    keys = ("about", "version", "next", "needs", "without", "packages")
    words, repositories, fields = {key: [] for key in keys}, [], {}
    for line in read(path).splitlines():
        comment = re.fullmatch(rf"# ({'|'.join(keys)}): (.*)", line)
        entry = re.fullmatch(r"  ([\w.-]+):", line)
        value = re.fullmatch(r"    (type|url|version): (\S+)", line)
        if comment:
            words[comment[1]].append(comment[2])
        elif entry:
            fields = {}
            repositories.append((entry[1], fields))
        elif value:
            fields[value[1]] = value[2]
        elif line.strip() not in ("", "repositories:"):
            raise CommandError(f"{relative(path)}: the line {line!r} is not of a .repos file")
    return Listed(
        " ".join(words["about"]),
        " ".join(words["version"]),
        tuple(words["next"]),
        tuple(
            Repository(name, values["type"], values["url"], values.get("version", ""))
            for name, values in repositories
        ),
        *(
            tuple(name for text in words[key] for name in text.partition("#")[0].split())
            for key in ("needs", "without", "packages")
        ),
    )


def adding(package):
    """Returns the command that brings the sources of a ROS package; empty: none is known."""
    for name in listed():
        if package in entry_of(name).packages:
            return f"./run add {name}"
    if package not in ELSEWHERE:
        return ""
    repository, _, branch = ELSEWHERE[package].partition("#")
    return f"./run add https://github.com/{repository}.git{branch and f'#{branch}'}"
