"""Debian's packages for the names of package.xml files."""

import subprocess

# rosdep's names that follow no rule below; {} is empty where Python itself has it.
NAMES = {
    "boost": ("libboost-all-dev",),
    "curl": ("libcurl4-openssl-dev",),
    "eigen": ("libeigen3-dev",),
    "ffmpeg": ("ffmpeg",),
    "libopencv-dev": ("libopencv-dev",),
    "libpcl-all-dev": ("libpcl-dev",),
    "opencv": ("libopencv-dev",),
    "opencv3": ("libopencv-dev",),
    "python": ("python3",),
    "python-opencv": ("python3-opencv",),
    "python-qt-bindings": ("python3-pyqt5",),
    "python3-pillow": ("python3-pil",),
    "python3-qt5-bindings": ("python3-pyqt5",),
    "sdl": ("libsdl1.2-dev",),
    "tinyxml": ("libtinyxml-dev",),
    "tinyxml2": ("libtinyxml2-dev",),
    "yaml-cpp": ("libyaml-cpp-dev",),
}


def candidates(name, built=True):
    """Lists the names that Debian may give the packages of a dependency.

    A ROS package is split there: headers and package.xml are in lib*-dev, Python modules in
    python3-*, definitions of messages in ros-*, nodes and tools under the name itself.

    Args:
        name: In a package.xml.
        built: Whether something is built against it, and not only run.
    """
    if name in NAMES:
        return list(NAMES[name])
    dashed = name.replace("_", "-").lower()
    if dashed.startswith("python-"):  # rosdep's names of the time of Python 2
        return [f"python3-{dashed.removeprefix('python-')}"]
    if dashed.startswith(("python3-", "lib")):
        return [dashed]
    to_build = [f"lib{dashed}-dev", f"libros-{dashed}-dev"] if built else []
    return [*to_build, f"python3-{dashed}", f"ros-{dashed}", dashed]


def existing(names):
    """Says which packages apt could install.

    Args:
        names: Of Debian packages.

    Returns:
        Set of those that exist; installed ones do in any case.
    """
    names = sorted(set(names))
    if not names:
        return set()
    words = ["apt-cache", "--quiet=0", "policy", *names]
    environ = {"PATH": "/usr/bin:/bin", "LC_ALL": "C"}
    done = subprocess.run(words, capture_output=True, text=True, check=True, env=environ)
    found, name = set(), ""
    for line in done.stdout.splitlines():
        if not line.startswith(" "):
            name = line.removesuffix(":")
        elif line.strip().startswith("Candidate:") and not line.endswith("(none)"):
            found.add(name)
    return found


def installed(names):
    """Says which packages are installed."""
    words = ["dpkg-query", "-W", "-f", "${db:Status-Abbrev}${Package}\n", *sorted(set(names))]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    return {line[3:] for line in done.stdout.splitlines() if line.startswith("ii ")}


def has_lists():
    """Says whether apt knows more than what is installed."""
    done = subprocess.run(["apt-cache", "policy"], capture_output=True, text=True, check=True)
    return any("http" in line or "file:" in line for line in done.stdout.splitlines())
