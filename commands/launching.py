"""Launch files: arguments, tracks and policies by name; starts with a display and without."""

import glob
import json
import os
import re
import shutil
import socket
import subprocess
import time

from commands import locks, processes, supervisor
from commands.bootstrap import ros
from commands.errors import CommandError, UsageError, say
from commands.paths import OUT, SOURCES, STATE, read, relative

TRACK_FOLDER = os.path.join(SOURCES, "track_model", "tracks")
TRACK_SUFFIXES = (".yaml", ".yml", ".npy", ".csv")
TRAININGS = os.path.join(OUT, "train")
POLICY_FILE = "policy.onnx"
ROSLAUNCH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "roslaunch")
UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}  # [s]
PADS = "/dev/input/js*"
MASTER_TIMEOUT = 5.0  # for a master's response [s]
PAGE_START = 15.0  # until a page is there at the latest [s]
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
BOOLEANS = ("true", "false", "1", "0")  # as roslaunch reads if and unless, in any case


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


resolve_track.complete = track_names


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
    names = ", ".join(policy_names()) or "none yet: ./run train makes one"
    raise UsageError(f"policy is {value!r}; there are {names}; or the path of an .onnx file")


resolve_policy.complete = policy_names


def policy_settings(path):
    """Returns the settings of the training that made a policy; empty where there are none.

    Raises:
        CommandError: Their file is damaged.
    """
    path = os.path.join(os.path.dirname(path), "settings.json")
    try:
        settings = json.loads(read(path) or "{}")
    except ValueError as error:
        raise CommandError(f"{path} is no JSON: {error}") from None
    if not isinstance(settings, dict):
        raise CommandError(f"{path} holds no settings")
    return settings


class LaunchFile:
    """A launch file of this workspace."""

    def __init__(self, package, name, fixed=(), options=True):
        """Names a launch file; nothing is read yet.

        Args:
            package: Its package, a folder in src/.
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
        arguments = {}
        self._collect(root, arguments, ElementTree.Comment)
        return {name: about for name, about in arguments.items() if name not in self._fixed}

    def check(self, arguments):
        """Checks NAME:=VALUE arguments.

        Returns:
            What to hand to roslaunch; tracks are resolved.

        Raises:
            UsageError: There is no such argument or track, a value is no number or boolean where
                the default is one, or it is no launch argument at all.
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
                if name == "track":
                    argument = f"track:={resolve_track(value)}"
                elif "$(" not in value:  # roslaunch puts in what that means
                    _check_value(name, value, *known[name])
            elif not self._options or not (argument.startswith("-") or after_option):
                raise UsageError(
                    f"unknown argument {argument!r}; launch arguments have the form NAME:=VALUE"
                )
            after_option = argument.startswith("-")
            checked.append(argument)
        return checked

    def command(self, arguments, *options):
        """Returns the command line that starts it."""
        return [ros.python(), ROSLAUNCH, *options, self.package, self.name, *arguments]

    def help(self):
        """Returns a text that lists the arguments, their defaults and descriptions."""
        lines = [f"launch arguments ({self.package}/launch/{self.name}):"]
        for name, (default, description) in self.arguments().items():
            if default is None or "$(eval" in default:  # nothing, or a formula of other arguments
                default = "..."
            lines.append(f"  {f'{name}:={default}':32} {description}".rstrip())
        return "\n".join(lines)

    def _collect(self, element, arguments, comment):
        """Gathers <arg> tags outside of includes; a comment on the same line describes one."""
        before = None
        for child in element:
            if child.tag is comment:
                if before is not None and not arguments[before][1]:
                    arguments[before] = (arguments[before][0], " ".join(child.text.split()))
                before = None
            elif child.tag == "arg" and "value" not in child.attrib:
                name = child.get("name", "")
                arguments[name] = (child.get("default"), child.get("doc", ""))
                before = None if "\n" in (child.tail or "") else name
            else:
                before = None
                if child.tag != "include":
                    self._collect(child, arguments, comment)


def _check_value(name, value, default, description):
    """Checks a launch argument's value by the type of its default.

    Raises:
        UsageError: The default is a number or a boolean, and the value is not.
    """
    if _number(default) is not None:
        number, is_pace = _number(value), name == "real_time_factor"
        if number is None or is_pace and number < 0.0:
            valid = "a number of at least 0" if is_pace else "a number"
            raise UsageError(f"{name} is {value!r}; it must be {valid}")
    elif default in BOOLEANS[:2] and "auto" not in description and value.lower() not in BOOLEANS:
        raise UsageError(f"{name} is {value!r}; it must be true or false")


def _number(text):
    """Reads a finite number; returns None where a text, or None, is none."""
    return float(text) if text and NUMBER.fullmatch(text) else None


def run(name, launch, environ, arguments, deadline, out, results):
    """Runs a launch that leaves result.json, and tells how it went.

    Args:
        name: The command, for messages and the folder of its logs.
        launch: LaunchFile with an argument out_dir.
        environ: The activated environment; changed in place.
        arguments: NAME:=VALUE arguments, without out_dir, checked.
        deadline: Longest run [s] as text, of deadline_from().
        out: The folder for the results.
        results: Names of what an earlier run has left there, which is removed; None: all.

    Raises:
        CommandError: The track is not valid (nothing is removed then), or the launch failed, came
            to no result, or to one that is not ok; or another ./run writes there.
        Interrupted: A signal ended it.
    """
    for argument in arguments:
        argument_name, _, value = argument.partition(":=")
        if argument_name == "track" and os.path.isabs(value):  # a file, no shipped track
            _build_track(value, environ)
    locks.take_results(out)
    os.makedirs(out, exist_ok=True)
    for result in os.listdir(out) if results is None else results:
        path = os.path.join(out, result)
        if os.path.isdir(path) and not os.path.islink(path):
            shutil.rmtree(path)
        elif os.path.lexists(path):
            os.remove(path)
    environ["ROS_LOG_DIR"] = os.path.join(STATE, f"ros-{name}")
    environ["QT_QPA_PLATFORM"] = environ.get("QT_QPA_PLATFORM") or "offscreen"
    shutil.rmtree(environ["ROS_LOG_DIR"], ignore_errors=True)
    try:
        status = start(launch, environ, [f"out_dir:={out}", *arguments], deadline)
    except processes.DeadlineExceeded:
        _list(out)
        raise CommandError(
            f"the {name} did not end within {deadline} s", where_to_look(environ)
        ) from None
    _list(out)
    if status != 0:
        raise CommandError(f"roslaunch ended with exit status {status}", where_to_look(environ))
    ok = is_ok(os.path.join(out, "result.json"))
    if not ok:
        problem = "ended without result.json" if ok is None else "did not succeed"
        raise CommandError(f"the {name} {problem}", where_to_look(environ))
    say(f"{name}: ok")


def _build_track(track, environ):
    """Builds a track from its file into the cache, where the launch will find it.

    Args:
        track: The file's path.
        environ: The activated environment.

    Raises:
        CommandError: The file holds no valid track.
    """
    script = os.path.join(SOURCES, "track_model", "scripts", "make_track")
    done = subprocess.run(
        [ros.python(), script, track], env=environ, capture_output=True, text=True, errors="replace"
    )
    if done.returncode:
        *_, sentence = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
        raise CommandError(re.sub("^make_track: ", "", sentence))


def start(launch, environ, arguments, deadline):
    """Runs roslaunch to its end, on a master of its own.

    Args:
        environ: The activated environment; gets the master.
        deadline: Longest run [s] as text, of deadline_from().

    Returns:
        roslaunch's exit status.

    Raises:
        processes.DeadlineExceeded: It did not end in time.
        Interrupted: A signal ended it.
    """
    options = use_own_master(environ)
    supervisor.start(environ)
    return processes.run_child(
        launch.command(arguments, *options),
        group=False,
        deadline=_seconds(deadline) or None,
        env=environ,
        stdin=subprocess.DEVNULL,
        pass_fds=locks.held(),
    )


def use_own_master(environ):
    """Makes an environment use a master on a free port of this machine, loopback only.

    Args:
        environ: Changed in place.

    Returns:
        The options with which roslaunch starts that master.

    Raises:
        CommandError: This machine has no 127.0.0.1, as one that has IPv6 alone.
    """
    with socket.socket() as probe:
        try:
            probe.bind(("127.0.0.1", 0))
        except OSError as error:
            raise CommandError(
                f"this machine has no address 127.0.0.1, which this command needs ({error})",
                "Give it one: ip address add 127.0.0.1/8 dev lo",
            ) from None
        port = probe.getsockname()[1]
    environ.pop("ROS_HOSTNAME", None)
    environ.update(ROS_IP="127.0.0.1", ROS_MASTER_URI=f"http://127.0.0.1:{port}")
    return "-p", str(port)


def is_ok(path):
    """Reads a result file's "ok".

    Returns:
        True or False; None where there is no result.
    """
    try:
        with open(path, encoding="utf-8") as stream:
            return json.load(stream)["ok"] is True
    except (OSError, ValueError):
        return None
    except (KeyError, TypeError):
        return False


def where_to_look(environ):
    """Returns the advice for a launch that went wrong."""
    return f"Its own words are above; logs in {relative(environ['ROS_LOG_DIR'])}/"


def deadline_from(variable, default):
    """Returns a deadline [s] as text, which a variable of the environment may change.

    Raises:
        UsageError: The variable's value is no time.
    """
    text = os.environ.get(variable) or str(default)
    try:
        valid = _seconds(text) >= 0
    except ValueError:
        valid = False
    if not valid:
        raise UsageError(f"{variable} is {text!r}; it must be a number of seconds, 0 for no limit")
    return text


def _seconds(text):
    """Reads a time as timeout(1) does: a number, with s, m, h or d behind it or not."""
    unit = UNITS.get(text[-1:])
    return float(text[:-1]) * unit if unit else float(text)


def _list(out):
    files = sorted(entry.name for entry in os.scandir(out) if entry.is_file())
    say(f"in {relative(out)}/: {' '.join(files)}")


def become(launch, arguments, environ):
    """Becomes roslaunch, with a supervisor over what it leaves; does not come back.

    Args:
        arguments: NAME:=VALUE arguments and options of roslaunch, checked.
    """
    supervisor.start(environ)
    processes.become(launch.command(arguments), environ)


def has_display(environ):
    """Returns whether there is a screen to open a window on."""
    return bool(environ.get("DISPLAY") or environ.get("WAYLAND_DISPLAY"))


def need_display(instead):
    """Refuses to open a window where the caller has no screen.

    Args:
        instead: A command that needs none.

    Raises:
        CommandError: There is no screen.
    """
    if not has_display(os.environ) and not os.environ.get("QT_QPA_PLATFORM"):  # who sets it knows
        raise CommandError(
            "the window needs a display, and neither DISPLAY nor WAYLAND_DISPLAY is set",
            f"Without one: {instead}",
        )


def window_arguments(arguments, pads=PADS):
    """Returns launch arguments that the caller has not given.

    Args:
        arguments: NAME:=VALUE as they were given.
        pads: Pattern of the device files of game pads.

    Returns:
        List: recordings go to out/recordings/, the driver of a pad that is plugged in is started.
    """
    wanted = {"record_dir": os.path.join(OUT, "recordings")}
    if glob.glob(pads):
        wanted["pad"] = "true"
    given = {argument.partition(":=")[0] for argument in arguments}
    return [f"{name}:={value}" for name, value in wanted.items() if name not in given]


def simulator_runs(environ):
    """Returns whether the environment's master knows a node /gazebo."""
    return _address_of("/gazebo", environ["ROS_MASTER_URI"]) is not None


def page_runs(environ):
    """Returns whether the environment's master knows a node /web, and it is still there."""
    address = _address_of("/web", environ["ROS_MASTER_URI"])
    return address is not None and _accepts(address)


def refuse_second_world(environ):
    """Refuses where a simulator runs or starts: a second node /gazebo would end the first.

    Raises:
        CommandError: The environment's master knows a node /gazebo, or another ./run brings one.
    """
    runs = simulator_runs(environ)
    if runs or not locks.take(_on_master("world", environ)):
        what = "a simulator runs already on" if runs else "a simulator is being started on"
        raise CommandError(
            f"{what} {environ['ROS_MASTER_URI']}",
            "Stop it, or give this one its own master:",
            "ROS_MASTER_URI=http://localhost:11312 ./run ...",
        )


def page_comes(environ):
    """Returns whether another ./run brings a page to the environment's master."""
    if locks.take(_on_master("web", environ)):
        return False
    end = time.monotonic() + PAGE_START
    while not page_runs(environ):
        if time.monotonic() > end:
            return False  # it has been ended: rosnode kill /web
        time.sleep(0.2)
    return True


def _on_master(what, environ):
    """Returns the name in locks of what there is one of on a master."""
    host, _, port = environ["ROS_MASTER_URI"].partition("://")[2].rstrip("/").rpartition(":")
    here = host in ("localhost", "127.0.0.1", "[::1]", socket.gethostname())
    return f"{what} {'localhost' if here else host}:{port}"


def _accepts(uri):
    """Returns whether something listens at a URI's host and port."""
    host, _, port = uri.partition("://")[2].split("/")[0].rpartition(":")
    try:
        socket.create_connection((host.strip("[]"), int(port)), MASTER_TIMEOUT).close()
    except (OSError, ValueError):
        return False
    return True


def _address_of(node, uri):
    """Looks a node up.

    Returns:
        Its URI; None: the master at a URI does not know it, or does not answer.
    """
    from http.client import HTTPException
    from xml.parsers.expat import ExpatError
    from xmlrpc.client import Error, ServerProxy

    if not _accepts(uri):
        return None  # no master yet; roslaunch starts one, or says what is wrong with the address
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(MASTER_TIMEOUT)
    try:
        with ServerProxy(uri) as master:
            code, _, address = master.lookupNode("/paddock", node)
            return address if code == 1 else None
    except (OSError, HTTPException, Error, ExpatError):
        return None  # something else listens there
    finally:
        socket.setdefaulttimeout(before)
