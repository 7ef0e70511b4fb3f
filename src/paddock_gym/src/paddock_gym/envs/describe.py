"""What a policy's file says of the Robot-v0 that it was trained on: a node can drive by it."""

from __future__ import annotations

from typing import Any

from bullet_sim.parts.outputs import DepthPointsOutput

from paddock_gym.envs.robot import RobotEnv
from paddock_gym.envs.tasks import Goal
from paddock_gym.envs.topics import Observed, resolved
from paddock_gym.errors import GymError
from paddock_gym.policy.description import RobotActions, RobotPolicyDescription


def policy_description(env: Any) -> RobotPolicyDescription:
    """The description for policy.export.export().

    Args:
        env: a Robot-v0, wrapped or not.

    Raises:
        GymError: a robot has nothing that gives one of the observations.
    """
    robot: RobotEnv = env.unwrapped
    agent, task, actions = robot.agent, robot.task, robot.actions
    sources = {name: _source(name, found) for name, found in agent.observed.items()}
    if isinstance(task, Goal):
        link = f"{agent.model.name}::{agent.model.description.root}"
        sources["goal"] = {"link": link, "area": task.area}
    elif task.spaces:
        raise GymError(f"a robot has nothing that gives {', '.join(task.spaces)} of the task")
    return RobotPolicyDescription(
        tuple(sources),
        sources,
        RobotActions(
            tuple((each.topic, each.message, len(each.names)) for each in actions.topics),
            tuple(actions.low.tolist()),
            tuple(actions.high.tolist()),
            actions.scaled,
        ),
        1.0 / robot.period,
    )


def _source(name: str, observed: Observed) -> dict[str, Any]:
    """Keyword arguments of driver.robot.Source."""
    if observed.topic is None:
        return {"link": observed.link}
    output, part = observed.topic.output, name.partition(":")[2]
    shapes = output.shapes()
    return {
        "topic": resolved(name.partition(":")[0]),
        "message": getattr(output, "message", output.MESSAGE),
        "fields": {field: list(shapes[field].shape) for field in ([part] if part else shapes)},
        "most": observed.most,
        "raw": bool(part),
        "organized": isinstance(output, DepthPointsOutput),
        "dtype": str(observed.space.dtype),
    }
