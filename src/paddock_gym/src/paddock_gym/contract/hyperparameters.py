"""hyperparameters.json of DeepRacer, as PPO of stable-baselines3 takes it."""

from dataclasses import dataclass

from paddock_gym.contract import json_file
from paddock_gym.errors import GymError

# Key -> smallest, largest; of the console.
RANGES = {
    "batch_size": (8, 4096),
    "num_epochs": (1, 50),
    "lr": (1e-8, 1e-1),
    "beta_entropy": (0.0, 1.0),
    "discount_factor": (0.0, 1.0),
    "num_episodes_between_training": (1, 1000),
}
LOSSES = ("huber", "mse", "mean squared error")
# Known keys that mean nothing to PPO here.
IGNORED = (
    "e_greedy_value",
    "epsilon_steps",
    "exploration_type",
    "stack_size",
    "term_cond_avg_score",
    "term_cond_max_episodes",
    "sac_alpha",
)


@dataclass(frozen=True)
class Hyperparameters:
    """Of a training; None: ours.

    Attributes:
        batch_size, num_epochs, lr, beta_entropy, discount_factor: of PPO.
        num_episodes_between_training: runs between updates; their mean length makes it steps.
        loss_type: of the value function: huber or mse.
        ignored: keys of the file that mean nothing here.
    """

    batch_size: int | None = None
    num_epochs: int | None = None
    lr: float | None = None
    beta_entropy: float | None = None
    discount_factor: float | None = None
    num_episodes_between_training: int | None = None
    loss_type: str | None = None
    ignored: tuple = ()


def load(path):
    """Read a hyperparameters.json.

    Raises:
        GymError: a key or value is wrong.
    """
    return parse(path, json_file.load(path))


def parse(path, table):
    """Check what a hyperparameters.json holds.

    Args:
        path: of the file, for messages.
        table: its content.

    Raises:
        GymError: a key or value is wrong.
    """
    found, ignored = {}, []
    for key, value in table.items():
        if key in RANGES:
            number = json_file.number(path, key, value, *RANGES[key])
            whole = isinstance(RANGES[key][0], int)
            if whole and number != int(number):
                raise GymError(f"{path}: {key} is {value!r}; it must be a whole number")
            found[key] = int(number) if whole else number
        elif key == "loss_type":
            found[key] = "huber" if json_file.one_of(path, key, value, LOSSES) == "huber" else "mse"
        elif key in IGNORED:
            ignored.append(key)
        else:
            valid = ", ".join([*RANGES, "loss_type", *IGNORED])
            raise GymError(f"{path}: unknown key {key!r}; there are {valid}")
    return Hyperparameters(**found, ignored=tuple(ignored))
