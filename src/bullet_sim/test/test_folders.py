"""Folders of living processes stay, those of killed ones go with the next start."""

import os
import subprocess
import sys

import pytest
from bullet_sim.files import PREFIX, OwnFolder, remove_ownerless

from bullet_sim import files

OWNER = """
import sys, signal
from bullet_sim.world import World
world = World()
print("ready", flush=True)
signal.pause()
"""


@pytest.fixture(name="owner")
def _owner(tmp_path):
    """A process with a World whose temporary folder lies in tmp_path."""
    process = subprocess.Popen(
        [sys.executable, "-c", OWNER],
        stdout=subprocess.PIPE,
        text=True,
        env=dict(os.environ, TMPDIR=str(tmp_path), PYTHONPATH=os.pathsep.join(sys.path)),
    )
    with process:
        while process.stdout.readline().strip() not in ("ready", ""):
            pass
        yield process
        process.kill()


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_folder_goes_when_it_is_closed(tmp_path):
    folder = OwnFolder(str(tmp_path))
    assert os.path.basename(folder.path).startswith(PREFIX)
    assert [os.path.basename(folder.path)] == names(tmp_path)
    folder.close()
    folder.close()
    assert names(tmp_path) == []


def test_the_next_start_removes_what_sigkill_has_left(tmp_path, owner, monkeypatch):
    left = names(tmp_path)
    assert len(left) == 1
    assert remove_ownerless(str(tmp_path)) == []  # its owner lives
    assert names(tmp_path) == left
    owner.kill()
    owner.wait()
    assert names(tmp_path) == left
    monkeypatch.setattr(files, "_cleaned", set())
    folder = OwnFolder(str(tmp_path))
    assert names(tmp_path) == [os.path.basename(folder.path)]
    folder.close()


def test_what_is_not_ours_stays(tmp_path, monkeypatch):
    (tmp_path / "bullet_sim_other").mkdir()
    (tmp_path / f"{PREFIX}file").write_text("")
    target = tmp_path / "target"
    target.mkdir()
    (target / "kept").write_text("")
    (tmp_path / f"{PREFIX}link").symlink_to(target)
    foreign = tmp_path / f"{PREFIX}foreign"
    foreign.mkdir()
    before = names(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(os, "getuid", lambda: 12345678)
        assert remove_ownerless(str(tmp_path)) == []
    assert names(tmp_path) == before
    assert remove_ownerless(str(tmp_path)) == [foreign.name]
    assert (target / "kept").exists()


def test_a_directory_that_cannot_be_read_is_left_alone(tmp_path):
    assert remove_ownerless(str(tmp_path / "nothing")) == []


FULL = """
import resource, sys
from bullet_sim.errors import ModelError
from bullet_sim.pose import Pose
from bullet_sim.world import World
TEXT = "<robot name='a'><link name='b'><inertial><mass value='1'/><inertia ixx='1' iyy='1' \
izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>"
POINTS = "".join(f"<point>{x} {y}</point>" for x, y in ((0, 0), (1, 0), (0, 1)))
SHAPE = f"<geometry><polyline>{POINTS}<height>1</height></polyline></geometry>"
WEDGE = f"<sdf version='1.6'><model name='w'><link name='l'><collision name='c'>{SHAPE}"
WEDGE += "</collision></link></model></sdf>"
world = World()
world.spawn_urdf("first", TEXT, Pose(), str)
resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
try:
    world.spawn_sdf("wedge", WEDGE, Pose(), str)
except ModelError as error:
    print("refused:", error)
resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
world.step(10)
world.reset()
world.spawn_sdf("wedge", WEDGE, Pose(), str)
print(sorted(world.models), world.step_count)
world.close()
"""


def test_a_model_that_cannot_be_written_is_refused_and_the_world_goes_on(tmp_path):
    """A file size of 0 stands in for a full disk: no root is needed for it."""
    done = subprocess.run(
        [sys.executable, "-c", FULL],
        capture_output=True,
        text=True,
        env=dict(os.environ, TMPDIR=str(tmp_path), PYTHONPATH=os.pathsep.join(sys.path)),
    )
    assert "refused: 'wedge' cannot be prepared in" in done.stdout, done.stderr
    assert "File too large" in done.stdout
    assert "['first', 'wedge'] 0" in done.stdout
