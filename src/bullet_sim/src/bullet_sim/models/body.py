"""Loads a prepared model into the engine as one body, with what its URDF cannot say."""

from bullet_sim.description.parts import EVERYTHING
from bullet_sim.models.joints import UNLIMITED_EFFORT, UNLIMITED_SPEED


def load_body(engine, source, pose, lumped, description):
    """Load a body.

    Args:
        engine: the Engine.
        source: BodySource, which names the prepared URDF.
        pose: world Pose of the root link's frame.
        lumped: LumpedModel that the URDF was written from.
        description: its ModelDescription.

    Returns:
        The body's number; its links' numbers by name; those of the child links of measured joints,
        by the joints' names.

    Raises:
        ModelError: PyBullet refuses it.
    """
    apart = [
        name
        for name, link in lumped.links.items()
        if not (link.self_collide or description.self_collide)
    ]
    self_collide = len(lumped.links) - len(apart) > 1
    body = engine.load(
        source.path,
        pose.position,
        pose.orientation,
        source.fixed_base,
        self_collide=self_collide,
        static=description.static,
    )
    links = engine.link_indices(body)
    if self_collide:
        for name in apart:
            for other in lumped.links:
                engine.disable_self_collision(body, links[name], links[other])
    _set_surfaces(engine, body, links, lumped)
    measured = {}
    for joint in (*lumped.joints, *lumped.welds):
        if joint.name in description.measured:
            measured[joint.name] = links[joint.child]
            engine.measure_joint(body, links[joint.child])
    names = engine.joint_names(body)
    for joint in lumped.welds:
        number = names.index(joint.name)
        engine.drive_position(body, number, 0.0, UNLIMITED_EFFORT, UNLIMITED_SPEED)
    return body, links, measured


def _set_surfaces(engine, body, links, lumped):
    for name, link in lumped.links.items():
        surface = link.surface
        engine.set_surface(body, links[name], stiffness=surface.stiffness, damping=surface.damping)
        if surface.bitmask != EVERYTHING:
            engine.set_bitmask(body, links[name], surface.bitmask)
