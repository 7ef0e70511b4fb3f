"""How far joints may be from their trajectory."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Tolerance:
    """Bounds of a joint's errors [rad, m, and per s, s^2]; 0: none."""

    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0

    def holds(self, position, velocity):
        """Whether errors of position and velocity are within; accelerations are not measured."""
        return not (abs(position) > self.position > 0.0 or abs(velocity) > self.velocity > 0.0)

    def updated(self, other):
        """With another's bounds: above 0 they replace, below 0 they remove, 0 leaves its own."""
        return Tolerance(
            *(
                theirs if theirs > 0.0 else 0.0 if theirs < 0.0 else own
                for own, theirs in zip(self.values(), other.values())
            )
        )

    def values(self):
        """Position, velocity, acceleration."""
        return self.position, self.velocity, self.acceleration


NO_TOLERANCE = Tolerance()


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of a whole trajectory.

    Attributes:
        path, arrival: a Tolerance of each joint on the way and at the end.
        patience: time after the end to get within `arrival` [s].
    """

    path: tuple[Tolerance, ...]
    arrival: tuple[Tolerance, ...]
    patience: float = 0.0

    def updated(self, joints, path, arrival, patience):
        """With those of a goal.

        Args:
            joints: names, in the controller's order.
            path, arrival: (joint name, Tolerance) pairs.
            patience: above 0 it replaces, below 0 it is 0, 0 leaves its own [s].
        """
        changed = []
        for own, pairs in ((self.path, path), (self.arrival, arrival)):
            mine = dict(zip(joints, own))
            for name, tolerance in pairs:
                if name in mine:
                    mine[name] = mine[name].updated(tolerance)
            changed.append(tuple(mine.values()))
        wait = self.patience if patience == 0 else max(0.0, patience)
        return replace(self, path=changed[0], arrival=changed[1], patience=wait)
