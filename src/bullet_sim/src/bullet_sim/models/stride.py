"""Several steps in one call of the solver 'ode', before which nothing but PIDs is computed."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from bullet_sim.controllers.base import ENDLESS
from bullet_sim.controllers.law import JointPid

if TYPE_CHECKING:
    from bullet_sim.controllers.hardware import Hardware
    from bullet_sim.controllers.manager import Manager
    from bullet_sim.controllers.pid import Pid
    from bullet_sim.engine import Engine
    from bullet_sim.models.joints import Joints
    from bullet_sim.models.model import Model

_NO_LIMITS, _NO_GAINS = (math.nan, math.nan, False), (0.0, 0.0, 0.0, 0.0, 0.0, False)


class Stride:
    """Steps of robots whose controllers command nothing new but efforts of PIDs.

    Args:
        models: those with controllers that have to be updated before each step.
        time_step: [s].

    Attributes:
        most: how many steps may be made before controllers have to be updated; 0: they have to be
            now.
    """

    def __init__(self, models: "Sequence[Model]", time_step: float) -> None:
        self._time_step, self.most = time_step, ENDLESS
        self._robots: list[tuple[Model, Manager]] = []
        self._pids: list[JointPid] = []
        self._sources: list[tuple[Hardware, Joints, str, Pid | None]] = []  # of each
        for model in models:
            manager = model.manager
            assert manager is not None
            is_own = manager.hardware.joints is model.joints  # not those of steer_bot
            self.most = min(self.most, manager.steady_steps(time_step) if is_own else 0)
            if self.most == 0:
                return
            self._robots.append((model, manager))

    def _list_pids(self, model: "Model", manager: "Manager") -> None:
        hardware, joints, found = manager.hardware, model.joints, []
        for controller in manager.steady:
            found += [(pid, pid.target, joints.bounds(pid.joint.name)) for pid in controller.pids]
        for pid, target in hardware.followed():
            limit = pid.joint.limits.effort or math.inf
            found.append((pid, target, (limit, -math.inf, math.inf, math.inf)))  # as write() there
        for pid, target, bounds in found:
            row = pid.joint_pid(model.body, joints.index(pid.joint.name), target, bounds)
            self._pids.append(row)
            self._sources.append((hardware, joints, pid.joint.name, pid))
        regulated = {pid.joint.name for pid, _, _ in found}
        for name, effort in hardware.efforts.items():
            if name not in regulated:
                limits = _NO_LIMITS, _NO_GAINS, joints.bounds(name)
                state = [math.nan, *[0.0] * 5, effort, 0.0]
                self._pids.append(JointPid(model.body, joints.index(name), "", 0.0, *limits, state))
                self._sources.append((hardware, joints, name, None))

    def make(self, engine: "Engine", count: int) -> None:
        """Make steps, at most `most`."""
        for model, manager in self._robots:
            self._list_pids(model, manager)
        noted = any(not each.pids for _, manager in self._robots for each in manager.steady)
        with engine.controlled(self._pids, noted):
            engine.step(count - 1)
            for _, manager in self._robots:
                manager.hardware.read()  # as before the last of the steps
            engine.step(1)
        for row, (hardware, joints, name, pid) in zip(self._pids, self._sources):
            if pid is not None:
                pid.note(row)
                hardware.efforts[name] = pid.output
            joints.note_effort(name, row.applied)
        for model, manager in self._robots:
            positions: list[Sequence[Sequence[float]]] = []
            for controller in manager.steady:
                order = map(model.joints.index, controller.config.joints)
                positions.append(() if controller.pids else engine.noted(model.body, order, count))
            manager.catch_up(count, self._time_step, positions)
