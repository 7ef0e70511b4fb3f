"""ONNX files made of numpy numbers, so that policies can be tested without torch."""

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from paddock_gym.contract import actions
from paddock_gym.policy.description import KEY, OUTPUT, PolicyDescription

from paddock_gym import observations

SIZES = {"state": observations.STATE_SHAPE, "lidar": observations.RANGES_SHAPE}


def describe(observation="state", chosen=None, **others):
    """PolicyDescription of a test's policy."""
    values = {"control_rate": 15.0, "track": "default", **others}
    return PolicyDescription((observation,), False, chosen or actions.Continuous(), **values)


def write(path, weights, bias, description, size=None):
    """Write a policy whose action is tanh(weights @ observation + bias).

    Args:
        path: of the file.
        weights: (A, N); bias: (A,).
        description: PolicyDescription of one observation.
        size: of the observation, where it is not a DeepRacer's: (N,).

    Returns:
        The path as text.
    """
    name = description.observations[0]
    discrete = isinstance(description.actions, actions.Discrete)
    nodes = [
        helper.make_node("Gemm", [name, "weights", "bias"], ["sum"], transB=1),
        helper.make_node("ArgMax", ["sum"], [OUTPUT], axis=1, keepdims=0)
        if discrete
        else helper.make_node("Tanh", ["sum"], [OUTPUT]),
    ]
    kind, shape = (TensorProto.INT64, ["n"]) if discrete else (TensorProto.FLOAT, ["n", 2])
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n", *(size or SIZES[name])])],
        [helper.make_tensor_value_info(OUTPUT, kind, shape)],
        [
            numpy_helper.from_array(np.asarray(value, np.float32), label)
            for label, value in (("weights", weights), ("bias", bias))
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 15)], ir_version=8)
    helper.set_model_props(model, {KEY: description.text()})
    onnx.save(model, str(path))
    return str(path)


def lane_keeper(path, speed=-0.6, **others):
    """A policy that steers back to the centreline and into the bend ahead, at a steady speed."""
    weights = np.zeros((2, observations.STATE_SHAPE[0]))
    weights[0, 0], weights[0, 1], weights[0, 9] = -1.0, -3.0, 0.35
    return write(path, weights, (0.0, np.arctanh(speed)), describe(**others))
