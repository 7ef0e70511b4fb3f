"""What a worker on another machine gets: options, and the files they name."""

import os
import pathlib
import signal
import subprocess
import sys

import pytest
from bullet_sim.files import remove_ownerless
from paddock_gym.training.worker import Parcel, environment

REWARD = "def reward_function(params):\n    return 2.5\n"


@pytest.fixture
def reward(tmp_path):
    """A reward_function.py."""
    path = tmp_path / "reward_function.py"
    path.write_text(REWARD)
    return path


def test_files_travel_where_they_are_missing_or_differ(reward):
    parcel = Parcel.packed({"reward": str(reward), "track": "default", "walls": None})
    assert parcel.unpacked() == {"reward": str(reward), "track": "default", "walls": None}
    for change in (reward.unlink, lambda: reward.write_text("another")):
        change()
        options = parcel.unpacked()
        written = pathlib.Path(options.pop("reward"))
        assert written != reward and written.name == reward.name
        assert written.read_text() == REWARD
        assert options == {"track": "default", "walls": None}


def test_what_a_killed_worker_has_unpacked_goes(tmp_path, reward):
    parcel = Parcel.packed({"reward": str(reward)})
    reward.unlink()
    code = f"""
import os
from paddock_gym.training.worker import Parcel
print(Parcel(**{vars(parcel)!r}).unpacked()["reward"], flush=True)
os._exit(1)
"""
    environ = dict(os.environ, TMPDIR=str(tmp_path), PYTHONPATH=os.pathsep.join(sys.path))
    done = subprocess.run([sys.executable, "-c", code], env=environ, capture_output=True, text=True)
    written = pathlib.Path(done.stdout.strip())
    assert written.read_text() == REWARD and tmp_path in written.parents
    remove_ownerless(str(tmp_path))
    assert not written.exists() and list(tmp_path.iterdir()) == []


@pytest.fixture
def interrupts():
    """Ctrl-C ends the tests again, although an environment's process leaves it to its parent."""
    before = signal.getsignal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_environment_drives_by_a_reward_that_travelled(reward, interrupts):
    parcel = Parcel.packed({"reward": str(reward)})
    reward.unlink()
    env = environment(parcel.unpacked())
    env.reset(seed=0)
    assert env.step(env.action_space.sample())[1] == 2.5
    env.close()
