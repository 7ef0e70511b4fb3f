"""`from bullet_sim import ...`: the public names, imported on demand."""

import subprocess
import sys

import pytest

import bullet_sim


@pytest.mark.parametrize("name", bullet_sim.__all__)
def test_public_name(name):
    value = getattr(bullet_sim, name)
    if name != "CONTROLLERS":
        assert value.__name__ == name
    assert value.__module__.startswith("bullet_sim.") and value.__doc__
    assert name in dir(bullet_sim)


def test_another_name():
    with pytest.raises(AttributeError, match="module 'bullet_sim' has no attribute 'Wrold'"):
        _ = bullet_sim.Wrold
    with pytest.raises(ImportError, match="cannot import name 'Wrold' from 'bullet_sim'"):
        from bullet_sim import Wrold  # noqa: F401


def test_the_package_alone_imports_nothing():
    script = (
        "import bullet_sim, sys; bullet_sim.Pose;"
        "print(*sorted(name for name in sys.modules if name.startswith('bullet_sim')))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("bullet_sim bullet_sim.pose\n", "")


def test_former_names():
    assert bullet_sim.Pose.normalised is bullet_sim.Pose.normalized
