"""The service ~statistics: lateness and real time factor of the loop, as JSON."""

import json

import rospy
from std_srvs.srv import Trigger, TriggerResponse


class StatisticsService:
    """Answers std_srvs/Trigger with the result of Server.statistics.

    Args:
        jobs: JobQueue of the simulation thread.
        server: Server.
    """

    def __init__(self, jobs, server):
        self._jobs, self._server = jobs, server
        self._service = rospy.Service("~statistics", Trigger, self.handle)

    def handle(self, _):
        """Answer a request."""
        try:
            values = self._jobs.call(self._server.statistics)
        except TimeoutError as error:
            return TriggerResponse(False, str(error))
        return TriggerResponse(True, json.dumps(values))
