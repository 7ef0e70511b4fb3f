"""Models whose links fixed joints hold in the world, as bodies on joints or as parts of it."""

from __future__ import annotations

from dataclasses import replace

from bullet_sim.description.model import WORLD_LINK, Joint, Link, ModelDescription, fixed_joint
from bullet_sim.pose import Pose


def on_joints(model: ModelDescription, order: list[Joint]) -> ModelDescription:
    """A model whose links that are held in the world are bodies on joints, as in Gazebo.

    A root link `world` with a URDF's fixed joints is the world itself, and no link of the model
    unless other joints move against it. What has no mass, which could not hold anything, stays a
    part of the world.

    Args:
        order: of its joints, from the root, as Gazebo creates them.
    """
    fixed = [joint for joint in order if joint.parent == WORLD_LINK and joint.kind == "fixed"]
    held = [joint.child for joint in model.joints.values() if joint.holds]
    fixed = fixed if model.root == WORLD_LINK else []
    if not all(_mass_on(model, name) > 0.0 for name in (*held, *(j.child for j in fixed))):
        return in_world(model)
    if not fixed:
        return replace(model, fixed_base=model.fixed_base and model.root == WORLD_LINK)
    names = [WORLD_LINK, *(joint.child for joint in order)]
    names += [name for name in model.links if name not in names]
    joints, loose = dict(model.joints), dict(model.loose)
    for joint in fixed:
        joints[joint.name] = replace(joint, closes=True)
        loose[joint.child] = model.root_pose * joint.origin
    root, pose = model.root, model.root_pose
    is_base = len(model.joints_of(WORLD_LINK)) > len(fixed)
    if not is_base:
        root = fixed[0].child
        pose = loose.pop(root)
        names.remove(WORLD_LINK)
    links = {name: model.links[name] for name in names}
    return replace(
        model,
        links=links,
        joints=joints,
        loose=loose,
        root=root,
        root_pose=pose,
        fixed_base=is_base,
    )


def in_world(model: ModelDescription) -> ModelDescription:
    """A model whose links that are held in the world are parts of it, which never move.

    The root is the first of them that is no joint's child, or the world where all are some.
    """
    held = [joint for joint in model.joints.values() if joint.holds]
    if not held:
        return model
    joints = {name: joint for name, joint in model.joints.items() if joint not in held}
    links, loose, poses = dict(model.links), dict(model.loose), model.poses()
    above, children = model.above(), dict.fromkeys(joint.child for joint in held)
    free = [name for name in links if name in children and name not in above]
    root = model.root
    if root != WORLD_LINK:
        loose = {root: model.root_pose, **loose}
        root = free[0] if free else WORLD_LINK
        links.setdefault(root, Link(root))
        poses.setdefault(root, Pose())
        loose.pop(root, None)
    for name in free:
        if name != root:
            joint = fixed_joint(root, poses[root], name, poses[name])
            joints[joint.name] = joint
            loose.pop(name, None)
    for name in (name for name in children if name in above):
        joint = fixed_joint(root, poses[root], name, poses[name])
        joints[joint.name] = replace(joint, closes=True)
    return replace(
        model, links=links, joints=joints, loose=loose, root=root, root_pose=poses[root],
        fixed_base=True,
    )  # fmt: skip


def _mass_on(model: ModelDescription, link: str) -> float:
    """Mass [kg] of a link and of all that fixed joints merge into it."""
    return model.links[link].mass + sum(
        _mass_on(model, joint.child)
        for joint in model.joints_of(link)
        if joint.kind == "fixed" and model.is_urdf
    )
