"""Services about lights, called as rospy calls them, without a ROS master."""

from dataclasses import replace

import pytest
from bullet_bridge.services import handlers
from bullet_bridge.services.lights import LightServices
from bullet_sim.description.world import SUN, Light
from bullet_sim.world import World
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA


class Direct:
    """A JobQueue whose jobs run at once."""

    @staticmethod
    def call(job):
        return job()

    read = call


@pytest.fixture(name="desk")
def _desk(monkeypatch):
    """(world, function name, **fields -> response, list of what was shown)."""
    found, shown = {}, []
    monkeypatch.setattr(
        handlers.rospy, "Service", lambda name, kind, work: found.update({name: (kind, work)})
    )
    monkeypatch.setattr(handlers.rospy, "logerr", lambda *_: None)
    world = World()
    world.scene = replace(world.scene, lights=(SUN, Light("lamp", "point", linear=0.2)))
    LightServices("/gazebo", world, Direct, lambda: shown.append(world.scene))

    def call(name, **fields):
        kind, work = found[f"/gazebo/{name}"]
        return work(kind._request_class(**fields))

    yield world, call, shown
    world.close()


def test_get(desk):
    _, call, shown = desk
    answer = call("get_light_properties", light_name="lamp")
    assert answer.success and answer.diffuse == ColorRGBA(1.0, 1.0, 1.0, 1.0)
    assert (answer.attenuation_constant, answer.attenuation_linear) == (1.0, 0.2)
    assert not shown


def request(**changes):
    values = dict(
        light_name="sun",
        cast_shadows=False,
        diffuse=ColorRGBA(0.1, 0.2, 0.3, 1.0),
        specular=ColorRGBA(0.0, 0.0, 0.5, 1.0),
        attenuation_constant=0.3,
        attenuation_linear=0.02,
        attenuation_quadratic=0.001,
        direction=Vector3(0.0, 0.0, -2.0),
        pose=Pose(Point(1.0, 2.0, 3.0), Quaternion(0.0, 0.0, 0.0, 1.0)),
    )
    return dict(values, **changes)


def test_set(desk):
    world, call, shown = desk
    assert call("set_light_properties", **request()).success
    sun, lamp = world.scene.lights
    assert (sun.name, sun.kind, sun.cast_shadows) == ("sun", "directional", False)
    assert sun.diffuse == (0.1, 0.2, 0.3) and sun.specular == (0.0, 0.0, 0.5)
    assert (sun.position, sun.direction) == ((1.0, 2.0, 3.0), (0.0, 0.0, -1.0))
    assert (sun.constant, sun.linear, sun.quadratic) == (0.3, 0.02, 0.001)
    assert lamp.name == "lamp" and shown == [world.scene]
    turned = Pose(Point(), Quaternion(0.0, 1.0, 0.0, 1.0))  # a quarter turn about y
    assert call("set_light_properties", **request(pose=turned)).success
    assert world.scene.lights[0].direction == pytest.approx((-1.0, 0.0, 0.0), abs=1e-9)
    kept = request(direction=Vector3(), pose=Pose())
    assert call("set_light_properties", **kept).success
    assert world.scene.lights[0].direction == pytest.approx((-1.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"light_name": "moon"}, "setLightProperties: Requested light moon not found!"),
        ({"diffuse": ColorRGBA(float("nan"), 0, 0, 1)}, "diffuse of light 'sun' is"),
        ({"attenuation_linear": -1.0}, "linear attenuation of light 'sun' is -1.0, must be"),
        ({"direction": Vector3(float("inf"), 0, 0)}, "direction of light 'sun' is"),
        ({"pose": Pose(Point(float("nan"), 0, 0), Quaternion())}, "pose of light 'sun' is"),
    ],
)
def test_what_is_refused(desk, changes, words):
    world, call, shown = desk
    before = world.scene
    answer = call("set_light_properties", **request(**changes))
    assert not answer.success and words in answer.status_message
    assert world.scene is before and not shown


def test_delete(desk):
    world, call, shown = desk
    answer = call("delete_light", light_name="sun")
    assert (answer.success, answer.status_message) == (
        True,
        "DeleteLight: sun successfully deleted",
    )
    assert [light.name for light in world.scene.lights] == ["lamp"] and len(shown) == 1
    answer = call("delete_light", light_name="sun")
    assert not answer.success
    assert answer.status_message == 'DeleteLight: Timeout reached while removing light "sun"'
