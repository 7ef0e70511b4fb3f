"""Action servers of controllers.

actionlib's server holds a lock while it calls back, and a callback waits for the simulation
thread. So that thread never calls the server: what it has to say goes through a queue to a thread
that does.
"""

import queue
import threading

import actionlib
import rospy
from bullet_sim.errors import ControllerError, SimError

STATUS_PERIOD = 0.2  # [s] of wall time, as actionlib's without its parameter


class _Server(actionlib.ActionServer):
    """A server without a timer of its own: one would die when simulated time jumps back."""

    def initialize(self):
        super().initialize()
        if self.status_timer is not None:
            self.status_timer.shutdown()


class Pursuit:
    """The goal that a controller pursues; for Topics with an action, mixed in before them."""

    def _serve(self, name, action):
        """Start the action of a name in the controller's namespace; _on_goal gets its goals."""
        self._handle = self._goal = None  # of the goal that is pursued
        self._id = None  # asked of a handle, it would wait for the server's lock
        self._action = ActionTopics(f"{self.name}/{name}", action, self._on_goal, self._on_cancel)
        self._endpoints.append(self._action)

    def _check_running(self):
        if not self._robot.manager.is_running(self._spec.name):
            raise ControllerError(f"controller '{self._spec.name}' does not run")

    def _accept(self, handle, name, goal):
        """Accept a goal (simulation thread, while the server waits for it)."""
        self._handle, self._goal, self._id = handle, goal, name
        self._action.say(handle.set_accepted)

    def _on_cancel(self, handle):
        name = handle.get_goal_id().id
        try:
            self._robot.call(lambda: self._cancel(name))
        except (SimError, TimeoutError) as error:
            rospy.logerr("%s: goal cannot be cancelled: %s", self.name, error)

    def _cancel(self, name):
        if name == self._id:
            self.controller.cancel(self._goal)

    def _finish(self, handle, outcome, result):
        """Report the end of a goal (simulation thread)."""
        if handle is self._handle:
            self._handle = self._goal = self._id = None
        finish = {
            "succeeded": handle.set_succeeded,
            "aborted": handle.set_aborted,
            "canceled": handle.set_canceled,
        }[outcome]
        self._action.say(finish, result)


class ActionTopics:
    """The topics of one action.

    Args:
        name: of the action, resolved.
        action: its type.
        on_goal: function of a ServerGoalHandle, which accepts or rejects it.
        on_cancel: function of a ServerGoalHandle.
    """

    def __init__(self, name, action, on_goal, on_cancel):
        self._orders = queue.SimpleQueue()
        self._server = _Server(name, action, on_goal, on_cancel, auto_start=False)
        self._server.start()
        self._thread = threading.Thread(target=self._work, name=f"{name} results", daemon=True)
        self._thread.start()

    def has_subscribers(self):
        """Whether anybody hears feedback."""
        return self._server.feedback_pub.get_num_connections() > 0

    def say(self, call, *arguments):
        """Have a method of a goal handle called soon, in order; returns at once."""
        self._orders.put((call, arguments))

    def _work(self):
        while True:
            try:
                order = self._orders.get(timeout=STATUS_PERIOD)
            except queue.Empty:
                order = self._server.publish_status_async, (None,)
            if order is None:
                return
            call, arguments = order
            try:
                call(*arguments)
            except rospy.ROSException:
                pass  # the topics were just unregistered

    def unregister(self):
        """Say what is left to say, then end the topics."""
        self._orders.put(None)
        if threading.current_thread() is not self._thread:
            self._thread.join(2.0)
        self._server.stop()
