"""Brings ROS packages from their sources into src/, installs what they need of Debian, builds them.

NAME is a repository or a package of Noetic's index, or of --list: what the index lacks or has
wrong. Or it is the URL of a git repository, with #BRANCH at its end if it is not to be the default
branch. For example:
  ./run add navigation gmapping
  ./run add --for PATH                        # all that packages, or a launch file, lack
  ./run add https://github.com/somebody/their_robot.git#noetic-devel
  ./run add models PACKAGE|FILE|MODEL ...     # of Gazebo's database: those that they name
  ./run add gazebo                            # Gazebo's libraries, for plugins in C++
What the packages depend on, and neither Debian nor Paddock nor src/ has, comes, too. Of a package's
repository the packages that it does not need are disabled, by CATKIN_IGNORE. Packages in src/ take
the place of stand-ins of the same name. What cannot be built is left out and named. A repository
that is in src/ already stays as it is. Submodules come, too. Of a package that is in two
repositories the one of the index is used, else the one that came last.
"""

import os
import subprocess

from commands import bootstrap, gazebo_libraries, gazebo_models, sources
from commands.bootstrap import left_out, step, workspace
from commands.errors import CommandError, UsageError, say
from commands.paths import CACHE, PYTHON, ROOT, read, relative, write
from commands.repositories import bring, local
from commands.sources import Repository
from commands.subcommands import deps, setup

USAGE = "[--from FOLDER] NAME|URL ... | --for PATH|PACKAGE [FILE.launch] | --list | --refresh"
LOCK = "add.lock"
INDEX_READER = os.path.join(ROOT, "commands", "noetic_index.py")
SECONDS = 4.0  # of a processor for a C++ file: 2.6 of navigation, 4.8 of laser_filters
CPP, HEADERS = (".c", ".cc", ".cpp", ".cxx"), (".h", ".hh", ".hpp")


def add_arguments(parser):
    """Declares names, --from and --list."""
    named = parser.add_argument("names", nargs="*", metavar="NAME", help="see above, or a URL")
    named.complete = lambda: [*sources.names(), "gazebo"]
    text = "bring what the packages at and below a path, of a name or of a launch file lack"
    parser.add_argument("--for", dest="users", nargs="+", metavar="PATH", help=text)
    text = "take clones (NAME, NAME.git) or archives (NAME.tar.gz, NAME.zip ...) from there instead"
    parser.add_argument("--from", dest="folder", metavar="FOLDER", help=text)
    parser.add_argument("--list", action="store_true", help="tell what there is beside the index")
    parser.add_argument("--refresh", action="store_true", help="read what is in the index again")


def run(options, _rest):
    """Brings, builds and says what there is now."""
    if options.list:
        return print_list()
    if options.refresh:
        return refresh(options.folder)
    if not options.names and not options.users:
        raise UsageError("add needs a name", f"usage: ./run add {USAGE}")
    bootstrap.need_own()
    with step.SetupLock(os.path.join(CACHE, LOCK), "bringing packages"):
        return add(options.names, options.folder, options.users or ())


def add(names, folder, users=()):
    """Brings and builds; one ./run at a time.

    Args:
        names: As given.
        folder: Where clones and archives are; None: from the network.
        users: Paths, packages and launch files that lack something.
    """
    if names[:1] == ["models"]:
        deps.prepare()
        return gazebo_models.add(names[1:], _clone_of_models(folder))
    others = [name for name in names if name != "gazebo"]
    typed = [found for name in others for found in sources.repositories_of(name)]
    before = set(workspace.users_packages())
    deps.prepare()
    if "gazebo" in names:
        gazebo_libraries.add(folder)
    lacking = _lacking(users, folder) if users else {}
    nowhere = bring_all(typed, lacking, folder)
    users = workspace.users_packages()
    new = [name for name in users if name not in before]
    for name, askers in sorted(nowhere.items()):
        said = f", for {', '.join(askers)}" if askers else ""
        say(f"{name}{said}: cannot be had")
    for line in sizes(users, new):
        say(line)
    deps.offer(list(users.values()), setup.asked)
    bootstrap.prepare()
    entries = left_out.saved()
    for line in left_out.lines(entries):
        say(line)
    gone = {entry.package for entry in entries if not entry.program}
    new = sorted(set(new) - gone)
    say(f"here now: {', '.join(new) or 'nothing new'}")
    if new and deps.has_lists():
        for line in deps.launched(deps.find([users[name] for name in new])):
            say(line)
    return 0


def _clone_of_models(folder):
    return folder and local(gazebo_models.REPOSITORY, folder).url


def _lacking(words, folder):
    """Brings models that packages name; returns the packages that they lack: see bring_all()."""
    folders = deps.folders_of(words)
    answer = deps.find(folders)
    if gazebo_models.named_in(folders):
        gazebo_models.add(folders, _clone_of_models(folder))
    launched = [name for name, packages in answer.launched.items() if not packages]
    return {**dict.fromkeys(launched, ()), **answer.nowhere}


def bring_all(typed, lacking, folder):
    """Brings repositories, then what their packages lack, round after round.

    Args:
        typed: Repositories that must be had.
        lacking: Dict from a package that is missing to those that ask for it.
        folder: Where clones and archives are; None: from the network.

    Returns:
        Dict from a package that cannot be had to those that ask for it.

    Raises:
        CommandError: One of the first cannot be had.
    """
    came = [name for repository in typed for name in bring(repository, folder)]
    known, nowhere = set(), {}
    while True:
        for name in sorted(lacking.keys() - known):
            try:
                repositories = sources.of_package(name)
                for repository in repositories:
                    came += bring(repository, folder)
            except CommandError as error:
                say("; ".join([f"left out: {error}", *error.advice]))
                repositories = []
            if not repositories:
                nowhere[name] = lacking[name]
        leave_copies(came)
        known |= lacking.keys()
        folders = [
            path for path in workspace.users_packages().values() if workspace.top(path) in came
        ]
        if not (folders and deps.has_lists()):
            return nowhere
        lacking = deps.find(folders, tests=False).nowhere
        if lacking.keys() <= known:
            return nowhere


def sizes(users, names):
    """Yields how much is to be compiled, a line a repository, and about how long it takes.

    Args:
        users: Dict from packages to their folders.
        names: Packages that are new.
    """
    repositories, total = {}, 0
    for name in sorted(names):
        repositories.setdefault(workspace.top(users[name]), []).append(name)
    for top, packages in repositories.items():
        walks = [walk for name in packages for walk in os.walk(users[name])]
        paths = [os.path.join(directory, name) for directory, _, inside in walks for name in inside]
        lines = sum(read(path).count("\n") for path in paths if path.endswith((*CPP, *HEADERS)))
        files = sum(path.endswith(CPP) for path in paths)
        total += files
        yield f"{top}: {', '.join(packages)}; {files} C++ files, {lines:,} lines with headers"
    if total:
        cores = len(os.sched_getaffinity(0))
        minutes = max(1, round(total * SECONDS / cores / 60))
        yield f"to compile: {total} files, about {minutes} min on {cores} cores"


def refresh(folder):
    """Writes what is in the project of Noetic's index and rosdep's names.

    Args:
        folder: Where a clone of ros/rosdistro is; None: from the network.

    Raises:
        CommandError: The index cannot be had.
    """
    deps.prepare()
    url = sources.INDEX_URL
    if folder:
        clone = local(Repository("rosdistro", "git", url), folder).url
        url = f"file://{clone}/index-v4.yaml"
    for path, what in ((sources.INDEX, "noetic"), (deps.ROSDEPS_LIST, "rosdep")):
        command = [PYTHON, "-I", INDEX_READER, url, what]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise CommandError(f"{url} cannot be read", *done.stderr.splitlines()[-1:])
        comments = [line for line in read(path).splitlines() if line.startswith("#")]
        write(path, "\n".join([*comments, done.stdout]))
        say(f"{relative(path)}: {len(done.stdout.splitlines())} lines")
    return 0


def print_list():
    """Prints what there is beside the index, and how much that has."""
    say(read(sources.MORE), end="")
    repositories, packages, _ = sources.index()
    say(f"Noetic's index and these: {len(repositories)} repositories, {len(packages)} packages")
    return 0


def leave_copies(names):
    """Disables all but one of the packages of a name, by CATKIN_IGNORE: catkin wants one.

    Args:
        names: Repositories that have just been brought.
    """
    known = sources.folders()

    def rank(path):
        repository = workspace.top(path)
        return repository in known, names.index(repository) if repository in names else -1

    for name, folders in sorted(workspace.copies().items()):
        used = max(folders, key=rank)
        for path in folders:
            if path != used:
                write(os.path.join(path, "CATKIN_IGNORE"), "")
                say(
                    f"{name}: {relative(used)} is used; {relative(path)} is disabled by its file "
                    "CATKIN_IGNORE"
                )
