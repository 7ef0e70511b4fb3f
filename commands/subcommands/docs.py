"""Builds the site of the documents and shows it on this machine.

The pages are those of docs/ and those beside the code, with a search and the Python API; mkdocs.yml
has the tree. A page that is missing, and a link or an anchor that leads nowhere, end the build. The
site is in out/site/; at the printed address its search works, too, without a network. The first
call installs mkdocs and its theme (config/requirements-docs.txt) into .cache/docs, not into .venv.
In another user's clone it shows the site that is there, and builds only where there is none.
"""

import os

from commands import locks, parsing, processes
from commands.bootstrap import ros
from commands.bootstrap.step import SetupLock, Step, run_beside
from commands.bootstrap.venv import ADVICE, extra_requirements
from commands.errors import CommandError, say
from commands.paths import CACHE, KEPT, OUT, OWN, ROOT, read, relative, write

USAGE = "[--build] [--port N]"
FOLDERS = tuple(os.path.join(folder, "docs") for folder in (CACHE, KEPT))
STAMP = ".stamp"
SITE = os.path.join(OUT, "site")
OWNERS = os.path.join(ROOT, "out", "site")  # of who may change the clone
PORTS = range(8000, 8200)  # the first free one is taken
HOST = "127.0.0.1"


def add_arguments(parser):
    """Declares the options."""
    parser.add_argument("--build", action="store_true", help="build, and serve nothing")
    text = "on which it is served (8000, or the next free one)"
    parser.add_argument("--port", metavar="N", type=parsing.port, help=text)


def run(options, _rest):
    """Builds; then becomes a server, until Ctrl-C.

    Raises:
        CommandError: The site cannot be built, or something else listens on the port.
    """
    port = None
    if not options.build:
        with locks.listen(options.port, PORTS) as server:
            port = server.getsockname()[1]
    environ = dict(os.environ, PYTHONNOUSERSITE="1", NO_MKDOCS_2_WARNING="1")
    environ.pop("PYTHONPATH", None)
    site, python = OWNERS, ros.python()
    if OWN or options.build or not os.path.exists(os.path.join(OWNERS, "index.html")):
        site, python = SITE, prepare()
        with SetupLock(f"{FOLDERS[-1]}.lock", "building the site"):
            built = processes.run_child(
                [python, "-m", "mkdocs", "build", "--strict", "-d", SITE], cwd=ROOT, env=environ
            )
        if built != 0:
            raise CommandError("the site cannot be built", "The lines above name the pages.")
    say(f"{relative(site)}/index.html")
    if port:
        say(f"http://{HOST}:{port}/ (Ctrl-C ends it)")
        words = ["http.server", "--bind", HOST, "--directory", site, str(port)]
        processes.become_module(python, words, environ)


def prepare():
    """Installs what builds the site, where that is missing.

    Returns:
        The path of its Python.

    Raises:
        CommandError: The step failed.
        Interrupted: A signal ended it.
    """
    wanted = f"{os.path.realpath(ros.python())} {ROOT}\n{read(extra_requirements('docs'))}"
    with SetupLock():
        for folder in FOLDERS:
            if read(os.path.join(folder, STAMP)) == wanted:
                break
        else:
            work = lambda _: _install(FOLDERS[-1], wanted)  # noqa: E731
            run_beside([Step(1, "What builds the site", work, ADVICE, "install_docs", of=1)])
    return os.path.join(folder, "bin", "python")


def _install(folder, wanted):
    environ = dict(os.environ, PYTHONNOUSERSITE="1")
    environ.pop("PYTHONPATH", None)
    yield [ros.python(), "-m", "venv", "--clear", folder], environ
    python = os.path.join(folder, "bin", "python")
    pip = [python, "-m", "pip", "install", "--disable-pip-version-check", "--no-deps"]
    yield [*pip, "-r", extra_requirements("docs")], environ
    write(os.path.join(folder, STAMP), wanted)
