"""Launch files and the arguments that a command hands to them, checked before anything starts."""

import os

from commands.errors import CommandError, UsageError
from commands.launching import tracks
from commands.paths import PYTHON, SOURCES, relative

ROSLAUNCH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "roslaunch")


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
                argument = f"track:={tracks.resolve(value)}" if name == "track" else argument
            elif not self._options or not (argument.startswith("-") or after_option):
                raise UsageError(
                    f"unknown argument {argument!r}; launch arguments have the form NAME:=VALUE"
                )
            after_option = argument.startswith("-")
            checked.append(argument)
        return checked

    def command(self, arguments, *options):
        """Gives the command line that starts it."""
        return [PYTHON, ROSLAUNCH, *options, self.package, self.name, *arguments]

    def help(self):
        """Gives a text that lists the arguments, their defaults and descriptions."""
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
