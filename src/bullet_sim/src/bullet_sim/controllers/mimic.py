"""Joints that follow others: <mimic> of a URDF and roboticsgroup's mimic joint plugin."""

import math

_SHARE = 0.5  # of the remaining error that one step takes away at most ...
_BRAKE = 0.5  # ... and of the effort that is counted on to brake in time


class Mimics:
    """Drives the following joints of one model before each step.

    As the plugin, they follow and do not push back. Where the plugin puts the joint, here its motor
    moves it with at most its effort.

    Args:
        joints: bullet_sim.models.joints.Joints.
        rows: Mimics of the description by the name of the joint that follows.
        inertias: joint name -> inertia that its effort moves [kg m^2, kg].
    """

    def __init__(self, joints, rows, inertias):
        self._joints = joints
        known = set(joints.names)
        self._rows = []
        for name, mimic in rows.items():
            if name in known and mimic.joint in known:
                effort = joints.greatest_effort(name)
                effort = effort if mimic.max_effort is None else mimic.max_effort
                self._rows.append((name, mimic, effort, _BRAKE * effort / inertias[name]))

    def __bool__(self):
        return bool(self._rows)

    def update(self, period):
        """Drive the joints for a step of this length [s]."""
        positions, velocities = self._joints.state()
        for name, mimic, effort, braking in self._rows:
            limits = self._joints.limits[name]
            target = positions[mimic.joint] * mimic.multiplier + mimic.offset
            if limits.lower is not None:
                target = min(max(target, limits.lower), limits.upper)
            error, speed = target - positions[name], 0.0
            if abs(error) >= mimic.sensitiveness:
                close = min(_SHARE * abs(error) / period, math.sqrt(2.0 * braking * abs(error)))
                speed = velocities[mimic.joint] * mimic.multiplier + math.copysign(close, error)
            self._joints.drive_within(name, speed, effort)
