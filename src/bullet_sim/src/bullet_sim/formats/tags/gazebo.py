"""<gazebo> elements of a URDF: surfaces, colours, flags; sensors and plugins are handed on."""

from dataclasses import replace

from bullet_sim.description.parts import ModelDescription
from bullet_sim.formats.colors import gazebo_color, rgba_of
from bullet_sim.formats.tags.plugins import parse_plugin
from bullet_sim.formats.tags.sensors import parse_sensor
from bullet_sim.formats.xml_read import child_number, child_text, is_true

MAX_STIFFNESS = 1e5  # [N/m] above which contacts are left as hard as Bullet makes them
_READ = {
    "mu",
    "mu1",
    "mu2",
    "kp",
    "kd",
    "material",
    "selfCollide",
    "self_collide",
    "gravity",
    "turnGravityOff",
    "sensor",
    "plugin",
    "static",
    "visual",
    "collision",
}
# What steers Gazebo's solver or its file conversion and has no counterpart here.
_QUIET = {
    "fdir1",
    "maxVel",
    "minDepth",
    "maxContacts",
    "laserRetro",
    "dampingFactor",
    "implicitSpringDamper",
    "provideFeedback",
    "preserveFixedJoint",
    "disableFixedJointLumping",
    "initial_joint_position",
    "stopCfm",
    "stopErp",
    "stopKp",
    "stopKd",
    "cfmDamping",
    "fudgeFactor",
    "erp",
    "cfm",
    "allow_auto_disable",
    "enable_wind",
    "velocity_decay",
    "kinematic",
    "soft_cfm",
    "soft_erp",
    "slip1",
    "slip2",
}


def apply(robot, model: ModelDescription):
    """Read every <gazebo> child of <robot> into the model description.

    Args:
        robot: the <robot> element.
        model: its description so far.
    """
    for element in robot.findall("gazebo"):
        reference = element.get("reference")
        if reference is None:
            _model_flags(element, model)
        elif reference in model.links:
            _link_flags(element, model, model.links[reference])
        elif reference not in model.joints:
            model.warn(
                f"<gazebo reference='{reference}'> refers to no link and no joint; "
                "what it holds is left out",
                "<gazebo> elements refer to no link and no joint; what they hold is left out",
                f"'{reference}'",
            )
        _unknown(element, model, reference)
        for sensor in element.findall("sensor"):
            link = reference if reference is not None else model.root
            if link not in model.links:
                model.warn(
                    f"sensor '{sensor.get('name')}' refers to link '{reference}', "
                    "which does not exist; it is left out",
                    "sensors refer to a link that does not exist and are left out",
                    f"'{sensor.get('name')}'",
                )
                continue
            parse_sensor(sensor, link, model)
        for plugin in element.findall("plugin"):
            parse_plugin(plugin, model)


def _unknown(element, model, reference):
    what = "<gazebo>" if reference is None else f"<gazebo reference='{reference}'>"
    for child in element:
        if isinstance(child.tag, str) and child.tag not in _READ | _QUIET:
            model.warn(
                f"{what}: <{child.tag}> means nothing here and is ignored",
                f"<gazebo> elements have <{child.tag}>, which means nothing here and is ignored",
                what,
            )


def _model_flags(element, model):
    if is_true(child_text(element, "static", "false")):
        model.static = True
    if is_true(_either(element, "self_collide", "selfCollide")):
        model.self_collide = True


def _either(element, *tags):
    """Text of the first of the tags that is there, or 'false'."""
    return next((child_text(element, tag) for tag in tags if child_text(element, tag)), "false")


def _link_flags(element, model, link):
    what = f"<gazebo reference='{link.name}'>"
    _surface(element, model, link, what)
    _material(element, model, link, what)
    if is_true(_either(element, "selfCollide", "self_collide")):
        link.self_collide = True
    off = is_true(child_text(element, "turnGravityOff", "false"))
    if off or not is_true(child_text(element, "gravity", "true")):
        link.gravity = False
        model.warn(
            f"{what} turns gravity off, which cannot be done for a single link here; "
            "it falls like the others"
        )


def _surface(element, model, link, what):
    surface = link.surface
    frictions = {}
    for tag, path in (
        ("mu1", "mu1"),
        ("mu1", "mu"),
        ("mu2", "mu2"),
        ("mu1", "collision/surface/friction/ode/mu"),
        ("mu2", "collision/surface/friction/ode/mu2"),
    ):
        value = child_number(element, path, what, None)
        if value is not None:
            frictions[tag] = max(0.0, value)
    if frictions:
        surface.friction = min(frictions.values())
        if len(set(frictions.values())) > 1:
            model.warn(
                f"{what} has mu1 {frictions['mu1']} and mu2 {frictions['mu2']}; PyBullet "
                "has one friction for both directions: the smaller, "
                f"{surface.friction}"
            )
    stiffness = child_number(element, "kp", what, None)
    if stiffness is not None and 0 < stiffness < MAX_STIFFNESS:
        surface.stiffness = stiffness
        surface.damping = max(0.0, child_number(element, "kd", what, 1.0))


def _material(element, model, link, what):
    name = child_text(element, "material")
    if name is not None:
        color = gazebo_color(name)
        if color is None:
            model.warn(
                f"{what}: material '{name}' is none of Gazebo's standard colours; it is ignored",
                "materials are none of Gazebo's standard colours and are ignored",
                f"'{name}'",
            )
    else:
        text = child_text(element, "visual/material/diffuse") or child_text(
            element, "visual/material/ambient"
        )
        name = child_text(element, "visual/material/script/name")
        color = (
            rgba_of(element, text, f"{what} material")
            if text
            else (gazebo_color(name) if name else None)
        )
    if color is not None:
        link.color = color
        link.visuals[:] = [
            replace(shape, color=color, texture="", painted=True) for shape in link.visuals
        ]
