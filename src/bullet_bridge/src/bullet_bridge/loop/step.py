"""The service ~step, /gazebo/step: physics steps on request."""

import rospy

from bullet_bridge.srv import Step, StepResponse

CHECK_PERIOD = 0.2  # [s] wall time between two checks for a shutdown


class StepService:
    """Waits for commands, makes steps, responds when all due messages are published.

    Args:
        jobs: JobQueue of the simulation thread.
        server: Server.
        arrivals: Arrivals of the command topics.
        timeout: wall time [s] to wait for commands.
    """

    def __init__(self, jobs, server, arrivals, timeout):
        self._jobs, self._server, self._arrivals = jobs, server, arrivals
        self._timeout = timeout
        self._service = rospy.Service("~step", Step, self.handle)

    def handle(self, request):
        """Handle a Step request."""
        try:
            wanted = self._wanted(request)
            self._jobs.call(self._check)
            steps = self._begin(request.n, self._arrivals.take(wanted, self._timeout))
        except (ValueError, TimeoutError) as error:  # SimError is a ValueError
            rospy.logerr("step: %s", error)
            return StepResponse(False, str(error))
        while not steps.done.wait(CHECK_PERIOD):
            if rospy.is_shutdown():
                return StepResponse(False, "the simulation has ended")
        if steps.error:
            rospy.logerr("step: %s", steps.error)
        return StepResponse(not steps.error, steps.error)

    def _begin(self, count, taken):
        """Begin the steps; if that fails, the messages count for the next call."""
        try:
            return self._jobs.call(lambda: self._server.begin_steps(count))
        except (ValueError, TimeoutError):
            self._arrivals.restore(taken)
            raise

    def _check(self):
        if not self._server.paused:
            raise ValueError("the simulation runs; pause it before stepping")

    @staticmethod
    def _wanted(request):
        if request.n < 1:
            raise ValueError("n is 0, must be at least 1 physics step")
        if len(request.topics) != len(request.counts):
            raise ValueError(
                f"{len(request.topics)} topics and {len(request.counts)} counts are "
                "given, must be as many"
            )
        wanted = {}
        for topic, count in zip(request.topics, request.counts):
            if not topic:
                raise ValueError("a topic without a name is given")
            name = rospy.resolve_name("/" + topic.lstrip("/"))
            if name in wanted:
                raise ValueError(f"topic '{name}' is given twice")
            wanted[name] = count
        return wanted
