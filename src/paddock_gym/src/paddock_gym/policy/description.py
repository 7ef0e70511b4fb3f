"""Description in a policy file: its observations, what its actions mean."""

import json
from dataclasses import asdict, dataclass

import numpy as np

from paddock_gym.contract import actions
from paddock_gym.errors import GymError
from paddock_gym.ids import ANY_ROBOT, BACKING, DEEPRACER

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
            if table.get("env") == ANY_ROBOT:
                return RobotPolicyDescription.of_table(table)
            read = actions.ranges if table.get("env") == BACKING else actions.parse
            table["actions"] = read(table["actions"])
            table["observations"] = tuple(table["observations"])
            return cls(**table)
        except (ValueError, TypeError, KeyError) as error:
            raise GymError(f"the policy's description is not one of Paddock's: {error}") from error


@dataclass(frozen=True)
class RobotActions:
    """Numbers that become messages.

    Attributes:
        topics: (topic, type of its messages, count of numbers) each.
        low, high: bounds of the numbers in units of the topics.
        scaled: actions are from -1 to 1, which are low and high.
    """

    topics: tuple
    low: tuple
    high: tuple
    scaled: bool

    @property
    def bounds(self):
        """Lowest and highest action, numbers or arrays."""
        return (-1.0, 1.0) if self.scaled else (np.float32(self.low), np.float32(self.high))

    def command(self, action):
        """(topic, type, numbers) of each message for an action."""
        low, high, numbers = np.array(self.low), np.array(self.high), np.asarray(action, float)
        if self.scaled:
            numbers = low + (numbers + 1.0) * 0.5 * (high - low)
        free = iter(np.clip(numbers, low, high).tolist())
        return [(topic, kind, [next(free) for _ in range(n)]) for topic, kind, n in self.topics]


@dataclass(frozen=True)
class RobotPolicyDescription:
    """Description of a policy of Robot-v0.

    Attributes:
        observations: names of its inputs, in order.
        sources: name -> keyword arguments of driver.robot.Source.
        actions: RobotActions.
        control_rate: actions a second [Hz].
    """

    observations: tuple
    sources: dict
    actions: RobotActions
    control_rate: float
    env: str = ANY_ROBOT

    def text(self):
        """JSON text for the file."""
        return json.dumps(asdict(self))

    @classmethod
    def of_table(cls, table):
        """Reads the table of text()."""
        table["actions"] = RobotActions(**table["actions"])
        table["observations"] = tuple(table["observations"])
        return cls(**table)
