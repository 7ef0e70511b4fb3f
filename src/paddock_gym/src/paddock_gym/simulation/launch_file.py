"""The world that a launch file of ROS makes, read by roslaunch's own reader, without a master.

Nothing of the file is started. What the simulator, spawn_model and the spawners of controllers
would do becomes a Recipe; other nodes are named.
"""

from __future__ import annotations

import argparse
import os
import shlex
from collections.abc import Iterable, Mapping
from typing import Any

from bullet_sim.engine import FIXED_JOINTS
from bullet_sim.formats.lumping import LEAVE_OUT
from bullet_sim.formats.resolve import Resolver
from bullet_sim.pose import Pose

from paddock_gym.errors import GymError
from paddock_gym.simulation.recipe import Recipe, Spawn, read_text

SIMULATORS = {
    ("bullet_bridge", "bridge"),
    *(("gazebo_ros", name) for name in ("gazebo", "gzserver", "debug", "perf", "gdbrun")),
}
SPAWNERS = {
    ("controller_manager", name) for name in ("spawner", "spawner.py", "controller_manager")
}
VALUED = (  # options of gzserver that have a value
    "-e --physics -s --server-plugin -g --gui-plugin -o --profile -p --play --seed --iters "
    "--record_path --record_encoding --record_period --record_filter"
).split()


class _Parser(argparse.ArgumentParser):
    """Raises its errors."""

    def error(self, message: str) -> Any:
        raise ValueError(message)


def from_launch(command: str) -> Recipe:
    """Read a launch file.

    Args:
        command: as for roslaunch: "PACKAGE FILE.launch arg:=value ..." or "PATH arg:=value ...".

    Raises:
        GymError: roslaunch is not there, or cannot read the file.
    """
    try:
        import roslaunch.config
        import roslaunch.core
        import roslaunch.rlutil
    except ImportError as error:
        raise GymError(
            f"launch is {command!r}, which needs ROS: {error}; without ROS give urdf= or sdf=, and "
            "world="
        ) from error
    words = shlex.split(command)
    arguments = [word for word in words if ":=" in word]
    names = [word for word in words if ":=" not in word]
    try:
        files = roslaunch.rlutil.resolve_launch_arguments(names)
        config = roslaunch.config.load_config_default([(files[0], arguments)], None, verbose=False)
    except Exception as error:  # roslaunch, rospkg and xacro have many
        lacks = "package " if type(error).__name__ == "ResourceNotFound" else ""
        raise GymError(
            f"launch is {command!r}: {lacks}{error}; it has to be 'PACKAGE FILE.launch arg:=value "
            "...', all packages that it names have to be there"
        ) from error
    return Reader(config).recipe()


class Reader:
    """Makes the Recipe of roslaunch's configuration."""

    def __init__(self, config: Any) -> None:
        self._config = config
        self._parameters: dict[str, Any] = {}
        for param in config.params.values():
            self._set(param.key, param.value)
        self._resolve = Resolver()
        self._world, self._seed = "", 0
        self._massless, self._fixed_joints = LEAVE_OUT, FIXED_JOINTS[0]
        self._remaps: dict[str, str] = {}
        self._spawns: list[Spawn] = []
        self._controllers: list[tuple[str, str]] = []
        self._left_out: list[str] = []

    def _set(self, key: str, value: Any) -> None:
        *above, name = [part for part in key.split("/") if part]
        tree = self._parameters
        for part in above:
            tree = tree.setdefault(part, {})
        if isinstance(value, Mapping) and isinstance(tree.get(name), dict):
            for inner, item in value.items():
                self._set(f"{key}/{inner}", item)
        else:
            tree[name] = dict(value) if isinstance(value, Mapping) else value

    def _param(self, node: Any, name: str) -> Any:
        """A parameter's value, by its name as a node sees it."""
        from rosgraph.names import resolve_name

        resolved = resolve_name(name, node.namespace.rstrip("/") + "/" + (node.name or "node"))
        resolved = dict(node.remap_args).get(name, resolved)
        return Recipe(parameters=self._parameters).parameter(resolved)

    def recipe(self) -> Recipe:
        """What the nodes would make."""
        for node in self._config.nodes:
            kind = (node.package, node.type)
            words = [word for word in shlex.split(node.args or "") if not word.startswith("__")]
            if kind in SIMULATORS:
                self._simulator(node, words)
            elif node.package == "gazebo_ros" and node.type in ("spawn_model", "spawn_urdf"):
                self._spawn(node, words)
            elif kind in SPAWNERS:
                self._start_controllers(node, words)
            elif node.type not in ("gzclient", "gazebo_gui"):
                self._left_out.append(f"{node.package}/{node.type}")
        return Recipe(
            world=self._world,
            spawns=tuple(self._spawns),
            controllers=tuple(dict.fromkeys(self._controllers)),
            parameters=self._parameters,
            remaps=self._remaps,
            seed=self._seed,
            massless_links=self._massless,
            fixed_joints=self._fixed_joints,
            left_out=tuple(dict.fromkeys(self._left_out)),
            resolve=self._resolve,
        )

    def _simulator(self, node: Any, words: list[str]) -> None:
        from rosgraph.names import resolve_name

        self._world = str(self._param(node, "~world_file") or "")
        massless = self._param(node, "~massless_links")
        self._massless = massless or os.environ.get("PADDOCK_MASSLESS_LINKS") or LEAVE_OUT
        fixed = self._param(node, "~fixed_joints") or os.environ.get("PADDOCK_FIXED_JOINTS")
        self._fixed_joints = fixed or FIXED_JOINTS[0]
        seed = self._param(node, "~seed")
        free = iter(words)
        for word in free:
            if word in VALUED:
                value = next(free, "")
                seed = value if word == "--seed" else seed
            elif not word.startswith("-"):
                self._world = self._world or word
        self._seed = int(seed or 0)
        caller = node.namespace.rstrip("/") + "/gazebo"
        for source, target in node.remap_args:
            self._remaps[resolve_name(source, caller)] = resolve_name(target, caller)

    def _spawn(self, node: Any, words: list[str]) -> None:
        parser = _Parser(prog="spawn_model", add_help=False)
        for flag in ("-urdf", "-sdf", "-package_to_model", "-unpause", "-b", "-stdin", "-gazebo"):
            parser.add_argument(flag, action="store_true")
        for flag in ("-file", "-param", "-database", "-model", "-reference_frame"):
            parser.add_argument(flag, default="")
        for flag in ("-gazebo_namespace", "-wait", "-timeout"):
            parser.add_argument(flag)
        parser.add_argument("-robot_namespace", default=node.namespace)
        for flag in "xyzRPY":
            parser.add_argument(f"-{flag}", type=float, default=0.0)
        parser.add_argument("-J", nargs=2, action="append", default=[])
        try:
            options, _ = parser.parse_known_args(words)
            joints = {name: float(position) for name, position in options.J}
        except ValueError as error:
            raise GymError(f"arguments of spawn_model are {' '.join(words)!r}: {error}") from error
        self._spawns.append(
            Spawn(
                options.model,
                self._text(node, options),
                Pose.from_xyz_rpy(
                    (options.x, options.y, options.z), (options.R, options.P, options.Y)
                ),
                options.robot_namespace,
                options.reference_frame,
                joints,
            )
        )

    def _text(self, node: Any, options: argparse.Namespace) -> str:
        """URDF or SDF of a spawn_model."""
        if options.param:
            text = self._param(node, options.param)
            if not isinstance(text, str) or not text.strip():
                raise GymError(
                    f"spawn_model of '{options.model}' reads the parameter {options.param!r}, "
                    "which the launch file does not set"
                )
        elif options.database:
            text = (
                '<sdf version="1.4"><world name="default"><include><uri>model://'
                f"{options.database}</uri></include></world></sdf>"
            )
        else:
            text = read_text("the file of a spawn_model", options.file, {})
        return text.replace("package://", "model://") if options.package_to_model else text

    def _start_controllers(self, node: Any, words: list[str]) -> None:
        namespace, names, free = node.namespace, [], iter(words)
        if node.type == "controller_manager" and next(free, "") != "spawn":
            return
        for word in free:
            option, equals, value = word.partition("=")
            if option in ("--namespace", "-n", "--ns"):
                given = value if equals else next(free, "")
                namespace = given if given.startswith("/") else f"{namespace.rstrip('/')}/{given}"
            elif option in ("--timeout", "--wait-for", "--shutdown-timeout"):
                _ = equals or next(free, "")
            elif option == "--stopped":
                return
            elif not word.startswith("-"):
                names.append(word)
        namespace = "/" + namespace.strip("/") if namespace.strip("/") else ""
        self._controllers += [(namespace, name) for name in self._named(namespace, names)]

    def _named(self, namespace: str, names: Iterable[str]) -> Iterable[str]:
        """Names of controllers; a YAML file stands for those in it."""
        import yaml

        for name in names:
            if not os.path.isfile(name):
                yield name.strip("/")
                continue
            with open(name, encoding="utf-8") as file:
                for key, entry in (yaml.safe_load(file) or {}).items():
                    self._set(f"{namespace}/{key}", entry)
                    yield key
