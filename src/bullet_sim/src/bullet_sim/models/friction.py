"""Coulomb friction of pairs as Gazebo (ODE) has it: the smaller coefficient of both, along each of
two directions.

Bullet multiplies the coefficients of the two bodies. So what never moves gets 1, and a moving link
gets what its pair with the immobile ones comes to. Where that differs from one of these to the
next, and where moving links touch each other, it follows what the link touches just now.
"""

import numpy as np

from bullet_sim.pose import matrix_from_quaternion

DEFAULT = 1.0  # coefficient where a file gives none, as in Gazebo
# First direction where no fdir1 is given: what ODE makes of a normal that points upwards.
_ACROSS = (0.0, 1.0, 0.0)


class Friction:
    """Coefficients of all links of a world.

    Args:
        engine: the Engine.
    """

    def __init__(self, engine):
        self._engine = engine
        self._given = {}  # (body, link) -> (mu1, mu2), of all links with collisions
        self._axis = {}  # (body, link) -> principal axis of the first direction, of moving links
        self._fixed = set()  # bodies that never move
        self._updated = {}  # (body, link) -> (pair, factor) that update() has set
        self.watched = ()  # bodies whose links follow what they touch

    def assign(self, models):
        """Give every link its coefficient; call it when models came or went.

        Args:
            models: of the world.
        """
        self._given, self._axis, self._fixed, self._updated = {}, {}, set(), {}
        models = list(models)
        ghosts = {model.body for model in models if model.is_ghost}
        for model in models:
            self._read(model)
        grounds = self._grounds()
        uneven = set()
        for (body, link), mine in self._given.items():
            if body in self._fixed:
                self._engine.set_friction(body, link, 1.0)
                continue
            pairs = {_pair(mine, ground) for ground in grounds} or {mine}
            if len(pairs) > 1:
                uneven.add(body)
            self._set(body, link, min(pairs), 1.0)
        moving = {body for body, _ in self._given} - self._fixed - ghosts
        if len(moving) > 1:  # they may touch each other; a product with 1 is right as it is
            uneven |= {body for (body, _), mu in self._given.items() if mu != (1.0, 1.0)} & moving
        self.watched = tuple(sorted(uneven))

    def _grounds(self):
        return {mu for (body, _), mu in self._given.items() if body in self._fixed}

    def _read(self, model):
        immobile = model.is_static
        if immobile:
            self._fixed.add(model.body)
        for name, link in model.rigid_parts.items():
            surface, index = link.surface, model.index(name)
            first = DEFAULT if surface.friction is None else surface.friction
            second = first if surface.friction2 is None else surface.friction2
            self._given[model.body, index] = first, second
            if first != second and not immobile:
                self._axis[model.body, index] = self._principal(model.body, index, surface)

    def _principal(self, body, link, surface):
        """Number of the principal axis that is nearest to the first direction of friction."""
        state = self._engine.link_state(body, link)
        turn = matrix_from_quaternion(self._engine.principal_axes(body, link))
        direction = surface.direction
        if direction is None:
            direction = matrix_from_quaternion(state[1]).T @ np.array(_ACROSS)
        return int(np.argmax(np.abs(turn.T @ np.asarray(direction))))

    def _set(self, body, link, pair, other):
        """Set a coefficient such that times `other` it is that of a pair."""
        first, second = pair
        most = max(first, second)
        scale = None
        axis = self._axis.get((body, link))
        if axis is not None and first != second:
            scale = [second / most] * 3
            scale[axis] = first / most
        else:
            most = min(first, second)
        self._engine.set_friction(body, link, most / other if other > 0.0 else 0.0, scale)

    def restart(self):
        """Set the coefficients that links have before they touch anything."""
        for body, link in self._updated:
            pairs = {_pair(self._given[body, link], ground) for ground in self._grounds()}
            self._set(body, link, min(pairs, default=self._given[body, link]), 1.0)
        self._updated = {}

    def resume(self):
        """Set the coefficients of `_updated`, which was restored."""
        for (body, link), wanted in self._updated.items():
            self._set(body, link, *wanted)

    def update(self):
        """Fit the watched links to what each presses on hardest."""
        partners = {}  # (body, link) -> (force, (body, link) of the other)
        for body in self.watched:
            for link, other, other_link, force in self._engine.touching(body):
                if force > partners.get((body, link), (0.0,))[0] and (
                    {(body, link), (other, other_link)} <= self._given.keys()
                ):
                    partners[body, link] = force, (other, other_link)
        for mine, (_, other) in partners.items():
            factor = 1.0
            if other[0] not in self._fixed:
                if partners.get(other, (0.0, None))[1] == mine and mine < other:
                    continue  # of two that press on each other one is left as it is
                factor = self._engine.friction(*other)
            wanted = _pair(self._given[mine], self._given[other]), factor
            if wanted != self._updated.get(mine):
                self._updated[mine] = wanted
                self._set(*mine, *wanted)


def _pair(mine, other):
    """Coefficients of a pair along both directions."""
    return min(mine[0], other[0]), min(mine[1], other[1])
