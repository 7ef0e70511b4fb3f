"""Views for the viewer: names, sources once, rays of visualised lidars."""

import numpy as np
import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.sensors.views import MAX_RAYS, Observer
from bullet_sim.world import World

CAR = """<robot name="car"><link name="base">
  <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>
  <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="mast"/>
  <joint name="j" type="fixed"><parent link="base"/><child link="mast"/>
    <origin xyz="0 0 0.5"/></joint>
  <gazebo reference="mast"><sensor type="ray" name="lidar">{visualize}
    <update_rate>10</update_rate>
    <ray><scan><horizontal><samples>{samples}</samples><min_angle>0</min_angle>
      <max_angle>1.5707963</max_angle></horizontal></scan>
      <range><min>0.1</min><max>5</max></range></ray>
    <plugin name="p" filename="libgazebo_ros_laser.so"><topicName>scan</topicName></plugin>
  </sensor></gazebo></robot>"""
WALL = """<robot name="wall"><link name="w">
  <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
  <collision><geometry><box size="0.2 4 4"/></geometry></collision></link></robot>"""


@pytest.fixture(name="world")
def make_world():
    world = World(gravity=(0.0, 0.0, 0.0))
    world.spawn(sdf.ground_plane())
    world.spawn_urdf("wall", WALL, Pose((2.1, 0.0, 0.0)), str)
    yield world
    world.close()


def spawn_car(world, visualize="<visualize>true</visualize>", samples=3):
    text = CAR.format(visualize=visualize, samples=samples)
    return world.spawn_urdf("car", text, Pose((0.0, 0.0, 1.0)), str)


def test_models_and_sources(world):
    observer = Observer(world)
    view = observer.view(paused=True)
    assert [(entry.name, entry.static) for entry in view.models] == [
        ("ground_plane", True),
        ("wall", False),
    ]
    assert view.paused and view.rays == ()
    assert [source.key for source in view.sources] == [entry.key for entry in view.models]
    assert [state.key for state in view.snapshot.bodies] == [e.key for e in view.models]


def test_sources_come_only_when_they_change(world):
    observer = Observer(world)
    observer.view(False)
    assert observer.view(False).sources is None
    world.step(5)
    assert observer.view(False).sources is None
    spawn_car(world)
    assert len(observer.view(False).sources) == 3
    world.delete("car")
    assert len(observer.view(False).sources) == 2


def test_rays_end_at_what_they_hit(world):
    spawn_car(world)
    (rays,) = Observer(world).view(False).rays
    assert rays.origin == pytest.approx([0.0, 0.0, 1.5])
    # 0 rad: the wall's face at x = 2; 45 degrees: the wall again; 90 degrees: nothing within 5 m
    assert rays.ends == pytest.approx(
        np.array([[2.0, 0.0, 1.5], [2.0, 2.0, 1.5], [0.0, 5.0, 1.5]]), abs=1e-3
    )


def test_a_lidar_that_is_not_visualised_is_not_cast(world):
    spawn_car(world, visualize="")
    assert Observer(world).view(False).rays == ()


def test_many_rays_are_thinned(world):
    spawn_car(world, samples=1000)
    (rays,) = Observer(world).view(False).rays
    assert MAX_RAYS / 2 < len(rays.ends) <= MAX_RAYS


def test_rays_are_cast_at_the_rate_of_the_sensor(world):
    spawn_car(world)
    observer = Observer(world)
    (first,) = observer.view(False).rays
    world.step(50)  # 0.05 s of 0.1 s
    assert observer.view(False).rays[0] is first
    world.step(60)
    (second,) = observer.view(False).rays
    assert second is not first
    world.reset()  # time goes back
    assert observer.view(False).rays[0] is not second


def test_viewing_changes_nothing(world):
    def states(look):
        world.reset()
        car = world.model("car")
        car.set_state(car.pose, (0.3, 0.0, 0.0), (0.0, 0.1, 0.2))
        observer = Observer(world)
        for _ in range(200):
            world.step()
            if look:
                observer.view(False)
        return world.snapshot()

    spawn_car(world)
    assert states(look=True) == states(look=False)


def test_contacts_and_link_frames_come_on_request(world):
    car = spawn_car(world)
    world.engine.set_gravity((0.0, 0.0, -9.81))
    car.set_state(Pose((0.0, 1.0, 0.1), (0.0, 0.0, np.sin(np.pi / 4), np.cos(np.pi / 4))))
    world.step(100)
    observer = Observer(world)
    plain = observer.view(False)
    assert plain.contacts is None and plain.frames is None
    observer.show("car", True)
    view = observer.view(False)
    own = view.contacts.places[:, 1] > 0.5  # the car's, not those of the wall
    assert view.contacts.places[own][:, 2] == pytest.approx(0.0, abs=1e-3)
    assert np.abs(view.contacts.normals[own][:, 2]) == pytest.approx(1.0)
    assert view.contacts.forces[own].sum() == pytest.approx(9.81, rel=0.05)
    assert view.frames.names == ("base", "mast")
    assert view.frames.origins == pytest.approx(np.array([[0, 1, 0.1], [0, 1, 0.6]]), abs=1e-3)
    assert view.frames.rotations[0][:, 0] == pytest.approx([0, 1, 0], abs=1e-3)  # its x is ahead
    observer.show("gone", False)
    assert observer.view(False).frames is None
