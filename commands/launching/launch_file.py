"""Launch files and their arguments, tracks and policies by name: checked before a start."""

import json
import os

from commands.errors import CommandError, UsageError
from commands.paths import OUT, PYTHON, SOURCES, read, relative

TRACK_FOLDER = os.path.join(SOURCES, "track_model", "tracks")
TRACK_SUFFIXES = (".yaml", ".yml", ".npy", ".csv")
TRAININGS = os.path.join(OUT, "train")
POLICY_FILE = "policy.onnx"
ROSLAUNCH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "roslaunch")


def track_names():
    """Lists the shipped tracks."""
    return sorted(
        name[: -len(".yaml")] for name in os.listdir(TRACK_FOLDER) if name.endswith(".yaml")
    )


def resolve_track(value):
    """Checks a track.

    Args:
        value: A shipped track's name, or a path.

    Returns:
        The name, or the absolute path: launched nodes have another current directory.

    Raises:
        UsageError: There is no such track.
    """
    if value in track_names():
        return value
    if not os.path.isfile(value):
        raise UsageError(
            f"track is {value!r}; there are {', '.join(track_names())}, or the path of a YAML, "
            ".npy or .csv file"
        )
    if not value.lower().endswith(TRACK_SUFFIXES):
        raise UsageError(f"track is {value!r}; a track file ends in {', '.join(TRACK_SUFFIXES)}")
    return os.path.realpath(value)


def policy_names():
    """Lists the trainings that have left a policy."""
    if not os.path.isdir(TRAININGS):
        return []
    return sorted(
        name
        for name in os.listdir(TRAININGS)
        if os.path.isfile(os.path.join(TRAININGS, name, POLICY_FILE))
    )


def resolve_policy(value):
    """Returns a policy's file.

    Args:
        value: A training's name, or the path of an ONNX file.

    Raises:
        UsageError: There is no such policy.
    """
    if value in policy_names():
        return os.path.join(TRAININGS, value, POLICY_FILE)
    if value.endswith(".onnx") and os.path.isfile(value):
        return os.path.realpath(value)
    found = ", ".join(policy_names()) or "none yet: ./run train makes one"
    raise UsageError(f"policy is {value!r}; there are {found}; or the path of an .onnx file")


def policy_settings(path):
    """Returns the settings of the training that made a policy; empty where there are none."""
    text = read(os.path.join(os.path.dirname(path), "settings.json"))
    return json.loads(text) if text else {}


class LaunchFile:
    """A launch file of this workspace.

    Attributes:
        package: Its package.
        name: Its file name.
        path: Its path.
    """

    def __init__(self, package, name, fixed=(), options=True):
        """Names a launch file; nothing is read yet.

        Args:
            package: Its package, a folder in src/.
            name: Its file name.
            fixed: Arguments that the command sets and its user cannot.
            options: Whether options of roslaunch, such as --screen, are handed on.
        """
        self.package, self.name = package, name
        self.path = os.path.join(SOURCES, package, "launch", name)
        self._fixed, self._options = fixed, options

    def arguments(self):
        """Reads the arguments that can be set.

        Returns:
            Dict from name to (default, description); default is None where one has to be given.

        Raises:
            CommandError: The file is not XML.
        """
        from xml.etree import ElementTree

        builder = ElementTree.TreeBuilder(insert_comments=True)
        try:
            root = ElementTree.parse(self.path, ElementTree.XMLParser(target=builder)).getroot()
        except ElementTree.ParseError as error:
            raise CommandError(f"{relative(self.path)} is not XML: {error}") from None
        found = {}
        self._collect(root, found, ElementTree.Comment)
        return {name: about for name, about in found.items() if name not in self._fixed}

    def check(self, arguments):
        """Checks NAME:=VALUE arguments.

        Args:
            arguments: As they were given to the command.

        Returns:
            What to hand to roslaunch; tracks are resolved.

        Raises:
            UsageError: There is no such argument or track, or it is no launch argument at all.
        """
        checked, known, after_option = [], None, False
        for argument in arguments:
            name, assigned, value = argument.partition(":=")
            if assigned:
                known = self.arguments() if known is None else known
                if name not in known:
                    raise UsageError(
                        f"{self.name} has no argument {name!r}; there are {', '.join(known)}"
                    )
                argument = f"track:={resolve_track(value)}" if name == "track" else argument
            elif not self._options or not (argument.startswith("-") or after_option):
                raise UsageError(
                    f"unknown argument {argument!r}; launch arguments have the form NAME:=VALUE"
                )
            after_option = argument.startswith("-")
            checked.append(argument)
        return checked

    def command(self, arguments, *options):
        """Returns the command line that starts it."""
        return [PYTHON, ROSLAUNCH, *options, self.package, self.name, *arguments]

    def help(self):
        """Returns a text that lists the arguments, their defaults and descriptions."""
        lines = [f"launch arguments ({self.package}/launch/{self.name}):"]
        for name, (default, description) in self.arguments().items():
            if default is None or "$(eval" in default:  # nothing, or a formula of other arguments
                default = "..."
            lines.append(f"  {f'{name}:={default}':32} {description}".rstrip())
        return "\n".join(lines)

    def _collect(self, element, found, comment):
        """Gathers <arg> tags outside of includes; a comment on the same line describes one."""
        before = None
        for child in element:
            if child.tag is comment:
                if before is not None and not found[before][1]:
                    found[before] = (found[before][0], " ".join(child.text.split()))
                before = None
            elif child.tag == "arg" and "value" not in child.attrib:
                name = child.get("name", "")
                found[name] = (child.get("default"), child.get("doc", ""))
                before = None if "\n" in (child.tail or "") else name
            else:
                before = None
                if child.tag != "include":
                    self._collect(child, found, comment)
