"""The service ~describe: models, their sensors and controllers, and warnings, as JSON."""

import json

import rospy
from std_srvs.srv import Trigger, TriggerResponse


class DescribeService:
    """Answers std_srvs/Trigger with what is in the world.

    Args:
        jobs: JobQueue of the simulation thread.
        world: of the core.
        robots: Robots.
    """

    def __init__(self, jobs, world, robots):
        self._jobs, self._world, self._robots = jobs, world, robots
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
            "models": [self._model(model) for model in self._world.models.values()],
        }

    def _model(self, model):
        outputs, control = self._robots.parts(model.name)
        return {
            "name": model.name,
            "static": model.is_static,
            "control_namespace": None if control is None else control.namespace,
            "sensors": [
                {
                    "topic": output.spec.topic,
                    "type": output.message._type,
                    "rate": getattr(output.spec, "rate", 0.0) or 1.0 / self._world.time_step,
                    "link": output.spec.link,
                }
                for output in outputs
                if output.reports
            ],
            "warnings": list(model.description.warnings),
        }
