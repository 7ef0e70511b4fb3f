"""Wrenches on links and efforts on joints that act for some simulated time."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bullet_sim.errors import CommandError


def step_range(step_count, time_step, start, duration):
    """Physics steps during which a wrench or an effort acts.

    Args:
        step_count: steps made so far.
        time_step: [s].
        start: simulated time [s]; a past one means now.
        duration: [s]; negative: without end; shorter than a step: one step; 0: not at all.

    Returns:
        (first, end): it acts in the steps first <= number < end; end may be infinite.

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
class _Load:
    model: object
    part: str  # name of the link or joint
    kind: str  # 'link' or 'joint'
    first: int
    end: float
    apply: Callable[[], None]


class Forces:
    """External wrenches and efforts, applied before every physics step; several add up."""

    def __init__(self):
        self._loads = []

    @property
    def active(self):
        """Whether a wrench or an effort acts now or later."""
        return bool(self._loads)

    def apply_wrench(self, model, link, force, torque, steps):
        """Apply a force at the centre of mass of a link's rigid part, and a torque.

        Args:
            model: of the world.
            link: link name.
            force, torque: (3,) [N], [N m] along world axes; they keep their direction.
            steps: as step_range gives it.

        Raises:
            SimError: no such link, a static model, a number that is NaN or infinite.
        """
        self._check(model, f"wrench on link '{link}'", (*force, *torque))
        index, _ = model.link_in_body(link)
        force, torque = np.asarray(force, float), np.asarray(torque, float)
        self._add(model, link, "link", steps, lambda: model.apply_wrench(index, force, torque))

    def apply_effort(self, model, joint, effort, steps):
        """Apply an effort [N m, N] to a joint in addition to its controller; clipped to its limit.

        Returns:
            The clipped effort.

        Raises:
            SimError: as for apply_wrench.
        """
        self._check(model, f"effort on joint '{joint}'", (effort,))
        effort = model.joints.clip_effort(joint, effort)
        self._add(model, joint, "joint", steps, lambda: model.joints.add_effort(joint, effort))
        return effort

    def _add(self, model, part, kind, steps, apply):
        if steps[1] > steps[0]:
            self._loads.append(_Load(model, part, kind, *steps, apply))

    @staticmethod
    def _check(model, what, values):
        for value in values:
            if not math.isfinite(value):
                raise CommandError(f"{what} of '{model.name}' has {value}, must be finite")
        if model.is_static:
            raise CommandError(f"{what} of '{model.name}' has no effect: the model is static")

    def apply(self, step):
        """Apply all that act in the next physics step; `step` is the number of steps made."""
        for load in self._loads:
            if load.first <= step < load.end:
                load.apply()
        self._loads = [load for load in self._loads if load.end > step + 1]

    def clear_link(self, model, link):
        """End all wrenches on a link; returns how many there were."""
        return self._remove(
            lambda load: (load.model, load.kind, load.part) == (model, "link", link)
        )

    def clear_joint(self, model, joint):
        """End all efforts on a joint; returns how many there were."""
        return self._remove(
            lambda load: (load.model, load.kind, load.part) == (model, "joint", joint)
        )

    def remove_model(self, model):
        """End all wrenches and efforts on a model; returns how many there were."""
        return self._remove(lambda load: load.model is model)

    def clear(self):
        """End all wrenches and efforts."""
        self._loads = []

    def _remove(self, matches):
        others = [load for load in self._loads if not matches(load)]
        count = len(self._loads) - len(others)
        self._loads = others
        return count
