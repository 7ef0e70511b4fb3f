"""Commands a joint's effort by a PID, as it is or, where its gains are stiff, by a servo."""

import math

from bullet_sim.controllers.pid.servo import SERVOS, is_stiff


class Regulator:
    """Regulates joints of one robot.

    Args:
        joints: bullet_sim.models.joints.Joints.
        inertias: mapping joint name -> inertia that its effort moves, see description.inertias;
            joints that are not in it get their PIDs' efforts as they are.

    Attributes:
        joints: as above; may be replaced.
        tracked: joints with stiff gains -> (velocity [rad/s, m/s], effort [N m, N]) to track.
        servos: of stiff joints.
    """

    def __init__(self, joints, inertias):
        self.joints, self._inertias = joints, inertias
        self.tracked, self.servos = {}, {}
        self._stiff = {}  # joint -> (gains, goal, period, whether they are stiff)

    def regulate(
        self,
        efforts,
        name,
        pid,
        goal,
        error,
        velocity,
        period,
        moving=None,
        extra=0.0,
        limit=math.inf,
    ):
        """As Hardware.regulate; efforts: mapping that takes the effort of gains that are not stiff.

        Only gains that are stiff for the joint's inertia are left to a servo, whose target goes
        into `tracked`.
        """
        gains, known = pid.gains, self._stiff.get(name)
        if known is None or known[0] is not gains or known[1] != goal or known[2] != period:
            inertia = self._inertias.get(name)
            stiff = inertia is not None and is_stiff(gains, goal, inertia, period)
            known = self._stiff[name] = gains, goal, period, stiff
        if not known[3]:
            if name in self.tracked:
                del self.tracked[name]
                self.joints.release([name])
            rate = None if moving is None else moving - velocity
            efforts[name] = min(max(pid.compute(error, period, rate) + extra, -limit), limit)
            return
        servo = self.servos.get(name)
        if servo is None or servo.goal != goal or name not in self.tracked:
            servo = self.servos[name] = SERVOS[goal](self._inertias[name])
        own = velocity if moving is None else velocity - moving  # as seen from the goal
        pid.compute(error, period, -own if goal == "position" else 0.0)
        if name in efforts:
            del efforts[name]
        speed, effort = servo.target(gains, error, own, pid.terms[1] + extra, period)
        if moving is not None:
            speed += moving
        self.tracked[name] = speed, effort if effort < limit else limit
