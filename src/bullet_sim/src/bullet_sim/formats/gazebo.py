"""<gazebo> elements of URDF, and contact properties of these and of <surface> of SDF."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from bullet_sim.description.model import (
    EVERYTHING,
    EVERYWHERE,
    Joint,
    Link,
    ModelDescription,
    Shape,
    Surface,
    Torsion,
)
from bullet_sim.description.world import MAX_CONTACTS
from bullet_sim.errors import ModelError
from bullet_sim.formats.lights import parse_light
from bullet_sim.formats.materials import Material, Resolve, material_of, named_material
from bullet_sim.plugins import parse_plugin, parse_sensor
from bullet_sim.plugins.grasping import parse_gripper
from bullet_sim.plugins.xml import merged_links
from bullet_sim.xml_reader import (
    Node,
    child_flag,
    child_number,
    child_text,
    floats,
    is_true,
    number,
)

ENDLESS_FRICTION = 1e6
MAX_STIFFNESS = 1e5  # [N/m] above which Bullet's default hard contacts are used


def read_surface(
    element: Node, surface: Surface, label: str, warn: Callable[[str], None], urdf: bool = False
) -> None:
    """Read the contact properties of an element; what cannot be read stays unchanged.

    Args:
        element: <collision>, or <gazebo> of a URDF.
        surface: changed in place.
    """
    for key, (read, tags, paths) in _PROPERTIES.items():
        if urdf:
            paths = (*tags, f"collision/{paths[0]}")
        for path in paths:  # the first that exists counts
            text = child_text(element, path)
            if text is None:
                continue
            try:
                setattr(surface, key, read(text, f"{label} <{path}>"))
            except ModelError as error:
                warn(f"{error}; it is ignored")
            break
    if surface.direction is not None and not any(surface.direction):
        surface.direction = None
    path = "surface/friction/torsional"
    torsional = element.find(f"collision/{path}" if urdf else path)
    if torsional is not None:
        surface.torsion = _torsion(torsional, f"{label} <torsional>")


def _torsion(element: Node, label: str) -> Torsion:
    coefficient, patch, surface, slip = (
        max(0.0, child_number(element, path, label, default))
        for path, default in (
            ("coefficient", 1.0), ("patch_radius", 0.0), ("surface_radius", 0.0), ("ode/slip", 0.0)
        )
    )  # fmt: skip
    by_patch = child_flag(element, "use_patch_radius", label, True)
    return Torsion(coefficient, patch, surface, by_patch, slip)


def _replace_surface(element: Node, link: Link, label: str, model: ModelDescription) -> None:
    """Forget what earlier <gazebo> elements of a link said, where this one has a <surface>.

    sdformat copies the <surface> in place of the one that it has made of them.
    """
    firsts = [next(iter(block), None) for block in element.findall("collision")]
    if not any(first is not None and first.tag == "surface" for first in firsts):
        return
    if link.surface != Surface(most=link.surface.most):
        model.warn(
            f"{label}: its <surface> replaces all that earlier elements say of friction and "
            "contacts, as in Gazebo",
            "<gazebo> elements of links have a <surface> that replaces all that earlier ones say "
            "of friction and contacts, as in Gazebo",
            label,
        )
    link.surface = Surface(most=link.surface.most)  # which is none of <surface>


def read_stiffness(element: Node, surface: Surface, label: str) -> None:
    """Read <kp> and <kd> of a URDF where they are softer than Bullet's hard contact."""
    stiffness = child_number(element, "kp", label, None)
    if stiffness is not None and 0 < stiffness < MAX_STIFFNESS:
        surface.stiffness = stiffness
        surface.damping = max(0.0, child_number(element, "kd", label, 1.0))


def _not_negative(text: str, label: str) -> float:
    return max(0.0, number(text, label))


def _friction(text: str, label: str) -> float:
    """As FrictionPyramid of Gazebo: a negative coefficient is as good as infinite."""
    value = number(text, label)
    return ENDLESS_FRICTION if value < 0.0 else value


def _whole(text: str, label: str) -> int:
    return int(min(_not_negative(text, label), MAX_CONTACTS))


def _bitmask(text: str, label: str) -> int:
    try:
        value = int(text, 0)
    except ValueError:
        value = -1
    if value < 0:
        raise ModelError(f"{label} is '{text}', must be a whole number such as 0x01")
    return value & EVERYTHING


# property -> its reader, its tags in <gazebo reference=...> of a URDF, its paths in <collision>
_PROPERTIES: dict[str, tuple[Callable[[str, str], Any], tuple[str, ...], tuple[str, ...]]] = {
    "friction": (_friction, ("mu1",), ("surface/friction/ode/mu",)),
    "friction2": (_friction, ("mu2",), ("surface/friction/ode/mu2",)),
    "direction": (
        lambda text, label: floats(text, 3, label),
        ("fdir1",),
        ("surface/friction/ode/fdir1",),
    ),
    "kp": (_not_negative, ("kp",), ("surface/contact/ode/kp",)),
    "kd": (_not_negative, ("kd",), ("surface/contact/ode/kd",)),
    "slip1": (_not_negative, (), ("surface/friction/ode/slip1",)),
    "slip2": (_not_negative, (), ("surface/friction/ode/slip2",)),
    "max_speed": (_not_negative, ("maxVel",), ("surface/contact/ode/max_vel",)),
    "min_depth": (_not_negative, ("minDepth",), ("surface/contact/ode/min_depth",)),
    "bitmask": (
        _bitmask,
        (),
        ("surface/contact/collide_bitmask", "surface/contact/bitmask"),
    ),
    "most": (_whole, ("maxContacts",), ("max_contacts",)),
    "bounce": (_not_negative, (), ("surface/bounce/restitution_coefficient",)),
    "bounce_speed": (number, (), ("surface/bounce/threshold",)),
    "without_contact": (
        lambda text, _: is_true(text),
        (),
        ("surface/contact/collide_without_contact",),
    ),
    "without_contact_bitmask": (
        _bitmask,
        (),
        ("surface/contact/collide_without_contact_bitmask",),
    ),
}


READ = {
    *(tag for _, tags, _ in _PROPERTIES.values() for tag in tags),
    "collide_bitmask",
    "material",
    "selfCollide",
    "self_collide",
    "kinematic",
    "gravity",
    "turnGravityOff",
    "sensor",
    "light",
    "plugin",
    "static",
    "visual",
    "collision",
    "dampingFactor",
    "implicitSpringDamper",
    "cfmDamping",
    "stopCfm",
    "stopErp",
    "fudgeFactor",
    "springStiffness",
    "springReference",
    "laserRetro",
    "preserveFixedJoint",
    "disableFixedJointLumping",
    "allow_auto_disable",
    "velocity_decay",
    "provideFeedback",
    "gripper",
    "joint",
    "enable_wind",
}
# Ignored without a warning; docs/support says of each what it means in Gazebo.
QUIET = {
    "initial_joint_position",
    "stopKp",
    "stopKd",
    "erp",
    "cfm",
    "soft_cfm",
    "soft_erp",
    "slip1",
    "slip2",
}


# Tags that sdformat writes behind one of its own, where the first counts, and what has the effect.
WITHOUT_EFFECT = {
    "gravity": "turnGravityOff",
    "velocity_decay": "dampingFactor",
    "collide_bitmask": "collision><surface><contact><collide_bitmask",
}


def apply(robot: Node, model: ModelDescription, resolve: Resolve) -> None:
    """Read every <gazebo> child of <robot> into the model description.

    Args:
        resolve: of the URIs of scripts.
    """
    _keep_joints(robot, model)
    elements = robot.findall("gazebo")
    for child in (child for element in elements for child in element):
        child.text = child.get("value", child.text)  # which counts before a text, as in sdformat
    _set_flags(elements, model)
    materials: dict[str, Material] = {}
    for element in elements:
        reference = element.get("reference")
        if reference is None:
            _model_flags(element, model)
        elif reference in model.links:
            material = _link_flags(element, model, model.links[reference], resolve)
            if material is not None:
                materials[reference] = material
        elif reference in model.joints:
            _joint_flags(element, model.joints[reference], _label(element))
        else:
            model.warn(
                f"<gazebo reference='{reference}'> refers to no link and no joint; "
                "what it contains is left out",
                "<gazebo> elements refer to no link and no joint; what they contain is left out",
                f"'{reference}'",
            )
        _unknown(element, model, reference)
        _sensors_and_plugins(element, model)
    for element in elements:
        if element.get("reference") is None:  # in a link SDF has none
            for gripper in element.findall("gripper"):
                parse_gripper(gripper, model, "")
    _assign(robot, materials, _retros(robot), model)


def _label(element: Node) -> str:
    return f"<gazebo reference='{element.get('reference') or ''}'>"


def _sensors_and_plugins(element: Node, model: ModelDescription) -> None:
    reference = element.get("reference")
    link = reference if reference is not None else model.root
    for sensor in element.findall("sensor"):
        if link in model.links:
            parse_sensor(sensor, link, model)
            continue
        model.warn(
            f"sensor '{sensor.get('name')}' refers to link '{reference}', "
            "which does not exist; it is left out",
            "sensors refer to a link that does not exist and are left out",
            f"'{sensor.get('name')}'",
        )
    for plugin in element.findall("plugin"):
        parse_plugin(plugin, model)


def _joint_flags(element: Node, joint: Joint, label: str) -> None:
    joint.implicit_damping = is_true(_either(element, "implicitSpringDamper", "cfmDamping"))
    joint.stiffness = child_number(element, "springStiffness", label, joint.stiffness)
    joint.rest = child_number(element, "springReference", label, joint.rest)
    joint.stop_erp = child_number(element, "stopErp", label, joint.stop_erp)
    joint.stop_cfm = child_number(element, "stopCfm", label, joint.stop_cfm)
    joint.stop_push = child_number(element, "fudgeFactor", label, joint.stop_push)


def _keep_joints(robot: Node, model: ModelDescription) -> None:
    """Keep the fixed joints that sdformat is told not to merge: as fixed ones, or, with
    <disableFixedJointLumping> alone, as hinges about z with limits of 0.

    A link without mass is merged nevertheless; sdformat drops it.
    """
    fixed, hinges = set(), set()
    for element in robot.findall("gazebo"):
        name = element.get("reference") or ""
        if is_true(child_text(element, "preserveFixedJoint", "false")):
            fixed.add(name)
        elif is_true(child_text(element, "disableFixedJointLumping", "false")):
            hinges.add(name)
    for name in sorted(fixed | hinges):
        joint = model.joints.get(name)
        if joint is None or joint.kind != "fixed" or joint.parent == "world":
            continue
        if model.links[joint.child].mass <= 0.0:
            model.warn(
                f"joint '{name}' is to be kept, but its link '{joint.child}' has no mass; it is "
                "merged, Gazebo leaves it out",
                "joints are to be kept whose links have no mass; these are merged, Gazebo leaves "
                "them out",
                f"'{name}'",
            )
        elif name in fixed:
            model.kept.add(name)
        else:
            joint.kind, joint.axis, joint.lower, joint.upper = "revolute", (0.0, 0.0, 1.0), 0.0, 0.0


def _merges(joint: Joint, model: ModelDescription) -> bool:
    return joint.kind == "fixed" and joint.name not in model.kept


def _retros(robot: Node) -> dict[str, float]:
    """The last <laserRetro> of each link."""
    retros = {}
    for element in robot.findall("gazebo"):
        label = _label(element)
        retro = child_number(element, "laserRetro", label, None)
        if retro is None:
            retro = child_number(element, "collision/laser_retro", label, None)
        if retro is not None:
            retros[element.get("reference") or ""] = retro
    return retros


def _assign(
    robot: Node, materials: dict[str, Material], retros: dict[str, float], model: ModelDescription
) -> None:
    """Give surfaces and retros to the collisions of links, and materials to their visuals."""
    for name, root in merged_links(robot, model).items():
        link = model.links[name]
        for place, shape in enumerate(link.collisions):
            owner = _owner(shape.name, name, root, "_collision")
            if owner != name:
                surface = model.links[owner].surface if owner else Surface()
                shape = replace(shape, surface=surface)
            if owner in retros:
                shape = replace(shape, laser_retro=retros[owner])
            link.collisions[place] = shape
        for place, shape in enumerate(link.visuals):
            owner = _owner(shape.name, name, root, "_visual")
            material = materials.get(owner)
            if material is not None:
                shape = material.on(shape)
            link.visuals[place] = _seen(shape, robot, owner)


def _seen(shape: Shape, robot: Node, link: str) -> Shape:
    """A visual with what <gazebo><visual> of a link says, besides its material.

    A <pose> and a <geometry> there have no effect, as in Gazebo, where those of the <visual> count.
    """
    for element in robot.findall("gazebo") if link else ():
        visual = element.find("visual")
        if visual is None or element.get("reference") != link:
            continue
        label = f"<gazebo reference='{link}'> <visual>"
        casts = child_flag(visual, "cast_shadows", label, shape.finish.cast_shadows)
        left = 1.0 - min(1.0, max(0.0, child_number(visual, "transparency", label, 0.0)))
        finish = replace(shape.finish, cast_shadows=casts)
        if left < 1.0 and shape.color is None:  # a mesh with materials of its own
            finish = replace(finish, opacity=finish.opacity * left)
        elif left < 1.0 and shape.color is not None:
            red, green, blue, alpha = shape.color
            shape = replace(shape, color=(red, green, blue, alpha * left))
        flags = child_number(visual, "visibility_flags", label, shape.visibility)
        retro = child_number(visual, "laser_retro", label, shape.laser_retro)
        visibility = int(flags) & EVERYWHERE
        shape = replace(shape, finish=finish, visibility=visibility, laser_retro=retro)
    return shape


def _owner(shape: str, link: str, root: str, suffix: str) -> str:
    """Link whose <gazebo> elements hold for a collision or a visual in Gazebo; "": none.

    As sdformat 9 decides by the names that it gives: those of a link hold for a shape that has no
    name, or one that begins with the link's; for a shape of a link that is merged if that has no
    name or the link's. If the name of the merged link begins with that of the link that it is
    merged into, that one's hold.

    Args:
        shape: its name in the file, or what sdformat calls it.
        link: to which it belongs in the file.
        root: into which that is merged.
    """
    name = shape + suffix
    if name.startswith(root):
        return root
    return link if link != root and name.startswith(link + suffix) else ""


def _set_flags(elements: Sequence[Node], model: ModelDescription) -> None:
    """Whether gravity and wind act on links, and their decay.

    All links that fixed joints merge into one have the gravity that the last <gazebo> element says,
    the decay and the wind that the first one says, as in sdformat.
    """
    gravity: dict[str, bool] = {}
    decay: dict[str, float] = {}
    windy: dict[str, bool] = {}
    for element in elements:
        name, label = element.get("reference") or "", _label(element)
        gravity[name] = not is_true(child_text(element, "turnGravityOff", "false"))
        for tag, does in WITHOUT_EFFECT.items():
            if element.find(tag) is not None and not (
                tag == "gravity" and is_true(child_text(element, tag, "true"))
            ):
                model.warn(
                    f"{label}: <{tag}> has no effect, as in Gazebo; <{does}> has",
                    f"<gazebo> elements have <{tag}>, which has no effect, as in Gazebo; <{does}> "
                    "has",
                    f"'{name}'",
                )
        lost = child_number(element, "dampingFactor", label, None)
        if lost is not None:
            decay.setdefault(name, max(0.0, lost))
        if element.find("enable_wind") is not None:
            windy.setdefault(name, is_true(child_text(element, "enable_wind", "")))
    for names in _merged(model):
        falls = next((gravity[name] for name in reversed(names) if name in gravity), True)
        lost = next((decay[name] for name in names if name in decay), 0.0)
        blown = next((windy[name] for name in names if name in windy), False)
        for name in names:
            link = model.links[name]
            link.gravity, link.decay, link.wind = falls, (lost, lost), blown


def _merged(model: ModelDescription) -> list[list[str]]:
    """Links that are not merged into another: each with those that fixed joints merge into it, in
    the order of their joints' names."""
    merging: dict[str, list[Joint]] = {}
    for joint in sorted(model.joints.values(), key=lambda joint: joint.name, reverse=True):
        if _merges(joint, model):
            merging.setdefault(joint.parent, []).append(joint)
    merged = {joint.child for joints in merging.values() for joint in joints}
    groups = []
    for root in model.links:
        if root in merged:
            continue
        names: dict[str, None] = {}
        pending = [root]
        while pending:
            name = pending.pop()
            if name not in names:  # else a loop
                names[name] = None
                pending += [joint.child for joint in merging.get(name, ())]
        groups.append(list(names))
    return groups


def _unknown(element: Node, model: ModelDescription, reference: str | None) -> None:
    label = "<gazebo>" if reference is None else _label(element)
    known = READ | QUIET if reference is None else (READ | QUIET) - {"gripper", "joint"}
    for child in element:
        if isinstance(child.tag, str) and child.tag not in known:
            model.warn(
                f"{label}: <{child.tag}> means nothing here and is ignored",
                f"<gazebo> elements have <{child.tag}>, which means nothing here and is ignored",
                label,
            )


def _model_flags(element: Node, model: ModelDescription) -> None:
    if is_true(child_text(element, "static", "false")):
        model.static = True
    if is_true(_either(element, "self_collide", "selfCollide")):
        model.self_collide = True
    if not is_true(child_text(element, "allow_auto_disable", "true")):
        model.auto_disable = False


def _either(element: Node, *tags: str) -> str:
    """Text of the first of the tags that exists, or 'false'."""
    texts = (child_text(element, tag) for tag in tags)
    return next((text for text in texts if text), "false")


def _link_flags(
    element: Node, model: ModelDescription, link: Link, resolve: Resolve
) -> Material | None:
    """Read a link's surface and flags; returns the material of its visuals."""
    label = _label(element)
    _replace_surface(element, link, label, model)
    read_surface(element, link.surface, label, model.warn, urdf=True)
    read_stiffness(element, link.surface, label)
    link.lights += [parse_light(light, label) for light in element.findall("light")]
    if is_true(_either(element, "selfCollide", "self_collide")):
        link.self_collide = True
    if is_true(child_text(element, "kinematic", "false")):
        link.kinematic = True
    return _material(element, model, label, resolve)


def _material(
    element: Node, model: ModelDescription, label: str, resolve: Resolve
) -> Material | None:
    """<material> by its name, or the <material> of a <visual>."""
    name, material = child_text(element, "material"), None
    if name is not None:
        material = named_material(name, element, resolve, label, model)
        if material is None:
            model.warn(
                f"{label}: material '{name}' is none of Gazebo's and in no script; it is ignored",
                "materials are none of Gazebo's and in no script, and are ignored",
                f"'{name}'",
            )
    else:
        material = material_of(element.find("visual/material"), label, model, resolve)
    return material
