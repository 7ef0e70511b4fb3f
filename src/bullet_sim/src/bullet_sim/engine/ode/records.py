"""States after each of several steps, and the engine as it was after one of them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from bullet_sim.engine.api import Motor
from bullet_sim.engine.ode.arrays import Arrays
from bullet_sim.engine.ode.owner import Owner
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.pose import Array


class Records:
    """See api.Records.

    Attributes:
        count: of the recorded steps.
        shown: number of the step that is shown; None: none is.
        bodies: (m, n, SR_BODY) of each recorded step and row of bodies.
    """

    def __init__(self, engine: Owner) -> None:
        self._engine = engine
        self._motors: dict[Any, float | None] = {}  # what was applied at the end
        self.count = 0
        self._is_finite: bool | None = None
        self.shown: int | None = None

    def use(self, arrays: Arrays) -> None:
        """Take new arrays."""
        state = arrays.state
        self._system, self._taken = state.system, state.taken
        most, bodies, joints = len(state.states), len(state.system.bodies), len(state.system.joints)
        first, last = bodies * q.SR_BODY, bodies * q.SR_BODY + joints * q.SR_JOINT
        self.bodies = state.states[:, :first].reshape(most, bodies, q.SR_BODY)
        self._joints = state.states[:, first:last].reshape(most, joints, q.SR_JOINT)
        self._applied = state.states[:, last:]
        self._contacts = records = state.contact_records
        room = len(records.bodies) * len(state.contacts.rows)
        self._most = min(most, len(records.chosen) // room) if room else most
        self._acting: dict[Any, None] = {}

    @property
    def most(self) -> int:
        """See api.Records."""
        return self._most

    def begin(self) -> None:
        """See api.Records."""
        self._engine.refresh()
        self._taken[:] = self.most, 0
        self._is_finite = None
        self._acting.clear()

    def note_acting(self, motors: Iterable[Motor]) -> None:
        """Note the motors on which efforts act in the next steps."""
        if self._taken[0]:
            self._acting.update(dict.fromkeys(motors))

    def end(self, count: int) -> None:
        """See api.Records."""
        self._taken[0], self.count = 0, count
        self._motors = {motor: motor.applied for motor in self._acting}

    def show(self, number: int) -> None:
        """See api.Records."""
        self._show(number)
        self.shown = number
        applied = self._applied[number]
        for motor in self._motors:
            value = float(applied[motor.row])
            motor.applied = None if math.isnan(value) else value

    def show_contacts(self, number: int) -> None:
        """See api.Records."""
        self.shown = number

    def show_end(self) -> None:
        """See api.Records."""
        self._show(self.count - 1)
        self.shown = None
        for motor, value in self._motors.items():
            motor.applied = value

    def motions(self, row: int) -> Array | None:
        """Of a row of bodies, after the recorded steps (SR_BODY, k); None: one of all bodies is not
        finite any more."""
        if self._is_finite is None:
            self._is_finite = bool(np.isfinite(self.bodies[: self.count]).all())
        return self.bodies[: self.count, row].T if self._is_finite else None

    def contacts(self, number: int, row: int) -> tuple[Array, Array]:
        """Rows of `chosen` and `numbers` of ContactRecords, of a row of bodies after a recorded
        step."""
        records = self._contacts
        begin, end = records.ends[number - 1] if number else 0, records.ends[number]
        chosen, numbers = records.chosen[begin:end], records.numbers[begin:end]
        if len(records.bodies) > 1:
            is_own = chosen[:, q.CR_BODY] == row
            chosen, numbers = chosen[is_own], numbers[is_own]
        return chosen, numbers

    def _show(self, number: int) -> None:
        system, joints = self._system, self._joints[number]
        system.bodies[:, : q.PLACE] = self.bodies[number][:, : q.PLACE]
        system.joints[:, q.ANGLE : q.RATE + 1] = joints[:, :2]
        system.joints[:, q.MOTOR : q.WRENCH + 6] = joints[:, 2:]
