"""For the tests of the ROS below: folders like a ROS 1, and a machine of a few programs."""

import os
import shutil
import sys

import run_rig

# Programs that ./run needs before there is python3, besides what a test puts in their place.
PROGRAMS = (
    "awk bash cat cut env find flock grep head id mkdir paste rm sed sleep sort tail touch tr "
    "uname wc"
).split()
DPKG_QUERY = """case $1 in
  -W) shift 2
    for name; do
      case " $INSTALLED " in *" $name "*) echo "ii  $name"; continue ;; esac
      if [ -e "$STATE" ]; then case " $(cat "$STATE") " in *" $name "*) echo "ii  $name" ;; esac; fi
    done ;;
esac"""
APT_GET = """echo "$*" >>"$CALLS"
case " $* " in *" install "*) printf '%s ' "$*" >>"$STATE" ;; esac"""
# More than a pipe holds: who stops reading at the candidate breaks it.
APT_CACHE = """echo "$2:"
case " $KNOWN $INSTALLED " in
  *" $2 "*) echo "  Candidate: 1.0" ;;
  *) echo "  Candidate: (none)" ;;
esac
printf '%200000s\\n' 'Version table:'"""


def make_ros(folder, names, python=None):
    """Makes a folder that looks like a ROS 1.

    Args:
        names: Its packages.
        python: Text of its own bin/python3, a shell script; None for none.
    """
    (folder / "share").mkdir(parents=True, exist_ok=True)
    for name in names:
        run_rig.make_package(folder / "share" / name, name)
    (folder / "setup.bash").write_text(
        f"export ROS_DISTRO=probe ROS_VERSION=1 CMAKE_PREFIX_PATH={folder} ROS_PROBE=here\n"
        f"export PATH={folder}/bin:$PATH ROS_PACKAGE_PATH={folder}/share:/usr/share\n"
    )
    if python is not None:
        (folder / "bin").mkdir()
        run_rig.program(folder / "bin" / "python3", f"#!/bin/sh\n{python}\n")
    return folder


def sourced(folder, environ=None):
    """Returns an environment in which a ROS is sourced."""
    environ = dict(os.environ if environ is None else environ)
    for name in ("ROS_VERSION", "ROS_DISTRO"):
        environ.pop(name, None)
    return {**environ, "ROS_DISTRO": "probe", "CMAKE_PREFIX_PATH": f"/nowhere:{folder}/:/usr"}


class System:
    """A small clone on a machine without python3, whose programs are named here.

    Attributes:
        root: The clone.
        calls: File with the arguments of each call of apt-get.
    """

    def __init__(self, folder, os_release, apt=True):
        """Makes it.

        Args:
            os_release: Text of /etc/os-release; None for none.
            apt: Whether it has dpkg-query and apt-get; KNOWN and INSTALLED in the environment of
                run() name what apt could install and what is installed.
        """
        self.root = run_rig.small_clone(folder / "paddock")
        self.calls, self._programs = folder / "calls", folder / "programs"
        self._programs.mkdir()
        for name in PROGRAMS:
            (self._programs / name).symlink_to(shutil.which(name))
        if apt:
            for name, text in (
                ("dpkg-query", DPKG_QUERY), ("apt-get", APT_GET), ("apt-cache", APT_CACHE),
                ("dpkg", ""), ("sudo", 'case $1 in -*) exit ;; esac; exec "$@"'),
            ):  # fmt: skip
                run_rig.program(self._programs / name, f"#!/bin/sh\n{text}\n")
        if os_release is not None:
            (folder / "os-release").write_text(os_release)
        script = self.root / "run"
        text = script.read_text()
        for name, before, after in (
            ("python", "/usr/bin/python3", "/nonexistent/python3"),
            ("os_release", "/etc/os-release", str(folder / "os-release")),
            ("system_path", text.partition("\nsystem_path=")[2].partition("\n")[0],
             str(self._programs)),
        ):  # fmt: skip
            assert text.count(f"\n{name}={before}\n") == 1
            text = text.replace(f"\n{name}={before}\n", f"\n{name}={after}\n")
        script.write_text(text)
        paths = self.root / "commands" / "paths.py"
        paths.write_text(paths.read_text().replace('"/etc/os-release"', f'"{folder}/os-release"'))
        self._environ = {
            "PATH": str(self._programs), "HOME": str(folder), "CALLS": str(self.calls),
            "STATE": str(folder / "installed"),
        }  # fmt: skip

    def use_python(self):
        """Has python3 from now on, as after the first installation; returns itself."""
        script = self.root / "run"
        script.write_text(script.read_text().replace("/nonexistent/python3", sys.executable))
        return self

    def run(self, *arguments, **environ):
        """Runs ./run there to its end, which comes where python3 is to be started."""
        words = [shutil.which("bash"), self.root / "run", *arguments]
        return run_rig.ran(*words, env={**self._environ, **environ})

    def installed(self):
        """Returns the names that apt-get was asked to install; None if it was not asked."""
        if not self.calls.exists():
            return None
        (line,) = (line for line in self.calls.read_text().splitlines() if " install " in line)
        return line.partition("--no-install-recommends ")[2].split()
