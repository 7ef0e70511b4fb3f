"""Links that the file takes from gravity: their weight is lifted in every step."""

from bullet_sim.pose import Pose


class Weight:
    """Lifts what gravity is not to pull.

    Args:
        engine: the Engine.
    """

    def __init__(self, engine):
        self._engine = engine
        self._lifted = []  # (model, link name, mass [kg], centre (3,) in the link's frame)

    def assign(self, models):
        """Find the links of all models."""
        self._lifted = [
            (model, link.name, link.mass, link.centre)
            for model in models
            if not model.is_static
            for link in model.description.links.values()
            if not link.gravity and link.mass > 0.0
        ]

    @property
    def active(self):
        """Whether there are such links."""
        return bool(self._lifted)

    def lift(self):
        """Act on the coming step."""
        gravity = self._engine.gravity
        for model, name, mass, centre in self._lifted:
            index, offset = model.carrier(name)
            position, orientation, _, _ = self._engine.link_motion(model.body, index)
            frame = Pose(position, orientation) * offset
            point = tuple(frame.position + frame.matrix @ centre)
            self._engine.push_at(model.body, index, tuple(-mass * g for g in gravity), point)
