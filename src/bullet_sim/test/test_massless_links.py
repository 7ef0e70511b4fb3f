"""Links of a URDF without mass: left out with all behind them, as sdformat 9 does, or kept."""

import pytest
from bullet_sim.description.warnings import is_loss
from bullet_sim.errors import ModelError
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import inertial, robot
from urdf_texts import joint as urdf_joint

BOX = '<collision><geometry><box size="1 1 1"/></geometry></collision>'


def link(name, mass=None, more=BOX):
    return f'<link name="{name}">{"" if mass is None else inertial(mass, 1)}{more}</link>'


def joint(parent, child, kind="continuous"):
    return urdf_joint(f"{child}_j", kind, parent, child)


CART = robot(
    link("base"),
    *(link("body", 2), joint("base", "body", "fixed")),
    *(link("bare"), joint("base", "bare")),
    *(link("behind", 1), joint("bare", "behind")),
    *(link("null", 0), joint("base", "null")),
    *(link("tiny", 1e-6), joint("base", "tiny")),
    *(link("small", 2e-6), joint("base", "small")),
    *(link("mast"), joint("body", "mast", "fixed")),
    *(link("on_mast", 1), joint("mast", "on_mast")),
    *(link("free", 1), joint("mast", "free", "floating")),
    *(link("carrier"), joint("base", "carrier")),
    *(link("load", 0.3), joint("carrier", "load", "fixed")),
    *(link("hook"), joint("body", "hook", "fixed")),
    *(link("block", 0.1), joint("hook", "block", "fixed")),
    *(link("on_hook", 1), joint("hook", "on_hook")),
)
LEFT = ["base", "body", "small", "mast", "carrier", "load", "hook", "block", "on_hook"]


def test_links_without_mass_are_left_out_with_what_is_behind_them():
    model = parse_urdf(CART, str, "cart")
    assert list(model.links) == LEFT
    assert list(model.joints) == [f"{name}_j" for name in LEFT if name != "base"]
    assert model.loose == {}
    (warning,) = model.warnings
    assert is_loss(warning) and (
        "'cart' without mass are left out, with their joints and all behind them, as in Gazebo: "
        "bare, null, tiny, behind (behind bare), on_mast (behind mast), free (behind mast); "
    ) in warning.replace("on_mast (behind mast), free (behind mast), behind", "behind")


def test_what_is_kept_has_a_small_mass():
    world = World(massless_links="keep")
    model = world.spawn_urdf("cart", CART, Pose((0, 0, 1)), str)
    assert {"bare", "behind", "null", "tiny", "on_mast"} < set(model.bodies)
    assert model.rigid_parts["bare"].mass == 1e-3
    world.close()
    with pytest.raises(ModelError, match="is 'drop', must be one of leave_out, keep"):
        World(massless_links="drop")


@pytest.mark.parametrize("massless, kept", [("leave_out", False), ("keep", True)])
def test_a_kept_fixed_joint_to_a_link_without_mass(massless, kept):
    keep = '<gazebo reference="tip_j"><preserveFixedJoint>true</preserveFixedJoint></gazebo>'
    text = robot(link("base", 1), link("tip"), joint("base", "tip", "fixed"), keep)
    model = parse_urdf(text, str, "r", massless)
    assert ("tip" in model.links) == kept and model.kept == set()
    assert len(model.warnings) == 1


@pytest.mark.parametrize("above", ["", "world"])
def test_a_robot_whose_first_link_has_no_mass_is_empty(above):
    """Gazebo has a model without links then, and spawn_model succeeds."""
    parts = [link("base"), link("arm", 1), joint("base", "arm")]
    if above:
        parts += [link("world"), joint("world", "base", "fixed")]
    world = World()
    model = world.spawn_urdf("r", robot(*parts), Pose((1, 2, 3)), str)
    assert (
        model.bodies == ()
        and model.joints.names == ()
        and not any(link.collisions for link in model.rigid_parts.values())
    )
    assert "all links of 'r' without mass" in model.description.warnings[0]
    world.step(100)
    assert model.pose.position == (1, 2, 3)
    world.close()


def test_a_macro_that_xacro_has_left_as_it_is_may_be_why_nothing_has_mass():
    said = parse_urdf(robot(link("base"), "<wheel side='left'/>"), str).warnings
    assert len(said) == 1 and said[0].endswith("expands a macro only as <xacro:wheel>")


def test_links_on_the_world_are_left_out_each():
    parts = (link("a"), joint("world", "a", "fixed"), link("b", 1), joint("world", "b"))
    model = parse_urdf(robot(link("world"), *parts), str)
    assert list(model.links) == ["world", "b"] and model.fixed_base


def test_what_the_file_says_of_them_is_left_out_with_them():
    """One warning, not one for each element that refers to them."""
    more = (
        '<gazebo reference="bare"><mu1>1</mu1><sensor name="s" type="imu"><plugin name="p" '
        'filename="libgazebo_ros_imu_sensor.so"/></sensor></gazebo>'
        '<gazebo reference="bare_j"><stopErp>1</stopErp></gazebo>'
    )
    text = robot(link("base", 1), link("bare"), joint("base", "bare"), more)
    model = parse_urdf(text, str)
    assert model.sensors == [] and len(model.warnings) == 1
