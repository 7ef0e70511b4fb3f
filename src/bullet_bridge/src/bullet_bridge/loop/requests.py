"""Steps on request, while the simulation is paused (simulation thread)."""

import threading

from bullet_sim.errors import WorldError


class Steps:
    """Steps requested by a caller that waits for them.

    Attributes:
        left: steps to go.
        done: set when they are made or aborted.
        error: why they were aborted or are incomplete, or ''.
    """

    def __init__(self, count):
        self.left, self.error, self.done = count, "", threading.Event()


class StepRequests:
    """The request that is being served.

    Args:
        world: of the core.
        robots: Robots, whose failures to publish are reported.
        before_done: called when steps have ended, before their caller goes on.

    Attributes:
        steps: Steps, or None.
    """

    def __init__(self, world, robots, before_done):
        self._world, self._robots, self._before_done = world, robots, before_done
        self.steps = None

    def begin(self, count):
        """Take a request for so many steps.

        Returns:
            Steps.

        Raises:
            WorldError: steps are being made already.
        """
        if self.steps is not None:
            raise WorldError(f"{self.steps.left} steps of another call are still to be made")
        self._robots.take_failures()
        self.steps = Steps(count)
        return self.steps

    def make(self, advance, most):
        """Make steps of the request, and end it after its last one.

        Args:
            advance: Server.advance.
            most: steps at a time.
        """
        steps, before = self.steps, self._world.step_count
        advance(min(steps.left, most))
        steps.left -= self._world.step_count - before
        if steps.left <= 0:
            self.end("; ".join(self._robots.take_failures()))

    def end(self, error):
        """End the request, if there is one; error: why it is incomplete, or ''."""
        steps, self.steps = self.steps, None
        if steps is not None:
            self._before_done()
            steps.error = error
            steps.done.set()
