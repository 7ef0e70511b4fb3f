"""Settings of a training, stored in its folder so that it can continue."""

from __future__ import annotations

import json
import math
import os
from dataclasses import asdict, dataclass

from paddock_gym.contract import hyperparameters
from paddock_gym.errors import GymError
from paddock_gym.ids import BACKING, ENVS

FILE = "settings.json"

MAY_CHANGE = ("steps", "until_laps", "workers", "threads", "tensorboard")  # by --resume
ROLLOUT, BATCH = 512, 128  # actions of an update in all, of one of its steps


@dataclass(frozen=True)
class Settings:
    """Settings of a training.

    Attributes:
        name: of the folder in out/train/.
        env: deepracer or backing; with backing the options up to metadata have no effect.
        track, observation, race, walls, colour: as the environment's options.
        randomize: names of randomize.RANDOMIZABLE.
        reward: progress, or the absolute path of a file.
        metadata: absolute path of a model_metadata.json, or "".
        hyperparameters: absolute path of a hyperparameters.json, or "".
        steps: actions of the full training.
        until_laps: it ends before, as soon as the policy makes laps from all unseen starts.
        workers: processes or Ray actors with one car each; 0: one for each processor of Ray.
        threads: workers are worlds in threads of one process, not processes or actors.
        seed: of the network, the starts and the noise.
        tensorboard: whether there is a log for TensorBoard, too.
    """

    name: str
    env: str = "deepracer"
    track: str = "default"
    observation: tuple = ("state",)
    race: str = "time_trial"
    walls: bool | None = None
    colour: bool = False
    randomize: tuple = ("start",)
    reward: str = "progress"
    metadata: str = ""
    hyperparameters: str = ""
    steps: int = 60_000
    until_laps: bool = False
    workers: int = 4
    threads: bool = False
    seed: int = 0
    tensorboard: bool = False

    def __post_init__(self):
        for name in ("observation", "randomize"):  # lists in JSON
            object.__setattr__(self, name, tuple(getattr(self, name)))

    def environment(self):
        """Keyword arguments of the environment, with its Gymnasium id."""
        if self.env == BACKING:
            return {"id": ENVS[BACKING]}
        names = self.observation
        return {
            "id": ENVS[self.env],
            "track": self.track,
            "observation": names[0] if len(names) == 1 else names,
            "action": self.metadata or "continuous",
            "reward": self.reward,
            "race": self.race,
            "randomize": self.randomize,
            "walls": self.walls,
            "colour": self.colour,
        }

    def algorithm(self, actors=False):
        """Keyword arguments of PPO.

        Args:
            actors: whether workers are actors, which drive alone for longer.
        """
        with_images = "camera" in self.observation
        arguments = {
            "n_steps": 512,
            "batch_size": 256,
            "n_epochs": 4 if with_images else 10,
            "learning_rate": 5e-4 if with_images else 1e-3,
            "gamma": 0.99 if self.env == BACKING else 0.98,
            "gae_lambda": 0.95,
            "ent_coef": 0.0,
        }
        if self.hyperparameters:
            arguments.update(_of_file(hyperparameters.load(self.hyperparameters)))
        elif self.observation == ("state",) and self.env != BACKING and not actors:
            # small updates, in whole batches: laps after the fewest actions
            part = BATCH // math.gcd(BATCH, self.workers)
            count = part * max(1, round(ROLLOUT / self.workers / part))
            arguments.update(n_steps=count, batch_size=BATCH)
        return arguments

    def save(self, folder):
        """Write them into a folder."""
        hyperparameters.write_json(os.path.join(folder, FILE), asdict(self))

    @classmethod
    def load(cls, folder):
        """Read what save() wrote.

        Raises:
            GymError: there is no training to continue.
        """
        path = os.path.join(folder, FILE)
        try:
            with open(path, encoding="utf-8") as stream:
                table = json.load(stream)
        except (OSError, ValueError) as error:
            raise GymError(f"{path} cannot be read ({error}); there is no such training") from error
        return cls(**table)


def _of_file(parameters):
    """PPO's arguments of a hyperparameters.json; only the ones that it names."""
    named = {
        "batch_size": parameters.batch_size,
        "n_epochs": parameters.num_epochs,
        "learning_rate": parameters.lr,
        "ent_coef": parameters.beta_entropy,
        "gamma": parameters.discount_factor,
    }
    return {key: value for key, value in named.items() if value is not None}
