"""Fixtures: a small clone whose set-up is interrupted and goes on."""

import os
import signal

import pytest
import run_rig  # puts the package commands on the path


@pytest.fixture(scope="session")
def package_index():
    """A package index that makes pip wait until its event `open` is set."""
    index = run_rig.PackageIndex()
    yield index
    index.close()


@pytest.fixture(scope="session")
def interrupted(tmp_path_factory, package_index):
    """A small clone whose set-up got SIGINT while pip was at work, and what came of it."""
    root = run_rig.small_clone(tmp_path_factory.mktemp("clone") / "paddock")
    process = run_rig.start("setup", root=root, env=package_index.environment())
    asked = package_index.asked.wait(run_rig.PATIENCE)
    working = run_rig.processes_of(root)
    os.kill(process.pid, signal.SIGINT)
    said, _ = process.communicate(timeout=run_rig.PATIENCE)
    assert asked, said
    yield run_rig.Interruption(
        root=root,
        working=working,
        status=process.returncode,
        said=said,
        left=run_rig.processes_of(root),
        stamped=run_rig.stamped(root),
    )


@pytest.fixture(scope="session")
def completed(interrupted, package_index):
    """The set-up that goes on in that clone, to its end."""
    package_index.open.set()
    return run_rig.run("setup", root=interrupted.root, env=package_index.environment())


@pytest.fixture(scope="session")
def clone(interrupted, completed):
    """A small clone that is set up."""
    assert completed.returncode == 0, completed.stdout + completed.stderr
    return interrupted.root
