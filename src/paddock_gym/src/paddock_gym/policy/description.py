"""Description in a policy file: its observations, what its actions mean."""

import json
from dataclasses import dataclass

from paddock_gym.contract import actions
from paddock_gym.errors import GymError
from paddock_gym.ids import BACKING, DEEPRACER

KEY = "paddock"  # of the ONNX file's metadata
OUTPUT = "action"


@dataclass(frozen=True)
class PolicyDescription:
    """Description of a policy.

    Attributes:
        observations: names of its inputs, in order: state, lidar, camera.
        colour: whether camera images have three channels.
        actions: Continuous or Discrete.
        control_rate: actions a second [Hz].
        track: that it was trained on.
        race: as the environment's option.
        env: deepracer or backing.
    """

    observations: tuple
    colour: bool
    actions: object
    control_rate: float
    track: str
    race: str = "time_trial"
    env: str = DEEPRACER

    def text(self):
        """JSON text for the file."""
        table = dict(vars(self), actions=actions.table(self.actions))
        return json.dumps(table)

    @classmethod
    def of_text(cls, text):
        """Reads text().

        Raises:
            GymError: it is not such a text.
        """
        try:
            table = json.loads(text)
            read = actions.ranges if table.get("env") == BACKING else actions.parse
            table["actions"] = read(table["actions"])
            table["observations"] = tuple(table["observations"])
            return cls(**table)
        except (ValueError, TypeError, KeyError) as error:
            raise GymError(f"the policy's description is not one of Paddock's: {error}") from error
