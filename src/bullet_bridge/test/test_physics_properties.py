"""Physics properties: all or nothing, and what reaches world and server."""

import math

import pytest
from bullet_bridge.services import physics
from bullet_bridge.services.physics import PhysicsProperties
from bullet_sim.description.world import OdeSettings
from bullet_sim.errors import WorldError
from bullet_sim.pose import Pose
from bullet_sim.world import World

CAR = (
    '<robot name="r"><link name="base"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" '
    'izz="0.1"/></inertial></link><gazebo><plugin name="c" '
    'filename="libgazebo_ros_control.so"/></gazebo></robot>'
)


class FakeServer:
    """Records its calls; a new step is set in the world, as Server does."""

    def __init__(self, world):
        self.world, self.real_time_factor = world, 1.0

    def set_pace(self, factor):
        self.real_time_factor = factor

    def set_time_step(self, time_step):
        self.world.set_time_step(time_step)


@pytest.fixture(name="properties")
def _properties():
    world = World()
    made = PhysicsProperties(world, FakeServer(world))
    made.world, made.server = world, made._server
    yield made
    world.close()


def test_read(properties):
    now = properties.read()
    assert (now.time_step, now.max_update_rate, now.iterations) == (0.001, 1000.0, 50)
    assert now.gravity == (0.0, 0.0, -9.81)


@pytest.mark.parametrize(
    "requested, factor",
    [
        ({"max_update_rate": 0.0}, 0.0),
        ({"max_update_rate": 250.0}, 0.25),
        ({"max_update_rate": 500.0, "time_step": 0.004}, 2.0),
    ],
)
def test_pace_is_rate_times_step(properties, requested, factor):
    properties.change(**requested)
    assert properties.server.real_time_factor == pytest.approx(factor)
    assert properties.read().max_update_rate == pytest.approx(requested["max_update_rate"])


def test_the_solvers_settings_are_those_of_ode_and_change(properties):
    now = properties.read().ode
    assert now == {
        "auto_disable_bodies": False,
        "sor_pgs_precon_iters": 0,
        "sor_pgs_rms_error_tol": 0.0,
        "contact_surface_layer": 0.001,
        "max_contacts": 20,
        "sor_pgs_w": 1.3,
        "cfm": 0.0,
        "erp": 0.2,
        "contact_max_correcting_vel": 100.0,
    }
    properties.change(ode={"sor_pgs_w": 1.0, "erp": 0.5})
    settings = properties.world.engine.settings
    assert (settings.relaxation, settings.erp, settings.cfm) == (1.0, 0.5, 0.0)
    other = {
        "sor_pgs_precon_iters": 3,
        "contact_surface_layer": 0.02,
        "max_contacts": 7,
        "contact_max_correcting_vel": 5.0,
    }
    properties.change(ode=other)
    now.update(other)
    assert (properties.world.engine.settings.max_contacts, settings.max_contacts) == (7, 20)
    properties.change(ode={"max_contacts": 0, "contact_max_correcting_vel": 0.0})
    assert properties.read().ode == {**now, "sor_pgs_w": 1.0, "erp": 0.5}
    assert properties.read().iterations == 50


def test_gravity_and_iterations_survive_a_reset(properties):
    for iterations in (20, 0):
        properties.change(gravity=(1.0, 2.0, 3.0), iterations=iterations)
        properties.world.reset()
        now = properties.read()
        assert (now.gravity, now.iterations) == ((1.0, 2.0, 3.0), iterations)


@pytest.mark.parametrize(
    "requested, reason",
    [
        ({"time_step": 0.0}, "time_step is 0.0"),
        ({"time_step": math.nan}, "time_step is nan"),
        ({"gravity": (0.0, math.inf, 0.0)}, "gravity is .*inf"),
        ({"max_update_rate": -1.0}, "max_update_rate is -1.0"),
        ({"max_update_rate": math.inf}, "max_update_rate is inf"),
        ({"iterations": 50000}, "sor_pgs_iters is 50000"),
        ({"ode": {"erp": -1.0}}, "erp is -1.0"),
        ({"time_step": 2.0, "gravity": (0.0, 0.0, 0.0)}, "time_step is 2.0"),
    ],
)
def test_impossible_values_change_nothing(properties, requested, reason):
    properties.world.spawn_urdf("car", CAR, Pose(), str)
    before = properties.read()
    with pytest.raises(WorldError, match=reason):
        properties.change(**requested)
    assert properties.read() == before


def test_reconfiguring_asks_only_for_what_differs(properties):
    before = physics.as_config(properties.read())
    assert set(before) == set(physics.CONFIG.type) == set(physics.CONFIG.defaults)
    assert physics.requested_changes(dict(before), before) == {}
    assert physics.CONFIG.defaults["sor_pgs_iters"] == 50  # as Gazebo's
    config = dict(before, gravity_x=1.0, sor_pgs_iters=7, erp=0.9, auto_disable_bodies=True)
    assert physics.requested_changes(config, before) == {
        "gravity": (1.0, 0.0, -9.81),
        "iterations": 7,
        "ode": {"erp": 0.9},
    }


def test_an_integer_beyond_what_messages_hold_is_their_largest():
    """get_physics_properties failed for ever."""
    values = physics._of_solver(OdeSettings(max_contacts=99999999999, precon_iterations=4294967295))
    assert values["max_contacts"] == values["sor_pgs_precon_iters"] == physics.LARGEST
