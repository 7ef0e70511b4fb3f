"""Makes this machine a node of a Ray cluster, until Ctrl-C, for ./run train --ray on any of them.

`head` starts a cluster and says what to type on the other machines; `join HOST:PORT` adds one.
Each machine has this project, at any path, of the same state. The ports are open to the network:
Ray lets in who has the token, and encrypts nothing, so the network must be one that you trust.
docs/cluster.md tells more.
"""

import os
import re

from commands import environment, processes
from commands.errors import UsageError, say
from commands.paths import VENV

USAGE = "head | join HOST:PORT"
PORT = 6379


def add_arguments(parser):
    """Declares what to be."""
    part = parser.add_argument("part", metavar="head | join", help="start a cluster, or join one")
    part.complete = lambda: ("head", "join")
    parser.add_argument("address", nargs="?", metavar="HOST:PORT", help="of the head, for join")


def run(options, _rest):
    """Becomes Ray's node."""
    import subprocess

    from commands.bootstrap import venv

    arguments = wanted(options)
    environ = environment.ready()
    venv.prepare_extras("learning", "ray")
    environ.update(RAY_AUTH_MODE="token", RAY_USAGE_STATS_ENABLED="0")
    ray = os.path.join(VENV, "bin", "ray")
    if options.part == "head":
        processes.run_child(
            [ray, "get-auth-token", "--generate"], env=environ, stdout=subprocess.DEVNULL
        )
        say(
            "cluster: on the other machines, with this machine's ~/.ray/auth_token copied there:\n"
            f"cluster: ./run cluster join HERE:{PORT}"
        )
    processes.become([ray, "start", *arguments, "--block"], environ)


def wanted(options):
    """Returns the arguments of `ray start`."""
    if options.part == "head" and options.address is None:
        return ["--head", f"--port={PORT}", "--include-dashboard=false"]
    if options.part == "join" and re.fullmatch(r"[A-Za-z0-9.-]+:[0-9]{1,5}", options.address or ""):
        return [f"--address={options.address}"]
    given = " ".join(filter(None, (options.part, options.address)))
    raise UsageError(f"cluster is {given!r}; it must be head, or join HOST:PORT")
