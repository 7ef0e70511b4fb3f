"""Gazebo's libraries for ./run add gazebo: those of Debian 11, unpacked below .cache/gazebo.

Debian 12 has no Gazebo Classic; the libraries of Debian 11 run on it beside its own. They are
unpacked and not installed: nothing but plugins in C++ and the host that loads them sees them.
"""

import glob
import os

from commands.bootstrap import packages, step
from commands.errors import CommandError, say
from commands.paths import GAZEBO as PREFIX
from commands.paths import GAZEBO_STAMP as STAMP
from commands.paths import ROOT, os_release, read, relative, write

LIST = "apt-gazebo.txt"  # of Debian 12, in config/
OLD_LIST = os.path.join(ROOT, "config", "apt-gazebo-11.txt")
MIRRORS = ("http://deb.debian.org/debian", "http://archive.debian.org/debian")
KEYS = "/usr/share/keyrings/debian-archive-keyring.gpg"
SIZES = "86 MB to download, 343 MB in .cache/gazebo, and what is missing of Debian 12's packages"


def add(folder=None):
    """Brings the libraries, if they are not there.

    Args:
        folder: Where the packages' files (*.deb) are; None: from Debian's mirrors.

    Raises:
        CommandError: This system has others, or they cannot be had.
    """
    check_system()
    wanted = names()
    if read(STAMP).split() == wanted:
        return say(f"{relative(PREFIX)} is there already, and stays as it is")
    say(f"Gazebo 11 as Debian 11 has it: {SIZES}")
    packages.prepare(LIST)
    import shutil

    part, files = f"{PREFIX}.part", f"{PREFIX}.files"
    for path in (part, files):
        shutil.rmtree(path, ignore_errors=True)  # of a ./run that was killed
    os.makedirs(files)
    try:
        for path in _local(wanted, folder) if folder else _download(wanted, files):
            _run(["dpkg-deb", "--extract", path, part], f"{path} cannot be unpacked")
        write(os.path.join(part, os.path.basename(STAMP)), "".join(f"{n}\n" for n in wanted))
        shutil.rmtree(PREFIX, ignore_errors=True)
        os.rename(part, PREFIX)
    finally:
        for path in (part, files):
            shutil.rmtree(path, ignore_errors=True)
    return say(f"{relative(PREFIX)} is there, the workspace is built with it")


def names():
    """Lists the packages of OLD_LIST."""
    return [line for line in read(OLD_LIST).split("\n") if line and not line.startswith("#")]


def check_system(text=None):
    """Raises CommandError where others than Debian 11's libraries are to be used.

    Args:
        text: Of os-release; None: this system's.
    """
    fields = os_release(text)
    system = " ".join(fields.get(name, "") for name in ("ID", "VERSION_ID")).strip()
    if system == "debian 12":
        return
    advice = {
        "ubuntu 20.04": "sudo apt-get install libgazebo11-dev, then ./run setup",
        "ubuntu 22.04": "sudo apt-get install libgazebo-dev, then ./run setup",
        "debian 11": "sudo apt-get install libgazebo-dev, then ./run setup",
    }
    raise CommandError(
        f"Gazebo's libraries for plugins in C++ are brought on Debian 12 alone, this is {system}",
        advice.get(system, "Where Gazebo 11's development files are installed they are used"),
    )


def _local(wanted, folder):
    """Lists the files of packages in a folder."""
    result = []
    for name in wanted:
        found = sorted(
            glob.glob(os.path.join(glob.escape(os.path.realpath(folder)), f"{name}_*.deb"))
        )
        if not found:
            raise CommandError(f"{folder} has no {name}_*.deb, a package of Debian 11")
        result.append(found[-1])
    return result


def _download(wanted, folder):
    """Lets apt download packages into a folder, with lists of its own; lists their files."""
    errors = []
    for mirror in MIRRORS:
        try:
            options = _apt_options(mirror, folder)
            _run(["apt-get", *options, "update"], f"{mirror} has no lists of Debian 11")
            _run(["apt-get", *options, "download", *wanted], f"{mirror} has not all", folder)
        except CommandError as error:
            errors.append(str(error))
        else:
            return sorted(glob.glob(os.path.join(folder, "*.deb")))
    raise CommandError("Debian 11's packages cannot be had", *errors)


def _apt_options(mirror, folder):
    """Writes what apt needs below a folder; returns its options."""
    source = f"deb [signed-by={KEYS}] {mirror} bullseye main\n"
    write(os.path.join(folder, "sources.list"), source)
    write(os.path.join(folder, "status"), "")  # so that versions of this system do not count
    for below in ("lists/partial", "cache/archives/partial"):
        os.makedirs(os.path.join(folder, below), exist_ok=True)
    return [
        f"-o{name}={value}"
        for name, value in {
            "Dir::Etc::sourcelist": os.path.join(folder, "sources.list"),
            "Dir::Etc::sourceparts": "-",
            "Dir::State::status": os.path.join(folder, "status"),
            "Dir::State::lists": os.path.join(folder, "lists"),
            "Dir::Cache": os.path.join(folder, "cache"),
            "APT::Sandbox::User": "root",
            "Debug::NoLocking": "true",
            "Acquire::Retries": "3",
            "Acquire::Check-Valid-Until": "false",  # no release comes any more
        }.items()
    ]


def _run(command, problem, folder=None):
    """Runs a program; raises CommandError with its last lines where it fails."""
    status, lines = step.run_quietly(command, cwd=folder)
    if status != 0:
        errors = [line for line in lines if line.startswith(("E:", "dpkg"))]
        raise CommandError(f"{problem}: {'; '.join(errors[-2:]) or f'status {status}'}")
