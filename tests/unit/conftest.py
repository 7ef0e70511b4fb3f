"""Fixtures of the project's own tests."""

import pathlib
import sys

import pytest

# the test runner's package lies one directory up
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import run_rig  # puts the package commands on the path


@pytest.fixture(scope="session")
def package_index():
    """A package index that answers at once."""
    index = run_rig.PackageIndex()
    index.open.set()
    yield index
    index.close()


@pytest.fixture(scope="session")
def clone(tmp_path_factory, package_index):
    """A small clone that is set up."""
    root = run_rig.small_clone(tmp_path_factory.mktemp("clone") / "paddock")
    done = run_rig.run("setup", root=root, env=package_index.environment())
    assert done.returncode == 0, done.stdout + done.stderr
    return root
