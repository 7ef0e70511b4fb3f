"""Physics properties: all or nothing, and what reaches world and server."""

import math

import pytest
from bullet_bridge.services import physics
from bullet_bridge.services.physics import PhysicsProperties
from bullet_sim.description.world import OdeSettings
from bullet_sim.errors import WorldError
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_impl import fake_reconfigure
from urdf_texts import CONTROL, link, robot

CAR = robot(link("base"), CONTROL)


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


class Jobs:
    """Does each job at once."""

    def call(self, work):
        return work()

    read = call


@pytest.fixture(name="reconfigured")
def _reconfigured(properties, monkeypatch):
    """A server of dynamic_reconfigure that begins in a world of 2,000 updates a second."""
    params = fake_reconfigure(monkeypatch)
    properties.change(max_update_rate=2000.0)
    made = physics.PhysicsServer("/gazebo", Jobs(), properties)
    made.params, made.properties = params, properties
    return made


def test_a_reconfiguration_begins_with_the_worlds_values(reconfigured):
    """GazeboRosApiPlugin::physicsReconfigureCallback, first call: not held within bounds."""
    told = physics.as_config(reconfigured.properties.read())
    assert {name: reconfigured.config[name] for name in told} == told
    assert {name: reconfigured.params[f"/gazebo/{name}"] for name in told} == told
    assert set(told) == set(physics.CONFIG.type) == set(physics.CONFIG.defaults)
    assert reconfigured.params["/gazebo/max_update_rate"] == 2000.0


ASKED = {  # name -> beyond its bound in cfg/Physics.cfg, that bound or None: refused here
    "time_step": (0.002, 0.002),
    "max_update_rate": (5000.0, 1000.0),
    "gravity_x": (-300.0, -100.0),
    "gravity_y": (101.0, 100.0),
    "gravity_z": (-200.0, -100.0),
    "auto_disable_bodies": (True, False),
    "sor_pgs_precon_iters": (20_000, 10_000),
    "sor_pgs_iters": (20_000, 10_000),
    "sor_pgs_w": (6.0, 5.0),
    "sor_pgs_rms_error_tol": (1e5, 0.0),
    "cfm": (11.0, 10.0),
    "erp": (11.0, 10.0),
    "contact_surface_layer": (11.0, 10.0),
    "contact_max_correcting_vel": (1e8, 1e7),
    "max_contacts": (20_000_000, 10_000_000),
}


def test_each_parameter_of_physics_cfg_is_held_within_its_bounds(reconfigured):
    assert set(ASKED) == set(physics.CONFIG.type)
    for name, (asked, in_force) in ASKED.items():
        reconfigured.update_configuration({name: asked})
        assert physics.as_config(reconfigured.properties.read())[name] == in_force, name


LEAST = {  # name -> what a value below all bounds leaves
    "sor_pgs_precon_iters": 0,
    "sor_pgs_w": 0.0,
    "cfm": 0.0,
    "erp": 0.0,
    "contact_surface_layer": 0.0,
    "contact_max_correcting_vel": 100.0,  # as before: 0 changes nothing
}


def test_no_parameter_goes_below_its_bound(reconfigured):
    for name, least in LEAST.items():
        reconfigured.update_configuration({name: -5})
        assert physics.as_config(reconfigured.properties.read())[name] == least, name


def test_a_reconfiguration_undoes_what_the_service_has_changed_meanwhile(reconfigured):
    """All of the server's own values go along, see physicsReconfigureCallback."""
    properties = reconfigured.properties
    reconfigured.update_configuration({"gravity_z": -2.0})
    properties.change(
        gravity=(1.0, 2.0, -8.0), iterations=9, time_step=0.004, ode={"erp": 0.9, "cfm": 0.1}
    )
    reconfigured.update_configuration({"sor_pgs_w": 1.1})
    now = properties.read()
    assert (now.gravity, now.iterations, now.time_step) == ((0.0, 0.0, -2.0), 50, 0.001)
    assert (now.ode["sor_pgs_w"], now.ode["erp"], now.ode["cfm"]) == (1.1, 0.2, 0.0)
    assert now.max_update_rate == 1000.0


def test_a_reconfiguration_that_is_refused_tells_what_is_in_force(reconfigured):
    told = reconfigured.update_configuration({"time_step": 5.0, "gravity_z": -1.0})
    assert (told["time_step"], told["gravity_z"]) == (0.001, -9.81)
    assert reconfigured.update_configuration({"cfm": 0.5})["cfm"] == 0.5


def test_an_integer_beyond_what_messages_hold_is_their_largest():
    """get_physics_properties failed for ever."""
    values = physics._of_solver(OdeSettings(max_contacts=99999999999, precon_iterations=4294967295))
    assert values["max_contacts"] == values["sor_pgs_precon_iters"] == physics.LARGEST
