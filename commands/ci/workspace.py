"""A workspace of its own for the packages under test, on top of this one."""

import hashlib
import os
import shutil

from commands.dependencies import answer, manifests
from commands.errors import CommandError, say
from commands.paths import CACHE, SYSTEM_PATH, VENV_PYTHON


class Workspace:
    """The packages at and below a folder, in .cache/ci.

    Attributes:
        packages: Dict from name to folder.
        setup: Path of its setup.bash, once it is built.
    """

    def __init__(self, folder):
        """Links the packages into it.

        Args:
            folder: With one or more package.xml.

        Raises:
            UsageError: It has none.
        """
        files = manifests.find(os.path.realpath(folder))
        self.packages = {manifests.read(path)[0]: os.path.dirname(path) for path in files}
        name = hashlib.sha256(os.path.realpath(folder).encode()).hexdigest()[:12]
        self._root = os.path.join(CACHE, "ci", name)
        self.setup = os.path.join(self._root, "devel", "setup.bash")
        sources = os.path.join(self._root, "src")
        shutil.rmtree(sources, ignore_errors=True)  # links only
        os.makedirs(sources)
        for package, place in self.packages.items():
            os.symlink(place, os.path.join(sources, package))

    def build(self, run, environ):
        """Builds it.

        Args:
            run: As tests.run_logged.
            environ: The activated environment.

        Raises:
            CommandError: It does not build.
        """
        command = ["catkin_make", "-C", self._root, f"-DPYTHON_EXECUTABLE={VENV_PYTHON}"]
        if run("build", command, environ) != 0:
            raise CommandError("the packages do not build", "What the compiler said is above.")

    def command(self, words):
        """Gives the command line that runs something with the workspace active."""
        return ["bash", "-c", '. "$0" && exec "$@"', self.setup, *words]


def install_dependencies(folder, environ):
    """Installs the Debian packages that package.xml files ask for; says what there is none of.

    Args:
        folder: With the packages.
        environ: Of apt-get.

    Raises:
        CommandError: apt-get failed.
    """
    found = answer.find(folder)
    for name, askers in found.nowhere.items():
        say(f"neither Debian nor Paddock has {name}, which {', '.join(askers)} asks for")
    names = answer.to_install(found)
    if not names:
        return
    say(f"Debian packages: {' '.join(names)}")
    from commands import processes

    as_root = [] if os.geteuid() == 0 else ["sudo"]
    variables = ["env", "DEBIAN_FRONTEND=noninteractive", f"PATH={SYSTEM_PATH}"]
    install = ["apt-get", "install", "-qq", "-y", "--no-install-recommends", *names]
    if processes.run_child([*as_root, *variables, *install], env=environ, session=False) != 0:
        raise CommandError("apt-get could not install them", f"As root: {' '.join(install)}")
