"""The service ~describe: models, their sensors and controllers, and warnings, as JSON."""

import json

import rospy
from bullet_sim.description.warnings import grouped, is_loss
from std_srvs.srv import Trigger, TriggerResponse

from bullet_bridge.outputs.sensors import CameraOutput


class DescribeService:
    """Answers std_srvs/Trigger with what is in the world.

    Args:
        jobs: JobQueue of the simulation thread.
        world: of the core.
        robots: Robots.
        described: WorldDescription that was loaded, or None.
    """

    def __init__(self, jobs, world, robots, described=None):
        self._jobs, self._world, self._robots = jobs, world, robots
        warnings = [] if described is None else described.warnings
        self._furniture = set() if described is None else _furniture(described)
        self._warnings = [warning for warning in warnings if not is_loss(warning)]
        self._lost = [warning for warning in warnings if is_loss(warning)]
        self._service = rospy.Service("~describe", Trigger, self.handle)

    def handle(self, _):
        """Answer a request."""
        try:
            return TriggerResponse(True, json.dumps(self._jobs.call(self._describe)))
        except TimeoutError as error:
            return TriggerResponse(False, str(error))

    def _describe(self):
        return {
            "world": self._world.name,
            "time_step": self._world.time_step,
            "warnings": grouped(self._warnings),
            "lost": [str(warning) for warning in self._lost],
            "models": [self._model(model) for model in self._world.models.values()],
        }

    def _model(self, model):
        outputs, control = self._robots.parts(model.name)
        found = [warning for warning in model.description.warnings if self._is_new(warning)]
        return {
            "name": model.name,
            "static": model.is_static,
            "furniture": model.name in self._furniture,
            "control_namespace": None if control is None else control.namespace,
            "sensors": [
                {
                    "topic": output.spec.topic,
                    "type": output.message._type,
                    "rate": getattr(output.spec, "rate", 0.0) or 1.0 / self._world.time_step,
                    "link": output.spec.link,
                    "is_camera": isinstance(output, CameraOutput),
                }
                for output in outputs
                if output.reports
            ],
            "warnings": grouped(warning for warning in found if not is_loss(warning)),
            "lost": [str(warning) for warning in found if is_loss(warning)],
        }

    def _is_new(self, warning):
        """Whether the world file's own warnings do not have it already."""
        return warning not in self._warnings and warning not in self._lost


def _furniture(described):
    """Names of a world file's models that have no plugin and no sensor."""
    return {
        model.name
        for model, _ in described.models
        if not model.sensors and model.control_namespace is None
    }
