"""Wrenches on links and efforts on joints that act for some simulated time."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bullet_sim.errors import CommandError


def span(step_count, time_step, start, duration):
    """Physics steps during which something acts.

    Args:
        step_count: steps made so far.
        time_step: [s].
        start: simulated time [s]; what is past means now.
        duration: [s]; negative: without end; shorter than a step: one step; 0: not at all.

    Returns:
        (first, end): it acts before the steps first <= number < end; end may be infinite.

    Raises:
        CommandError: a number is NaN or infinite.
    """
    for name, value in (("start_time", start), ("duration", duration)):
        if not math.isfinite(value):
            raise CommandError(f"{name} is {value} s, must be finite")
    first = max(step_count, math.ceil(start / time_step - 1e-6))
    if duration < 0:
        return first, math.inf
    return first, first + (max(1, round(duration / time_step)) if duration > 0 else 0)


@dataclass(frozen=True)
class _Job:
    model: object
    part: str  # name of the link or joint
    kind: str  # 'link' or 'joint'
    first: int
    end: float
    act: Callable[[], None]


class Forces:
    """What pushes from outside, applied before every physics step; several add up."""

    def __init__(self):
        self._jobs = []

    @property
    def active(self):
        """Whether something acts now or later."""
        return bool(self._jobs)

    def push(self, model, link, force, torque, steps):
        """Let a force act at the centre of mass of a link's rigid part, and a torque.

        Args:
            model: of the world.
            link: link name.
            force, torque: (3,) [N], [N m] along world axes; they keep their direction.
            steps: as span gives it.

        Raises:
            SimError: no such link, a static model, a number that is NaN or infinite.
        """
        self._check(model, f"wrench on link '{link}'", (*force, *torque))
        index, _ = model.carrier(link)
        force, torque = np.asarray(force, float), np.asarray(torque, float)
        self._add(model, link, "link", steps, lambda: model.push(index, force, torque))

    def drive(self, model, joint, effort, steps):
        """Let an effort [N m, N] act on a joint, beside whatever drives it; clipped to its limit.

        Returns:
            The effort that acts.

        Raises:
            SimError: as for push.
        """
        self._check(model, f"effort on joint '{joint}'", (effort,))
        effort = model.joints.clip_effort(joint, effort)
        self._add(model, joint, "joint", steps, lambda: model.joints.add_effort(joint, effort))
        return effort

    def _add(self, model, part, kind, steps, act):
        if steps[1] > steps[0]:
            self._jobs.append(_Job(model, part, kind, *steps, act))

    @staticmethod
    def _check(model, what, values):
        for value in values:
            if not math.isfinite(value):
                raise CommandError(f"{what} of '{model.name}' has {value}, must be finite")
        if model.is_static:
            raise CommandError(f"{what} of '{model.name}' has no effect: the model is static")

    def apply(self, step):
        """Act on the coming physics step, whose number is that of the steps made so far."""
        for job in self._jobs:
            if job.first <= step < job.end:
                job.act()
        self._jobs = [job for job in self._jobs if job.end > step + 1]

    def clear_link(self, model, link):
        """End all wrenches on a link; returns how many there were."""
        return self._drop(lambda job: (job.model, job.kind, job.part) == (model, "link", link))

    def clear_joint(self, model, joint):
        """End all efforts on a joint; returns how many there were."""
        return self._drop(lambda job: (job.model, job.kind, job.part) == (model, "joint", joint))

    def forget(self, model):
        """End everything that acts on a model."""
        return self._drop(lambda job: job.model is model)

    def clear(self):
        """End everything."""
        self._jobs = []

    def _drop(self, fits):
        kept = [job for job in self._jobs if not fits(job)]
        count = len(self._jobs) - len(kept)
        self._jobs = kept
        return count
