"""The services save_state and restore_state: the simulation goes on from where it was."""

import rospy
from bullet_sim.errors import WorldError

from bullet_bridge.services.handlers import service_handler
from bullet_bridge.srv import State, StateResponse


class StateServices:
    """Keeps states by their names, in memory.

    Args:
        prefix: of the service names.
        jobs: JobQueue of the simulation thread.
        server: Server.
    """

    def __init__(self, prefix, jobs, server):
        self._jobs, self._server, self._states = jobs, server, {}
        for name, work in (("save_state", self.save), ("restore_state", self.restore)):
            rospy.Service(f"{prefix}/{name}", State, service_handler(work, State))

    def save(self, request):
        """Save a state; one of the same name is replaced."""
        name = request.name
        if not name:
            raise WorldError("a state needs a name, this one is empty")

        def work():
            self._states[name] = self._server.save_state()
            return self._server.time

        time = self._jobs.call(work)
        return StateResponse(status_message=f"saved '{name}' at {time:.3f} s")

    def restore(self, request):
        """Restore a state."""

        def work():
            return self._server.restore_state(self._get(request.name)), self._server.time

        note, time = self._jobs.call(work)
        return StateResponse(
            status_message=f"restored '{request.name}', it is {time:.3f} s" + (note and f"; {note}")
        )

    def _get(self, name):
        if name not in self._states:
            raise WorldError(
                f"state '{name}' does not exist; saved are {', '.join(self._states) or '(none)'}"
            )
        return self._states[name]
