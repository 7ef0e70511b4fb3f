"""Motors of joints in the engine 'ode': the numbers of their rows."""

from __future__ import annotations

import math

import numpy as np

from bullet_sim.description.model import Joint
from bullet_sim.engine.ode.owner import JointsOwner, Owner
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.pose import Array, matrix_from_quaternion

# Parameters of joints by ODE's names -> column of their rows, attribute of Joint.
_PARAMETERS = {
    "erp": (q.ERP, "erp"),
    "cfm": (q.CFM, "cfm"),
    "stop_erp": (q.STOP_ERP, "stop_erp"),
    "stop_cfm": (q.STOP_CFM, "stop_cfm"),
    "fudge_factor": (q.STOP_PUSH, "stop_push"),
    "fmax": (q.FMAX, "friction"),
    "vel": (q.SPEED, ""),
}


class OdeMotor:
    """See api.Motor. A command of another kind takes the last one's place, as do its numbers.

    Args:
        number: of the joint among those of its body.

    Attributes:
        row: of the joint, in the arrays as they were built last.
        joint: of the description; its limits and friction may change.
        applied: see api.Motor.
    """

    def __init__(self, engine: Owner, body: JointsOwner, number: int) -> None:
        self._engine, self._body, self._number = engine, body, number
        self.row = -1
        self.joint: Joint = next(joint for joint in body.tree if joint.name == body.joints[number])
        self.applied: float | None = None

    def _numbers(self) -> Array:
        """Its row; the arrays are built first where they have to be."""
        self._engine.build()
        numbers: Array = self._engine.joint_rows[self.row]
        return numbers

    def track_velocity(self, velocity: float, effort: float) -> None:
        """See api.Motor."""
        self.applied = None
        self._engine.build()
        numbers, row = self._engine.joint_numbers, q.J_SIZE * self.row
        numbers[row + q.SPEED], numbers[row + q.FMAX] = velocity, effort
        numbers[row + q.TARGET] = numbers[row + q.IMPOSED] = math.nan

    def track_position(self, position: float, effort: float, speed: float) -> None:
        """See api.Motor."""
        self.applied = None
        row = self._numbers()
        if math.isnan(row[q.TARGET]):
            row[q.REACHED] = row[q.ANGLE]
        row[q.SPEED], row[q.FMAX] = 0.0, effort
        row[q.TARGET], row[q.MAX_SPEED], row[q.IMPOSED] = position, speed, math.nan

    def impose_velocity(self, velocity: float, effort: float) -> None:
        """See api.Motor."""
        self.release()
        self._numbers()[q.IMPOSED] = velocity

    def impose_position(self, position: float, effort: float, speed: float) -> None:
        """See api.Motor."""
        self.track_position(position, self.joint.friction, math.inf)

    def release(self) -> None:
        """See api.Motor."""
        self.applied = None
        if self._body.has_rows():  # else it is released as it is added
            row = self._engine.joint_rows[self.row]
            row[q.SPEED], row[q.TARGET], row[q.IMPOSED] = 0.0, math.nan, math.nan
            row[q.FMAX] = self.joint.friction

    def add_effort(self, effort: float) -> None:
        """See api.Motor."""
        self._engine.build()
        self._engine.joint_numbers[q.J_SIZE * self.row + q.EFFORT] += effort

    def set_position(self, position: float) -> None:
        """See api.Motor."""
        self._body.place().joints[self._number] = float(position), 0.0

    def set_limits(self, lower: float, upper: float) -> None:
        """See api.Motor."""
        row = self._numbers()
        row[q.LOWER], row[q.UPPER] = lower, upper
        self.joint.lower, self.joint.upper = lower, upper

    def set_damping(self, damping: float) -> None:
        """See api.Motor."""
        self._numbers()[q.DAMPING] = damping

    def set_parameter(self, name: str, value: float) -> bool:
        """See api.Motor."""
        column, attribute = _PARAMETERS[name]
        self._numbers()[column] = value
        if attribute:
            setattr(self.joint, attribute, value)
        return True

    def measure_load(self) -> None:
        """See api.Motor: all joints are measured."""

    def load(self) -> tuple[Array, Array, float]:
        """See api.Motor."""
        self._engine.refresh()
        numbers = self._engine.joint_rows[self.row]
        child = self._engine.arrays.state.system.types[self.row, 1]
        turn = matrix_from_quaternion(self._engine.rows[child, q.QUAT : q.QUAT + 4]).T
        force = turn @ numbers[q.WRENCH : q.WRENCH + 3]
        torque = turn @ numbers[q.WRENCH + 3 : q.WRENCH + 6]
        center = self._body.link(child).center
        return force, torque + np.cross(center, force), numbers[q.MOTOR]
