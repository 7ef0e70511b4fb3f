"""A policy from an ONNX file, by ONNX Runtime on one thread."""

import os

import numpy as np

from paddock_gym.contract.actions import Discrete
from paddock_gym.errors import GymError
from paddock_gym.ids import DEEPRACER
from paddock_gym.policy.description import KEY, OUTPUT, PolicyDescription


class OnnxPolicy:
    """Decides by a network.

    Args:
        env: that it must have been trained on: deepracer, backing, robot; None: any.

    Raises:
        GymError: there is no such file, or it is not a policy of Paddock, or one of another env;
            or there is no ONNX Runtime.
    """

    def __init__(self, path, env=DEEPRACER):
        if not os.path.isfile(path):
            raise GymError(f"policy is {path!r}; there is no such file")
        try:
            import onnxruntime
        except ModuleNotFoundError as error:
            raise GymError(
                "onnxruntime, which runs policies, is not installed: ./run setup --with gym"
            ) from error

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 3
        try:
            self._session = onnxruntime.InferenceSession(
                path, options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # onnxruntime's own classes, which it does not export
            raise GymError(f"{path} is not an ONNX file that can be run: {error}") from error
        text = self._session.get_modelmeta().custom_metadata_map.get(KEY)
        if text is None:
            raise GymError(f"{path} has no description {KEY!r}; it must be of ./run train")
        self.description = PolicyDescription.of_text(text)
        if env not in (None, self.description.env):
            raise GymError(f"{path} was trained on {self.description.env}; it must be of {env}")
        self._inputs = [item.name for item in self._session.get_inputs()]
        if tuple(self._inputs) != self.description.observations:
            raise GymError(
                f"{path} has inputs {self._inputs}, its description names "
                f"{list(self.description.observations)}"
            )

    def act(self, observation):
        """The action for an observation.

        Args:
            observation: array, or dict of arrays, as of the environment.

        Returns:
            float32 from -1 to 1 (of Robot-v0: as its action space), or an index of the discrete
            actions.
        """
        if not isinstance(observation, dict):
            observation = {self._inputs[0]: observation}
        feed = {name: np.asarray(observation[name])[None] for name in self._inputs}
        action = self._session.run([OUTPUT], feed)[0][0]
        if isinstance(self.description.actions, Discrete):
            return int(action)
        return np.clip(action, *self.description.actions.bounds)

    def command(self, observation):
        """What actions.command() gives for an observation."""
        return self.description.actions.command(self.act(observation))
