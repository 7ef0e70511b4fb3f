"""A replay of a rosbag: the poses of its odometry and the joints of its joint states, in 3-D.

A bag has no models. The world and the robot come from launch files' own sources: the track by its
name, our car or our truck by the topics in the bag, any other robot by its URDF file.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import rospkg
from bullet_sim.errors import SimError
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.pose import Pose, Quat, Vec3, compose
from bullet_sim.sensors.scenes import WorldViews
from bullet_sim.world import World
from paddock_common.bags import BagError

from bullet_web import files
from bullet_web.replay import Recording
from bullet_web.scene import SceneMaker
from paddock_common import bags

ODOMETRY, JOINTS, LAP = "nav_msgs/Odometry", "sensor_msgs/JointState", "track_model/LapStatus"
RESETS = 100  # of the stamps, at most: more of them are of two clocks in one topic
RATE = 30.0  # frames a second of the bag's time


@dataclass(frozen=True)
class Robot:
    """A robot that is known by its topics.

    Attributes:
        odometry: topics with its pose, the best first.
        xacro: package, file and arguments of its description.
        world: package and world file; empty: a track.
    """

    name: str
    odometry: tuple[str, ...]
    joints: str
    xacro: tuple[str, ...]
    world: tuple[str, ...] = ()


ROBOTS = (
    Robot(
        "racecar",
        ("/racecar/odom",),
        "/racecar/joint_states",
        ("track_model", "urdf/racecar.urdf.xacro"),
    ),
    Robot(
        "cybertruck",
        ("/ground_truth/odom", "/odom"),
        "/cybertruck/joint_states",
        ("cybertruck", "urdf/cybertruck.urdf.xacro", "trailer:=true"),
        ("cybertruck", "worlds/yard.world"),
    ),
)


def resolve(uri: str) -> str:
    """Path of a package:// or file:// address, or of a path."""
    if uri.startswith("package://"):
        package, _, rest = uri[len("package://") :].partition("/")
        try:
            return os.path.join(rospkg.RosPack().get_path(package), rest)
        except rospkg.ResourceNotFound:
            return uri
    return re.sub("^file://", "", uri)


def output_of(*command: str) -> str:
    """What a program prints.

    Raises:
        BagError: it fails, or there is none.
    """
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise BagError(f"{command[0]}: {error.strerror}") from error
    if done.returncode:
        raise BagError(f"{command[0]}: {done.stderr.strip() or f'exit code {done.returncode}'}")
    return done.stdout


def file_of(package: str, name: str) -> str:
    """A package's file.

    Raises:
        BagError: there is no such package.
    """
    try:
        return os.path.join(rospkg.RosPack().get_path(package), name)
    except rospkg.ResourceNotFound as error:
        raise BagError(f"there is no package {package}") from error


class TwoClocks(Exception):
    """Stamps go back again and again."""


class Stage:
    """A world with the robot, which is put where the bag has it; no physics runs.

    Args:
        robot: URDF text.
        world: world file; empty: the track.
    """

    def __init__(self, name: str, robot: str, world: str, track: str) -> None:
        self._world = World(massless_links="keep")  # a real robot has them, whatever Gazebo does
        if world:
            with open(world, encoding="utf-8") as stream:
                self._world.load(parse_world(stream.read(), resolve))
        else:
            text = output_of(file_of("track_model", "scripts/make_track"), "--sdf", track)
            self._world.spawn_sdf("track", text, Pose(), resolve)
        model = self._world.spawn_urdf(name, robot, Pose(), resolve)
        source = WorldViews(self._world).scene()
        self._body = next(body for body in source["bodies"] if body["name"] == model.name)
        self._joints = [link["joint"] for link in self._body["links"] if link["kind"] != "fixed"]
        self._positions = dict.fromkeys(self._joints, 0.0)
        self.maker = SceneMaker()
        self.scene = self.maker.make(source)

    def close(self) -> None:
        """Free the engine."""
        self._world.close()

    def frame_pose(self, link: str, position: Vec3, orientation: Quat) -> tuple[Vec3, Quat]:
        """Pose of the robot's root from that of one of its links on fixed joints."""
        row, *numbers = self._body["frames"].get(link, [0, 0, 0, 0, 0, 0, 0, 1])
        if row:
            return position, orientation  # on a joint that moves: taken as it is
        x, y, z, *turn = numbers
        a, b, c, d = turn
        offset = Pose((x, y, z), (a, b, c, d)).inverse()
        return compose(position, orientation, offset.position, offset.orientation)

    def set_joints(self, names: Sequence[str], positions: Sequence[float]) -> None:
        """Follow a JointState."""
        for name, position in zip(names, positions):
            if name in self._positions and math.isfinite(position):
                self._positions[name] = position

    def row(self, position: Vec3, orientation: Quat) -> list[float]:
        """The robot's row of a view."""
        return [self._body["key"], *position, *orientation, *self._positions.values()]


@dataclass(frozen=True)
class Choice:
    """What of a bag is shown."""

    name: str
    odometry: str
    joints: str
    urdf: str
    world: str


def choose(topics: dict[str, str], options: argparse.Namespace) -> Choice:
    """Find the robot of a bag.

    Args:
        topics: types by topic.
        options: of the command line.

    Raises:
        BagError: there is no odometry, or nothing tells the robot.
    """
    odometry = [topic for topic in sorted(topics) if topics[topic] == ODOMETRY]
    if options.odometry and options.odometry not in odometry:
        raise BagError(
            f"--odometry is {options.odometry!r}; the bag's topics of type {ODOMETRY} are "
            f"{', '.join(odometry) or '(none)'}"
        )
    if not odometry:
        raise BagError(f"the bag has no topic of type {ODOMETRY}; it has {', '.join(topics)}")
    joints = [topic for topic in sorted(topics) if topics[topic] == JOINTS]
    for robot in ROBOTS:
        if robot.joints in joints and not options.urdf:
            mine = [topic for topic in robot.odometry if topic in odometry]
            if options.odometry or mine:
                package, name, *arguments = robot.xacro
                urdf = output_of("xacro", file_of(package, name), *arguments)
                world = options.world or (file_of(*robot.world) if robot.world else "")
                topic = options.odometry or mine[0]
                return Choice(robot.name, topic, robot.joints, urdf, world)
    if not options.urdf:
        raise BagError(
            "nothing in the bag tells which robot it is; name its description: --urdf FILE"
        )
    urdf = output_of("xacro", options.urdf)
    return Choice(
        "robot", options.odometry or odometry[0], (joints or [""])[0], urdf, options.world
    )


def frames(
    bag: bags.Bag, choice: Choice, stage: Stage, recording: Recording, stamped: bool
) -> Iterator[float]:
    """Add the frames of a bag to a recording; yields their times.

    Args:
        stamped: by the messages' stamps; False: by the times at which they were recorded.

    Raises:
        TwoClocks: the stamps of the odometry go back more often than time is reset.
    """
    last, resets = -math.inf, 0
    topics = {choice.odometry: ODOMETRY, choice.joints: JOINTS, "/referee/status": LAP}
    for topic, message, stamp in bag.messages(topics):
        if topic == choice.joints:
            stage.set_joints(message.name, message.position)
            continue
        time = ((stamped and message.header.stamp) or stamp).to_sec()
        if topic == "/referee/status":
            recording.add_value("to the center line", "m", time, message.lateral_error)
            continue
        if last <= time < last + 1.0 / RATE:
            continue
        p, q = message.pose.pose.position, message.pose.pose.orientation
        numbers = (p.x, p.y, p.z, q.x, q.y, q.z, q.w)
        if not all(map(math.isfinite, numbers)) or not any(numbers[3:]):
            continue
        resets += time < last
        if resets > RESETS and stamped:
            raise TwoClocks
        last = time
        link = message.child_frame_id.rpartition("/")[2]
        pose = stage.frame_pose(link, numbers[:3], numbers[3:])
        recording.add(time, [stage.row(*pose)])
        yield time


def make(options: argparse.Namespace) -> str:
    """Write a replay; returns what was done.

    Raises:
        SimError, OSError, ValueError: it cannot be made.
    """
    with bags.Bag(options.bag) as bag:
        choice = choose(bag.topics, options)
        stage = Stage(choice.name, choice.urdf, choice.world, options.track)
        try:
            recording, times, note = recorded(bag, choice, stage, os.path.basename(options.bag))
        finally:
            stage.close()
    if not times and choice.odometry in bag.others:
        raise BagError(f"{choice.odometry} has another definition than {ODOMETRY}")
    if not times:
        raise BagError(f"{choice.odometry} has no message with a valid pose")
    size = recording.write(options.out, files.read(files.REPLAY))
    length = max(times) - min(times)
    return f"{options.out}: {len(times)} frames, {length:.1f} s, {size / 1e6:.1f} MB{note}"


def recorded(
    bag: bags.Bag, choice: Choice, stage: Stage, title: str
) -> tuple[Recording, list[float], str]:
    """Record a bag; returns the recording, its times and what is to be said about them."""
    for stamped in (True, False):
        recording = Recording(title)
        recording.set_scene(stage.scene, stage.maker.assets)
        try:
            times = list(frames(bag, choice, stage, recording, stamped))
        except TwoClocks:
            continue
        break
    note = "" if stamped else (
        f"; by the times of the bag: the stamps of {choice.odometry} go back more than {RESETS} "
        "times, as those of two publishers"
    )  # fmt: skip
    return recording, times, note


def command_line() -> argparse.ArgumentParser:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="replay", description="Make a replay, an HTML file, of a rosbag."
    )
    parser.add_argument("bag", metavar="FILE.bag", help="the bag")
    parser.add_argument("--out", metavar="FILE.html", help="what to write; by default FILE.html")
    parser.add_argument("--track", default="default", help="its track: a name or a file")
    parser.add_argument("--world", default="", metavar="FILE", help="a world file, not a track")
    parser.add_argument("--urdf", default="", metavar="FILE", help="the robot: URDF or xacro")
    parser.add_argument(
        "--odometry", default="", metavar="TOPIC", help="the topic with the robot's pose"
    )
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Make a replay; returns the exit code."""
    options = command_line().parse_args(arguments)
    if not options.out:
        options.out = os.path.splitext(options.bag)[0] + ".html"
    try:
        print(f"replay: {make(options)}")
    except (SimError, OSError, ValueError) as error:
        print(f"replay: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
