"""For the tests of ./run exec's environment: what devel/setup.bash makes of one, and ./run."""

from run_rig import NOISE, ROOT, run

PLAIN = {"PATH": "/usr/local/bin:/usr/bin:/bin", "HOME": "/tmp"}
SOURCE = f". {ROOT}/devel/setup.bash >/dev/null && exec /usr/bin/env -0"


def variables(done):
    """The variables that env -0 printed."""
    assert done.returncode == 0, done.stderr
    entries = [entry.split("=", 1) for entry in done.stdout.split("\0")[:-1]]
    return {name: value for name, value in entries if name not in NOISE}


def by_run(root, environ):
    """The environment of ./run exec."""
    return variables(run("exec", "/usr/bin/env", "-0", root=root, env=environ))
