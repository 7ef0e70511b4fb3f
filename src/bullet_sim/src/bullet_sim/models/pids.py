"""PIDs of all robots, computed by the solver, so that several steps are one call."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from bullet_sim.controllers.law import JointPid

if TYPE_CHECKING:
    from bullet_sim.controllers.manager import Manager
    from bullet_sim.controllers.pid import Pid
    from bullet_sim.engine import Engine
    from bullet_sim.models.joints import Joints
    from bullet_sim.models.model import Model


class PidSteps:
    """Makes steps in which nothing but PIDs has to be computed before each.

    Args:
        models: those with controllers that have to be updated before each step.
        time_step: [s].

    Attributes:
        is_possible: whether PIDs are all that has to be computed, until a command comes.
    """

    def __init__(self, models: "Iterable[Model]", time_step: float) -> None:
        self._time_step = time_step
        self._robots: list[tuple[Manager, Joints]] = []
        self._pids: list[JointPid] = []
        self._sources: list[tuple[Manager, str, Pid | None]] = []  # of each
        self.is_possible = all(self._add(model) for model in models)

    def _add(self, model: "Model") -> bool:
        manager = model.manager
        assert manager is not None
        hardware, joints = manager.hardware, model.joints
        controllers = manager.pids_of_each_step(self._time_step)
        if controllers is None or hardware.joints is not joints:
            return False
        self._robots.append((manager, joints))
        sources = [(pid, pid.target, False) for each in controllers for pid in each.pids]
        sources += [(pid, target, True) for pid, target in hardware.followed()]
        for pid, target, has_gains in sources:
            name, limit = pid.joint.name, pid.joint.limits.effort or math.inf
            bounds = (limit, -math.inf, math.inf, math.inf)  # as Hardware.write()
            if not has_gains:
                bounds = joints.bounds(name)
            self._pids.append(pid.joint_pid(model.body, joints.index(name), target, bounds))
            self._sources.append((manager, name, pid))
        names = {pid.joint.name for pid, _, _ in sources}
        for name in [name for name in hardware.efforts if name not in names]:
            alone = JointPid(
                model.body, joints.index(name), "", 0.0, (math.nan, math.nan, False),
                (0.0, 0.0, 0.0, 0.0, 0.0, False), joints.bounds(name),
            )  # fmt: skip
            alone.state[6] = hardware.efforts[name]
            self._pids.append(alone)
            self._sources.append((manager, name, None))
        return True

    def step(self, engine: "Engine", count: int) -> None:
        """Advance an engine with the solver 'ode' by `count` time steps."""
        solver = engine.ode
        assert solver is not None
        with solver.pids(self._pids):
            solver.step(count - 1)
            for manager, _ in self._robots:
                manager.hardware.read()  # as before the last of the steps
            solver.step(1)
        applied: dict[Manager, dict[str, float]] = {}
        for row, (manager, name, pid) in zip(self._pids, self._sources):
            if pid is not None:
                pid.note(row)
                manager.hardware.efforts[name] = pid.output
            applied.setdefault(manager, {})[name] = row.state[7]
        for manager, joints in self._robots:
            joints.note_efforts(applied.get(manager, {}))
            manager.note_steps(count, self._time_step)
