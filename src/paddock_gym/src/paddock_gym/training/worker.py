"""One environment of a training, for any process; needs no torch."""

import pathlib
import signal
from dataclasses import dataclass

import gymnasium
from bullet_sim.files import OwnFolder

from paddock_gym.errors import RewardError

LOST = "worker lost"  # as the end of a run
LOGGED_KEYS = ("end", "progress", "time", "x", "y")  # of the last info, for the log of runs
FILES = ("track", "action", "reward")  # options that may be paths


@dataclass(frozen=True)
class Parcel:
    """Options of an environment with the content of their files, for another machine.

    Attributes:
        options: keyword arguments of the environment.
        files: option -> (file name, bytes).
    """

    options: dict
    files: dict

    @classmethod
    def packed(cls, options):
        """Read the files that options name."""
        paths = {name: pathlib.Path(str(options.get(name))) for name in FILES}
        files = {name: (path.name, path.read_bytes()) for name, path in paths.items()
                 if path.is_file()}  # fmt: skip
        return cls(options, files)

    def unpacked(self):
        """Options whose files exist: written to a temporary folder where they differ.

        The folder lives as long as this process, see bullet_sim.files.
        """
        options, folder = dict(self.options), None
        for name, (file, content) in self.files.items():
            path = pathlib.Path(options[name])
            if not path.is_file() or path.read_bytes() != content:
                folder = folder or OwnFolder()
                path = pathlib.Path(folder.path) / name / file
                path.parent.mkdir()
                path.write_bytes(content)
            options[name] = str(path)
        return options


def environment(options):
    """Create an environment, in a process that ignores SIGINT (its parent handles it).

    Args:
        options: keyword arguments of the environment; id: its Gymnasium id (DeepRacer).
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return make(options)


def make(options):
    """As environment(), in any thread."""
    from paddock_gym.ids import IDS  # the package registers the environments

    env = Reporting(gymnasium.make(**{"id": IDS[0], **options}))
    return gymnasium.wrappers.RecordEpisodeStatistics(env, buffer_length=1)


class Reporting(gymnasium.Wrapper):
    """Reports an error of a user's reward function: the run ends with info["error"]."""

    def reset(self, **options):
        """Start a run."""
        self._last = self.env.reset(**options)
        return self._last

    def step(self, action):
        """Apply an action."""
        try:
            observation, reward, terminated, truncated, info = self.env.step(action)
        except RewardError as error:
            observation, info = self._last
            return observation, 0.0, True, False, dict(info, error=str(error))
        self._last = observation, info
        return observation, reward, terminated, truncated, info
