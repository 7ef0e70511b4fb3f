"""Links without gravity: an upward force balances their weight in every step."""

from bullet_sim.pose import Pose


class Weight:
    """Upward forces on links without gravity.

    Args:
        engine: the Engine.
    """

    def __init__(self, engine):
        self._engine = engine
        self._links = []  # (model, link name, mass [kg], centre (3,) in the link's frame)

    def assign(self, models):
        """Find the links of all models."""
        self._links = [
            (model, link.name, link.mass, link.centre)
            for model in models
            if not model.is_static
            for link in model.description.links.values()
            if not link.gravity and link.mass > 0.0
        ]

    @property
    def active(self):
        """Whether there are such links."""
        return bool(self._links)

    def apply(self):
        """Apply the forces for the next step."""
        gravity = self._engine.gravity
        for model, name, mass, centre in self._links:
            index, offset = model.link_in_body(name)
            position, orientation, _, _ = self._engine.link_motion(model.body, index)
            frame = Pose(position, orientation) * offset
            point = tuple(frame.position + frame.matrix @ centre)
            self._engine.apply_force(model.body, index, tuple(-mass * g for g in gravity), point)
