"""Services beyond Gazebo's: step, save and restore states, describe, statistics."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.controllers import CONTROLLERS
from bullet_sim.description.warnings import grouped, is_loss, missing
from bullet_sim.errors import WorldError
from bullet_sim.plugins.custom import CustomSpec
from std_srvs.srv import Trigger, TriggerResponse

from bullet_bridge.plugins.cameras import CameraSensor
from bullet_bridge.services.handlers import offer
from bullet_bridge.srv import State, StateResponse, Step, StepResponse

if TYPE_CHECKING:
    from bullet_sim.description.world import WorldDescription
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

    from bullet_bridge.loop.jobs import JobQueue
    from bullet_bridge.loop.received import ReceivedCounts, Taken
    from bullet_bridge.loop.server import Server, Steps
    from bullet_bridge.robots import Robots


class StateServices:
    """Stores states by their names, in memory."""

    def __init__(self, prefix: str, jobs: JobQueue, server: Server) -> None:
        self._jobs, self._server = jobs, server
        self._states: dict[str, Any] = {}
        offer(prefix, ("save_state", State, self.save), ("restore_state", State, self.restore))

    def save(self, request: Any) -> StateResponse:
        """Save a state; one of the same name is replaced."""
        name = request.name
        if not name:
            raise WorldError("a state needs a name, this one is empty")

        def work() -> float:
            self._states[name] = self._server.save_state()
            return self._server.time

        time = self._jobs.call(work)
        return StateResponse(status_message=f"saved '{name}' at {time:.3f} s")

    def restore(self, request: Any) -> StateResponse:
        def work() -> tuple[str, float]:
            return self._server.restore_state(self._get(request.name)), self._server.time

        note, time = self._jobs.call(work)
        return StateResponse(
            status_message=f"restored '{request.name}', it is {time:.3f} s" + (note and f"; {note}")
        )

    def _get(self, name: str) -> Any:
        if name not in self._states:
            raise WorldError(
                f"state '{name}' does not exist; saved are {', '.join(self._states) or '(none)'}"
            )
        return self._states[name]


def advertise_json(name: str, jobs: JobQueue, work: Callable[[], Any]) -> None:
    """Advertise a std_srvs/Trigger service that responds with the result of a job, as JSON.

    Args:
        work: changes nothing, see JobQueue.read.
    """

    def handle(_: Any) -> TriggerResponse:
        try:
            return TriggerResponse(True, json.dumps(jobs.read(work)))
        except TimeoutError as error:
            return TriggerResponse(False, str(error))

    rospy.Service(name, Trigger, handle)


class Describer:
    """Describes what is in the world.

    Args:
        described: WorldDescription that was loaded, or None.
    """

    def __init__(
        self,
        world: World,
        robots: Robots,
        described: WorldDescription | None = None,
    ) -> None:
        self._world, self._robots = world, robots
        warnings = [] if described is None else described.warnings
        self._static_props = set() if described is None else _static_props(described)
        self._read, self._warnings = frozenset(warnings), _summary(warnings)

    def describe(self) -> dict[str, Any]:
        """The world and its models (simulation thread)."""
        return {
            "world": self._world.name,
            "time_step": self._world.time_step,
            **self._warnings,
            "models": [self._model(model) for model in self._world.models.values()],
        }

    def _model(self, model: Model) -> dict[str, Any]:
        plugins, control = self._robots.parts_of(model.name)
        parts = [*plugins, *([] if control is None else control.topics())]
        summary = _summary(w for w in model.description.warnings if w not in self._read)
        summary["lost"] += self._robots.skipped(model)
        return {
            **summary,
            "name": model.name,
            "static": model.is_static and not model.description.is_empty,
            "furniture": model.name in self._static_props,
            "control_namespace": None if control is None else control.namespace,
            "sensors": [
                {
                    "topic": plugin.spec.topic,
                    "type": plugin.message_type(),
                    "rate": plugin.nominal_rate,
                    "link": plugin.spec.link,
                    "is_camera": isinstance(plugin, CameraSensor),
                }
                for plugin in plugins
                if plugin.reports
            ],
            "commands": sorted(set().union(*(part.topics_received() for part in parts))),
            "extensions": self._extensions(model),
            "times_moved": model.times_moved,
            "joints": len(model.joints.names),
        }

    def _extensions(self, model: Model) -> list[str]:
        """Messages about users' classes that the model uses."""
        known = self._robots.extensions
        used = [
            known.of(spec) for spec in model.description.sensors if isinstance(spec, CustomSpec)
        ]
        if model.manager is not None:
            types = dict.fromkeys(each.config.type for each in model.manager.controllers())
            used += [
                known.get("controller", kind) for kind in types if not CONTROLLERS.is_built_in(kind)
            ]
        return [str(extension) for extension in used]


def _summary(warnings: Iterable[str]) -> dict[str, Any]:
    """Warnings in one line a cause, losses, and what is missing by its cause."""
    warnings = list(warnings)
    files = missing(warnings)
    plain = [w for w in warnings if not is_loss(w) and getattr(w, "cause", "") not in files]
    lost = [str(warning) for warning in warnings if is_loss(warning)]
    return {"warnings": grouped(plain), "lost": lost, "missing": files}


def _static_props(described: WorldDescription) -> set[str]:
    """Names of a world file's models that have no plugin and no sensor."""
    return {
        model.name
        for model, _ in described.models
        if not model.sensors and model.control_namespace is None
    }


CHECK_PERIOD = 0.2  # [s] wall time between two checks for a shutdown


class StepService:
    """Waits for commands, makes steps, responds when all due messages are published.

    Args:
        timeout: wall time [s] to wait for commands.
    """

    def __init__(
        self, jobs: JobQueue, server: Server, received: ReceivedCounts, timeout: float
    ) -> None:
        self._jobs, self._server, self._received = jobs, server, received
        self._timeout = timeout
        self._service = rospy.Service("~step", Step, self.handle)

    def handle(self, request: Any) -> StepResponse:
        try:
            required = self._required(request)
            self._jobs.read(self._check)
            steps = self._begin(request.n, self._received.take(required, self._timeout))
        except (ValueError, TimeoutError) as error:  # SimError is a ValueError
            rospy.logerr("step: %s", error)
            return StepResponse(False, str(error))
        while not steps.done.wait(CHECK_PERIOD):
            if rospy.is_shutdown():
                return StepResponse(False, "the simulation has ended")
        if steps.error:
            rospy.logerr("step: %s", steps.error)
        return StepResponse(not steps.error, steps.error)

    def _begin(self, count: int, taken: Taken) -> Steps:
        """Start the steps; if that fails, the messages count for the next call."""
        try:
            return self._jobs.call(lambda: self._server.begin_steps(count))
        except (ValueError, TimeoutError):
            self._received.restore(taken)
            raise

    def _check(self) -> None:
        if not self._server.paused:
            raise ValueError("the simulation runs; pause it before stepping")

    @staticmethod
    def _required(request: Any) -> dict[str, int]:
        if request.n < 1:
            raise ValueError("n is 0, must be at least 1 physics step")
        if len(request.topics) != len(request.counts):
            raise ValueError(
                f"{len(request.topics)} topics and {len(request.counts)} counts are "
                "given, must be as many"
            )
        required = {}
        for topic, count in zip(request.topics, request.counts):
            if not topic:
                raise ValueError("a topic without a name is given")
            name = rospy.resolve_name("/" + topic.lstrip("/"))
            if name in required:
                raise ValueError(f"topic '{name}' is given twice")
            required[name] = count
        return required
