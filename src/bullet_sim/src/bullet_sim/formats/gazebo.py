"""<gazebo> elements of URDF: what they say of links, joints, shapes and the model."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import replace

from bullet_sim.description.model import (
    EVERYWHERE,
    Joint,
    Link,
    ModelDescription,
    Shape,
    Surface,
)
from bullet_sim.formats.extensions import (
    CONVERTED,
    DAMPING,
    OF_AXIS,
    OF_COLLISION,
    OF_CONTACT,
    OF_FRICTION,
    OF_LIMIT,
    Merging,
    collision_element,
    joint_element,
    link_element,
    model_element,
    visual_element,
)
from bullet_sim.formats.joints import read_dynamics
from bullet_sim.formats.lights import parse_light
from bullet_sim.formats.lumping import merges
from bullet_sim.formats.materials import Material, Resolve, material_of, named_material
from bullet_sim.formats.surfaces import read_flags, read_surface, soften
from bullet_sim.plugins import parse_joint_sensor, parse_plugin, parse_sensor
from bullet_sim.plugins.grasping import parse_gripper
from bullet_sim.plugins.xml import merged_links
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import (
    Node,
    child_flag,
    child_number,
    child_text,
    is_true,
    sdf_pose,
)

READ = {
    *(*OF_CONTACT, *OF_FRICTION, *OF_COLLISION, *OF_AXIS, *OF_LIMIT, *DAMPING),
    *("material", "collision", "visual", "static", "turnGravityOff", "dampingFactor"),
    *("selfCollide", "fudgeFactor", "provideFeedback"),
    *("preserveFixedJoint", "disableFixedJointLumping"),
    *("gravity", "self_collide", "kinematic", "enable_wind", "velocity_decay", "pose"),
    *("sensor", "light", "plugin", "gripper", "joint", "allow_auto_disable", "collide_bitmask"),
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
    "canonicalBody",
}
# What is copied and read in a link, a joint or the model.
OF_LINKS = {"gravity", "self_collide", "kinematic", "enable_wind", "velocity_decay", "pose"}
COPIED = {
    "link": {*OF_LINKS, "sensor", "light", "plugin"},
    "joint": {"sensor", "plugin"},
    "model": {*("self_collide", "enable_wind", "allow_auto_disable"), "sensor", "plugin", "gripper"}
    | {"joint"},
}
# What has an effect in Gazebo and none here.
UNREAD = {"link": {"projector"}, "joint": set(), "model": {"link", "model", "include"}}
# What has no effect, as another element counts, and what has.
INSTEAD = {
    "gravity": "turnGravityOff",
    "velocity_decay": "dampingFactor",
    "collide_bitmask": "collision><surface><contact><collide_bitmask",
    "pose": "origin> of the link's <joint",
}
WRONG = {("model", "selfCollide"): "self_collide"}  # converted, but for links alone


def apply(robot: Node, model: ModelDescription, resolve: Resolve, gone: Container[str]) -> None:
    """Read every <gazebo> child of <robot> into the model description.

    Args:
        resolve: of the URIs of scripts.
        gone: links and joints that were left out, with what these elements say of them.
    """
    elements = [e for e in robot.findall("gazebo") if e.get("reference") not in gone]
    for child in (child for element in elements for child in element if child.tag in CONVERTED):
        child.text = child.get("value", child.text)  # which counts before a text, as in sdformat
    groups = _merged(model)
    into = {name: root for root, names in groups.items() for name in names}
    merging = Merging(elements, groups)
    _read_model(merging, robot, model)
    retros = {
        name: _read_surface(merging.of(name), link, model) for name, link in model.links.items()
    }
    materials: dict[str, Material] = {}
    for element in elements:
        reference = element.get("reference") or ""
        if reference in model.links:
            material = _material(element, model, _label(element), resolve)
            if material is not None:
                materials[reference] = material
            label = _label(element)
            lights = [parse_light(light, label) for light in element.findall("light")]
            model.links[into[reference]].lights += lights  # where they are in that one's frame
            if into[reference] != reference:
                _move_sensors(element, model)
        elif reference and reference not in model.joints:
            model.warn(
                f"<gazebo reference='{reference}'> refers to no link and no joint; "
                "what it contains is left out",
                "<gazebo> elements refer to no link and no joint; what they contain is left out",
                f"'{reference}'",
            )
            continue
        _unknown(element, model, reference)
        _sensors_and_plugins(element, model, reference)
    for element in merging.of(""):  # in a link SDF has none
        for gripper in element.findall("gripper"):
            parse_gripper(gripper, model, "")
    looks = {name: visual_element(merging.of(name), robot) for name in model.links}
    _assign(robot, materials, retros, looks, model)


def _label(element: Node) -> str:
    return f"<gazebo reference='{element.get('reference') or ''}'>"


def _move_sensors(element: Node, model: ModelDescription) -> None:
    """Take the <pose> from sensors of a link that is merged, as sdformat up to 9.8 does it: they
    are in the link's own frame."""
    for sensor in element.findall("sensor"):
        if sdf_pose(sensor, "sensor") == Pose():
            continue
        for pose in sensor.findall("pose"):
            sensor.remove(pose)
        name, link = sensor.get("name"), element.get("reference")
        model.warn(
            f"sensor '{name}' is in the frame of link '{link}', which a fixed joint merges: its "
            "<pose> has no effect, as in Gazebo 11.1",
            "sensors of links that fixed joints merge have a <pose>, which has no effect, as in "
            "Gazebo 11.1",
            f"'{name}'",
        )


def _sensors_and_plugins(element: Node, model: ModelDescription, reference: str) -> None:
    """Read the sensors of a link and the plugins of the model: Gazebo loads no others."""
    for sensor in element.findall("sensor"):
        if reference in model.links:
            parse_sensor(sensor, reference, model)
        elif reference in model.joints and sensor.get("type") == "force_torque":
            parse_joint_sensor(sensor, reference, model)
        else:
            model.warn(
                f"sensor '{sensor.get('name')}' refers to no link, but to '{reference}'; "
                "it is left out, as in Gazebo",
                "sensors refer to no link and are left out",
                f"'{sensor.get('name')}'",
            )
    for plugin in element.findall("plugin"):
        if not reference:
            parse_plugin(plugin, model)
            continue
        model.warn(
            f"plugin '{plugin.get('filename')}' is within {_label(element)} and is left out: "
            "Gazebo loads those of a <gazebo> without reference",
            "plugins are within a <gazebo> with a reference and are left out",
            f"'{plugin.get('filename')}'",
        )


def _read_model(merging: Merging, robot: Node, model: ModelDescription) -> None:
    """Read what <gazebo> elements say of the model, its links and its joints."""
    own = model_element(merging.of(""), robot)
    label = f"<gazebo> of '{model.name}'"
    model.static |= is_true(child_text(own, "static", "false"))
    model.self_collide = is_true(child_text(own, "self_collide", "false"))
    model.auto_disable = is_true(child_text(own, "allow_auto_disable", "true"))
    windy = child_flag(own, "enable_wind", label, False)
    for root, names in merging.groups.items():
        label = f"<gazebo reference='{root}'>"
        element = link_element(merging.of_group(root), robot)
        for name in names:
            link = model.links[name]
            read_flags(element, link, label)
            link.wind = child_flag(element, "enable_wind", label, windy)
        moves = root == model.root and root != "world"
        if moves and element.find("pose") is not None:
            model.root_pose = sdf_pose(element, label)
        _warn_of_copies(element, merging.of_group(root), model, moves)
    for joint in model.joints.values():
        elements = merging.of(joint.name)
        if elements and not merges(joint, model):
            read_dynamics(joint_element(elements, robot), joint, _label(elements[0]))


def _warn_of_copies(
    made: Node, elements: Sequence[Node], model: ModelDescription, moves: bool
) -> None:
    """Warn of what is copied into a <link> that has another one of its name before it.

    Args:
        moves: whether a <pose> counts, as the link hangs on none.
    """
    for element in elements:
        for child in (child for child in element if child.tag in OF_LINKS):
            first = made.find(child.tag)
            if first is not None and (child.tag != "pose" or moves) and _same(first, child):
                continue
            does = INSTEAD.get(child.tag, f"{child.tag}> before it")
            says = f"has no effect, as in Gazebo; <{does}> has"
            model.warn(
                f"{_label(element)}: <{child.tag}> {says}",
                f"<gazebo> elements have <{child.tag}>, which {says}",
                f"'{element.get('reference')}'",
            )


def _same(one: Node, other: Node) -> bool:
    """Whether two elements have the same texts."""
    texts = [[(n.tag, (n.text or "").strip()) for n in node.iter()] for node in (one, other)]
    return texts[0] == texts[1]


def _read_surface(elements: Sequence[Node], link: Link, model: ModelDescription) -> float | None:
    """Read the contact properties of a link's shapes; returns their laser_retro, if given."""
    if not elements:
        return None
    label = _label(elements[0])
    _warn_of_surface(elements, label, model)
    made = collision_element(elements, elements[0])
    read_surface(made, link.surface, label, model.warn)
    soften(link.surface)
    return child_number(made, "laser_retro", label, None)


def _warn_of_surface(elements: Sequence[Node], label: str, model: ModelDescription) -> None:
    """Warn of a <surface> that sdformat copies in the place of what it has made of the elements
    before it."""
    before = False
    for element in elements:
        copies = element.find("collision/surface") is not None
        if before and copies:
            model.warn(
                f"{label}: its <surface> replaces all that earlier elements say of friction and "
                "contacts, as in Gazebo",
                "<gazebo> elements of links have a <surface> that replaces all that earlier ones "
                "say of friction and contacts, as in Gazebo",
                label,
            )
        tags = OF_CONTACT.keys() | OF_FRICTION.keys()
        before = before or copies or any(child.tag in tags for child in element)


def _assign(
    robot: Node,
    materials: dict[str, Material],
    retros: dict[str, float | None],
    looks: dict[str, Node],
    model: ModelDescription,
) -> None:
    """Give surfaces and retros to the collisions of links, and materials to their visuals."""
    for name, root in merged_links(model).items():
        link = model.links[name]
        for place, shape in enumerate(link.collisions):
            owner = _owner(shape.name, name, root, "_collision")
            if owner != name:
                surface = model.links[owner].surface if owner else Surface()
                shape = replace(shape, surface=surface)
            retro = retros.get(owner)
            if retro is not None:
                shape = replace(shape, laser_retro=retro)
            link.collisions[place] = shape
        for place, shape in enumerate(link.visuals):
            owner = _owner(shape.name, name, root, "_visual")
            material = materials.get(owner)
            if material is not None:
                shape = material.on(shape)
            link.visuals[place] = _seen(shape, looks[owner], owner) if owner else shape


def _seen(shape: Shape, visual: Node, link: str) -> Shape:
    """A visual with what <gazebo><visual> of a link says, besides its material.

    A <pose> and a <geometry> there have no effect, as in Gazebo, where those of the <visual> count.
    """
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
    return replace(shape, finish=finish, visibility=visibility, laser_retro=retro)


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


def _merged(model: ModelDescription) -> dict[str, list[str]]:
    """Links that are not merged into another: each with itself and those that fixed joints merge
    into it, in the order of their joints' names."""
    merging: dict[str, list[Joint]] = {}
    for joint in sorted(model.joints.values(), key=lambda joint: joint.name, reverse=True):
        if merges(joint, model) and joint.parent != "world":
            merging.setdefault(joint.parent, []).append(joint)
    merged = {joint.child for joints in merging.values() for joint in joints}
    groups = {}
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
        groups[root] = list(names)
    return groups


def _unknown(element: Node, model: ModelDescription, reference: str) -> None:
    """Warn of what sdformat copies to where nobody reads it, or this simulator does not."""
    label = _label(element) if reference else "<gazebo>"
    part = "model" if not reference else "link" if reference in model.links else "joint"
    for child in element:
        tag = child.tag
        if tag in QUIET or tag in COPIED[part] or (tag in CONVERTED and (part, tag) not in WRONG):
            continue
        says = "means nothing here and is ignored"
        if tag in UNREAD[part]:
            says = "has an effect in Gazebo and is ignored here"
        elif tag in INSTEAD:
            says = f"has no effect, as in Gazebo; <{INSTEAD[tag]}> has"
        elif (part, tag) in WRONG:
            says = f"has no effect, as in Gazebo; <{WRONG[part, tag]}> has"
        model.warn(
            f"{label}: <{tag}> {says}", f"<gazebo> elements have <{tag}>, which {says}", label
        )


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
