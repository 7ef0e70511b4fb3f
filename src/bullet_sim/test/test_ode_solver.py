"""The solver 'ode': what real Gazebo 11.1 did with the same robots, closed forms, states.

Gazebo's figures were recorded with the packages of this repository, unmodified, by a program that
sent the same commands to both (docs/gazebo-comparison.md).
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
import xacro
from bullet_sim.engine import make_engine
from bullet_sim.errors import ModelError
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from driving import drive_positions, drive_velocities
from urdf_texts import joint, robot

SOURCES = Path(__file__).resolve().parents[2]
CAR = SOURCES / "track_model" / "urdf" / "racecar.urdf.xacro"
TRUCK = SOURCES / "cybertruck" / "urdf" / "cybertruck.urdf.xacro"
G = 9.81
LINK = (
    '<link name="{0}"><inertial><origin xyz="{2}"/><mass value="{1}"/><inertia ixx="{3}" '
    'iyy="{3}" izz="{3}" ixy="0" ixz="0" iyz="0"/></inertial>{4}</link>'
)


def link(name, mass=1.0, center="0 0 0", inertia=0.01, shape=""):
    geometry = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    return LINK.format(name, mass, center, inertia, geometry)


def static(geometry):
    """SDF of a model that never moves."""
    return (
        '<sdf version="1.6"><model name="m"><static>true</static><link name="l"><collision '
        f'name="c"><geometry>{geometry}</geometry></collision></link></model></sdf>'
    )


def mesh_model(path, mesh):
    """SDF of a static model of a mesh, which is written to a file."""
    mesh.export(path)
    return static(f"<mesh><uri>file://{path}</uri></mesh>")


def spawn(world, text, pose=Pose(), ground=False):
    if ground:
        world.spawn(sdf.ground_plane())
    return world.spawn_urdf("bot", text, pose, str)


def published(path, **arguments):
    """URDF of one of our packages."""
    return xacro.process_file(str(path), mappings=arguments).toxml()


def resolve(uri):
    return uri.replace("package://", f"{SOURCES}/")


def yaw(model):
    x, y, z, w = model.pose.orientation
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def drive(world, model, seconds):
    """Way [m] and rotation [degrees] of a while."""
    way = turn = 0.0
    for _ in range(round(seconds * 20)):
        before, heading = np.array(model.pose.position), yaw(model)
        world.step(50)
        way += float(np.linalg.norm(np.array(model.pose.position) - before))
        turn += math.remainder(yaw(model) - heading, 2 * math.pi)
    return way, math.degrees(turn)


# as in Gazebo -------------------------------------------------------------------------------------
def settings_of(path):
    """OdeSettings of a world file."""
    return sdf.parse_world(path.read_text(encoding="utf-8"), str).ode


def wheel_angles(steering, wheelbase, half_track):
    """Angles [rad] of the left and the right front wheel for a bicycle's steering angle."""
    curvature = math.tan(steering) / wheelbase
    return [math.atan2(wheelbase * curvature, 1 - curvature * y) for y in (half_track, -half_track)]


def our_car(world, heading=0.0):
    """The car on a plane with the iterations of its world; (it, wheels, hinges)."""
    world.engine.configure(settings_of(SOURCES / "track_model" / "worlds" / "track.world"))
    world.spawn(sdf.ground_plane())
    start = Pose((0.0, 0.0, 0.05), (0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2)))
    car = world.spawn_urdf("racecar", published(CAR), start, resolve)
    wheels = [name for name in car.joints.names if "wheel" in name]
    return car, wheels, ["left_steering_hinge_joint", "right_steering_hinge_joint"]


# Recorded on 2026-11-26 with 0.3 m/s and 0.25 m/s of the rear axle: steering [rad], yaw rate
# [rad/s] in Gazebo; in Paddock the same but for 1e-4.
CAR_TURNS = ((0.15, 0.2766), (0.3, 0.5675), (0.5, 1.0042))
TRUCK_TURNS = ((0.15, 0.0744), (0.3, 0.1523), (0.5, 0.2691))


def test_our_car_drives_as_in_gazebo_and_as_it_steers(world):
    """With the iterations of its world. Gazebo: 0.3 mm in the first 30 s, 0.2 mm in the last."""
    car, wheels, hinges = our_car(world)
    world.step(2000)
    assert drive(world, car, 20.0)[0] < 0.0005
    assert car.pose.position[2] == pytest.approx(-0.007, abs=1e-4)
    wheelbase, radius, halves = 0.163974, 0.03, {"rear": 0.08105, "front": 0.079601}
    speed = 0.3
    for steering, recorded in ((0.0, 0.0), *CAR_TURNS):
        curvature = math.tan(steering) / wheelbase
        for end, half in halves.items():
            ahead = wheelbase * curvature if end == "front" else 0.0
            speeds = [speed / radius * math.hypot(1 - curvature * y, ahead) for y in (half, -half)]
            names = [f"{side}_{end}_wheel_joint" for side in ("left", "right")]
            drive_velocities(car.joints, names, speeds)
        drive_positions(car.joints, hinges, wheel_angles(steering, wheelbase, halves["front"]))
        drive(world, car, 2.0)
        way, turn = drive(world, car, 4.0)
        rate = math.radians(turn) / 4.0
        assert rate == pytest.approx(recorded, abs=5e-4)
        assert rate == pytest.approx(speed * curvature, rel=0.005, abs=5e-4)
        middle = math.hypot(1.0, curvature * 0.081663)  # base_link is ahead of the rear axle
        assert way / 4.0 == pytest.approx(speed * middle, rel=0.01)
    drive_velocities(car.joints, wheels, [0.0] * 4)
    drive_positions(car.joints, hinges, [0.0, 0.0])
    drive(world, car, 2.0)
    assert drive(world, car, 10.0)[0] < 0.0005


@pytest.mark.parametrize("heading", [0.0, 0.4, 0.8])
def test_our_car_with_one_speed_for_all_wheels_turns_as_in_gazebo(world, heading):
    """As the original teleoperator drives it: the wheels slip; Gazebo was recorded at heading 0."""
    car, wheels, hinges = our_car(world, heading)
    world.step(1000)
    drive_velocities(car.joints, wheels, [20.0] * 4)
    drive_positions(car.joints, hinges, [0.0, 0.0])
    assert drive(world, car, 4.0)[0] == pytest.approx(2.3577, rel=0.01)
    drive_positions(car.joints, hinges, [0.3, 0.3])
    way, turn = drive(world, car, 4.0)
    assert way == pytest.approx(2.1498, rel=0.01)
    assert turn == pytest.approx(194.99, rel=0.01)


@pytest.mark.parametrize("trailer", ["true", "false"])
def test_our_truck_drives_as_in_gazebo_and_as_it_steers(world, trailer):
    """With the iterations of its world."""
    settings = settings_of(SOURCES / "cybertruck" / "worlds" / "yard.world")
    world.engine.configure(settings)
    world.spawn(sdf.ground_plane())
    truck = world.spawn_urdf("cybertruck", published(TRUCK, trailer=trailer), Pose(), resolve)
    axle = ("rear_left_wheel_joint", "rear_right_wheel_joint")
    steers = ("front_left_steer_joint", "front_right_steer_joint")
    world.step(2000)
    assert drive(world, truck, 20.0)[0] < 0.0005
    wheelbase, half_track, radius, speed = 0.508, 0.215, 0.1016, 0.25
    for steering, recorded in ((0.0, 0.0), *TRUCK_TURNS):
        curvature = math.tan(steering) / wheelbase
        speeds = [speed / radius * (1 - curvature * y) for y in (half_track, -half_track)]
        drive_velocities(truck.joints, axle, speeds)
        drive_positions(truck.joints, steers, wheel_angles(steering, wheelbase, half_track))
        drive(world, truck, 2.0)
        way, turn = drive(world, truck, 4.0)
        rate = math.radians(turn) / 4.0
        assert rate == pytest.approx(recorded, abs=3e-4)
        assert rate == pytest.approx(speed * curvature, rel=0.005, abs=3e-4)
        assert way / 4.0 == pytest.approx(speed, rel=0.005)
        assert truck.pose.position[2] == pytest.approx(0.0, abs=1e-3)


def test_what_is_balanced_on_two_wheels_stands_as_in_gazebo(world):
    """Until something pushes it: nothing turns it by a rounding, which grows tenfold in 0.4 s."""

    def part(name, mass, inertia, origin):
        numbers = " ".join(f'i{axis}="{value}"' for axis, value in inertia.items())
        return (
            f'<link name="{name}"><inertial><origin rpy="{origin} 0 0"/><mass value="{mass}"/>'
            f'<inertia {numbers} ixy="0" ixz="0" iyz="0"/></inertial><collision>'
            f'<origin rpy="{origin} 0 0"/><geometry>SHAPE</geometry></collision></link>'
        )

    box, rod, tyre = (
        '<box size="0.04 0.15 0.2"/>',
        '<cylinder radius="0.012" length="0.07"/>',
        '<cylinder radius="0.033" length="0.027"/>',
    )
    base = {"xx": 0.0010416666666666667, "yy": 0.0006933333333333335, "zz": 0.0004016666666666667}
    text = part("base", 0.2, base, 0).replace("SHAPE", box)
    battery = part("battery", 0.15, {"xx": 0.0001125, "yy": 3.125e-5, "zz": 0.00012125}, 0)
    text += battery.replace("SHAPE", box) + joint("tray", "fixed", "base", "battery", "0 0 0.115")
    for side, y in (("left", 0.04), ("right", -0.04)):
        motor = part(f"{side}_motor", 0.1, {"xx": 4.6e-5, "yy": 4.6e-5, "zz": 7.8e-6}, 1.57075)
        wheel = part(side, 0.05, {"xx": 2.1e-5, "yy": 2.1e-5, "zz": 2.6e-5}, 1.57075)
        text += motor.replace("SHAPE", rod) + wheel.replace("SHAPE", tyre)
        text += joint(f"{side}_mount", "fixed", "base", f"{side}_motor", f"0 {y} -0.1125")
        text += joint(f"{side}_joint", "continuous", f"{side}_motor", side, f"0 {1.25 * y} 0")
    bot = spawn(world, f'<robot name="bot">{text}</robot>', Pose((0, 0, 0.146)), ground=True)
    world.step(100)
    drive_velocities(bot.joints, ("left_joint", "right_joint"), (0.0, 0.0))
    world.step(15000)
    assert bot.pose.position[2] == pytest.approx(0.1455, abs=1e-3)
    bot.body.set_velocity((0.0, 0.0, 0.0), (0.0, 1e-9, 0.0))
    world.step(8000)
    assert bot.pose.position[2] < 0.1


def noted_searches(world, monkeypatch):
    """Times [s] at which PyBullet is asked for contacts from now on."""
    searches = []
    contacts = world.engine.last_contacts
    search = contacts.find
    monkeypatch.setattr(contacts, "find", lambda: searches.append(world.time) or search())
    return searches


def test_contacts_with_a_mesh_are_found_without_pybullet(world, monkeypatch, tmp_path):
    """In a yard of one mesh with walls 5 m away: of a ball, and of a box at the wall."""
    places = (((0, 5), (10, 0.2)), ((0, -5), (10, 0.2)), ((5, 0), (0.2, 10)), ((-5, 0), (0.2, 10)))
    walls = trimesh.util.concatenate(
        [trimesh.creation.box((*size, 1.0)).apply_translation((*at, 0.5)) for at, size in places]
    ).subdivide_to_size(1.0)
    yard = mesh_model(tmp_path / "yard.stl", walls)
    world.spawn_sdf("yard", yard, Pose(), lambda uri: uri[7:])
    text = robot(link("base", 1.0, inertia=0.004, shape='<sphere radius="0.1"/>'))
    ball = spawn(world, text, Pose((0.0, 3.0, 0.1)), ground=True)
    searches = noted_searches(world, monkeypatch)
    world.step(500)
    assert not searches
    ball.body.set_velocity((0.0, 2.0, 0.0), (-20.0, 0.0, 0.0))
    world.step(1500)
    assert not searches
    assert ball.pose.position[1] == pytest.approx(4.8, abs=0.01)
    box = world.spawn_urdf("box", BOX, Pose((2.0, 4.71, 0.2)), str)
    world.step()
    touched = {body for _, body, _, _ in box.body.touching()}
    assert world.model("yard").body.number in touched and not searches


@pytest.mark.parametrize("kind", ["mesh", "box"])
def test_no_contacts_are_looked_for_beside_a_tall_post(world, monkeypatch, tmp_path, kind):
    """The box stands turned by 45 degrees, 3 cm from the post's edge: less than half its size."""
    trimesh.creation.box((0.1, 0.1, 4.0)).export(tmp_path / "post.stl")
    shapes = {"mesh": f'<mesh filename="{tmp_path}/post.stl"/>', "box": '<box size="0.1 0.1 4"/>'}
    post = robot(link("base", 5.0, inertia=5.0, shape=shapes[kind]))
    quarter = (0.0, 0.0, math.sin(math.pi / 8), math.cos(math.pi / 8))
    box = spawn(world, BOX, Pose((0.0, 0.0, 0.2), quarter), ground=True)
    aside = 0.05 * math.sqrt(2.0) + 0.2 + 0.03
    place = (aside * math.cos(math.pi / 4), aside * math.sin(math.pi / 4), 2.0)
    world.spawn_urdf("post", post, Pose(place), str)
    searches = noted_searches(world, monkeypatch)
    world.step(100)
    assert not searches
    toward = 1.5 * np.array((place[0], place[1], 0.0)) / aside
    box.body.set_velocity(tuple(toward), (0.0, 0.0, 0.0))
    world.step(100)
    assert not searches
    assert box.pose.position[0] < 0.08  # 0.3 without the post


def test_self_collision_is_looked_for_only_when_it_may_happen(world, monkeypatch):
    """Two arms on a base; one turns towards the other, which it does not pass."""
    shape = '<box size="0.4 0.04 0.04"/>'
    arms = "".join(
        link(name, 0.2, "0.25 0 0", 1e-3, shape).replace(
            "<collision>", '<collision><origin xyz="0.25 0 0"/>'
        )
        + joint(f"{name}_joint", "continuous", "base", name, f"0 {y} 0.5", "0 0 1")
        for name, y in (("left", 0.2), ("right", -0.2))
    )
    collide = "".join(
        f'<gazebo reference="{name}"><selfCollide>true</selfCollide></gazebo>'
        for name in ("base", "left", "right")
    )
    base = link("base", 50.0, inertia=5.0, shape='<box size="0.4 0.4 0.1"/>')
    arm = spawn(world, robot(base, arms, collide), Pose((0.0, 0.0, 0.05)), ground=True)
    left, right = (arm.body.motor(f"{side}_joint") for side in ("left", "right"))
    right.track_velocity(0.0, 100.0)
    searches = noted_searches(world, monkeypatch)
    world.step(100)
    assert not searches
    left.track_velocity(-1.0, 1.0)
    world.step(2500)
    assert not searches  # boxes
    states = dict(zip(arm.body.joints, arm.body.joint_states()))
    assert states["left_joint"][:2] == pytest.approx((-1.0, 0.0), abs=0.1)
    assert abs(states["right_joint"][1]) < 0.1


@pytest.mark.parametrize("shape", ['<box size="0.1 0.1 0.8"/>', '<sphere radius="0.3"/>'])
def test_a_fixed_base_does_not_touch_its_own_arm(world, shape):
    """A pendulum that begins within the base swings freely."""
    text = robot(
        '<link name="world"/>',
        joint("held", "fixed", "world", "base", "0 0 2"),
        link("base", 5.0, inertia=0.1, shape='<box size="0.4 0.4 0.4"/>'),
        joint("pivot", "continuous", "base", "arm"),
        link("arm", 1.0, "0 0 -0.3", 0.01, shape),
    )
    arm = spawn(world, text)
    arm.body.set_joint_positions([0.2])
    swings = [arm.body.joint_positions()[0]]
    for _ in range(120):
        world.step(10)
        swings.append(arm.body.joint_positions()[0])
    assert min(swings) == pytest.approx(-0.2, abs=5e-3)
    assert not arm.body.touching()


def test_a_joint_is_put_to_a_position_before_the_first_step(world):
    """As steer_bot_hardware_gazebo does when its robot is spawned."""
    text = robot(link("base"), link("arm"), joint("hinge", "revolute", "base", "arm"))
    bot = world.spawn_urdf("bot", text, Pose((0.0, 0.0, 1.0)), str)
    bot.body.motor(bot.body.joints[0]).impose_position(0.3, 10.0, 10.0)
    world.step(1)
    assert bot.body.joint_positions()[0] == pytest.approx(0.3, abs=1e-3)


HINGED = robot(link("base"), link("arm"), joint("hinge", "continuous", "base", "arm"))


@pytest.mark.parametrize(
    "command, ends",
    [
        ("track_velocity", (3.0, 10.0)),
        ("track_position", (0.3, 10.0, 10.0)),
        ("impose_velocity", (3.0, 10.0)),
        ("impose_position", (0.3, 10.0, 10.0)),
    ],
)
@pytest.mark.parametrize("steps", [0, 5])
def test_what_a_joint_is_told_outlasts_models_that_come(world, steps, command, ends):
    """Before the first step and after one, beside a model that moves and one that does not."""
    world.engine.set_gravity((0.0, 0.0, 0.0))
    one = world.spawn_urdf("one", HINGED, Pose((0.0, 0.0, 1.0)), str)
    world.step(steps)
    getattr(one.body.motor(one.body.joints[0]), command)(*ends)
    two = world.spawn_urdf("two", HINGED, Pose((5.0, 0.0, 1.0)), str)
    getattr(two.body.motor(two.body.joints[0]), command)(*ends)
    world.spawn_sdf("post", static("<box><size>1 1 1</size></box>"), Pose((9.0, 0.0, 1.0)), str)
    world.step(50)
    for bot in (one, two):
        (position, rate, *_) = bot.body.joint_states()[0]
        found = rate if command.endswith("velocity") else position
        assert found == pytest.approx(ends[0], rel=0.02), bot.name


def test_what_a_joint_is_told_outlasts_a_move_of_its_model(world):
    world.engine.set_gravity((0.0, 0.0, 0.0))
    bot = world.spawn_urdf("bot", HINGED, Pose((0.0, 0.0, 1.0)), str)
    post = world.spawn_sdf("post", static("<box><size>1 1 1</size></box>"), Pose(), str)
    bot.body.motor(bot.body.joints[0]).track_position(0.3, 10.0, 10.0)
    world.step(50)
    bot.body.set_pose((1.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0))
    post.body.set_pose((9.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    for _ in range(50):
        bot.body.motor(bot.body.joints[0]).add_effort(1.0)  # which the motor withstands
        world.step(1)
    assert bot.body.joint_positions()[0] == pytest.approx(0.3, abs=1e-3)


def test_a_joint_is_released_while_a_model_comes(world):
    world.engine.set_gravity((0.0, 0.0, 0.0))
    bot = world.spawn_urdf("bot", HINGED, Pose((0.0, 0.0, 1.0)), str)
    world.step(1)
    bot.body.motor(bot.body.joints[0]).track_velocity(3.0, 10.0)
    world.step(5)
    world.spawn_urdf("two", HINGED, Pose((5.0, 0.0, 1.0)), str)
    bot.body.motor(bot.body.joints[0]).release()
    bot.body.motor(bot.body.joints[0]).add_effort(-0.1)
    world.step(1)
    assert bot.body.joint_states()[0][1] < 2.999  # no motor holds it


BALL = robot(link("base", 1.0, inertia=0.004, shape='<sphere radius="0.1"/>'))
BOX = robot(link("base", 1.0, inertia=0.02, shape='<box size="0.4 0.4 0.4"/>'))


def test_what_rests_for_a_second_sleeps_until_something_happens(world):
    box = spawn(world, BOX, Pose((0.0, 0.0, 0.2)), ground=True)
    world.step(990)
    assert not box.body.is_resting()
    world.step(100)
    assert box.body.is_resting()
    pose, touching = box.pose, box.body.touching()
    assert touching
    world.step(1000)
    assert box.pose == pose and box.body.touching() == touching
    box.body.apply_force(box.root, (50.0, 0.0, 0.0), box.pose.position)
    world.step()
    assert not box.body.is_resting() and box.pose != pose


def test_what_falls_on_a_sleeper_wakes_it(world):
    box = spawn(world, BOX, Pose((0.0, 0.0, 0.2)), ground=True)
    world.step(1500)
    assert box.body.is_resting()
    ball = world.spawn_urdf("ball", BALL, Pose((0.15, 0.0, 0.8)), str)
    world.step(200)
    assert box.body.is_resting()
    world.step(200)
    assert not box.body.is_resting() and ball.pose.position[2] < 0.55


def test_a_sleeper_keeps_its_contacts_when_others_come(world):
    """Of another step than the one in which a second box falls asleep; arrays are built anew."""
    first = spawn(world, BOX, Pose((0.0, 0.0, 0.2)), ground=True)
    world.step(300)
    second = world.spawn_urdf("second", BOX, Pose((2.0, 0.0, 0.2)), str)
    world.step(1200)
    assert first.body.is_resting() and second.body.is_resting()
    world.spawn_urdf("ball", BALL, Pose((5.0, 0.0, 0.8)), str)
    world.step()
    for box, x in ((first, 0.0), (second, 2.0)):
        contacts = box.body.contacts(box.root)
        assert np.mean([each.position for each in contacts], axis=0)[0] == pytest.approx(x, abs=0.2)
        assert len(contacts) == 3 and sum(each.force[2] for each in contacts) > 0.0


def test_shapes_that_the_solver_knows_need_no_mirror_when_they_fall_asleep(world):
    """A pile, of which one falls asleep now and then and is woken by what touches it."""
    spawn(world, BOX, Pose((0.0, 0.0, 0.2)), ground=True)
    for number, x in enumerate((0.0, 0.05, 0.45, 0.5)):
        world.spawn_urdf(f"b{number}", BOX, Pose((x, 0.0, 0.61 + 0.41 * number)), str)
    world.step(4000)
    assert not world.engine.has_mirror


def test_a_sleeper_whose_support_is_deleted_falls(world):
    world.spawn_sdf("stand", static("<box><size>2 2 1</size></box>"), Pose((0.0, 0.0, 0.5)), str)
    box = spawn(world, BOX, Pose((0.0, 0.0, 1.2)))
    world.step(1500)
    assert box.body.is_resting()
    world.delete("stand")
    world.step(100)
    assert box.pose.position[2] < 1.16


HELD = '<joint name="j" type="fixed"><parent>l</parent><child>other</child></joint>'


@pytest.mark.parametrize(
    "inside, more",
    [
        ("", "<allow_auto_disable>false</allow_auto_disable>"),
        ("", f'<link name="other"/>{HELD}'),
        ('<sensor type="ray" name="s"/>', ""),
    ],
)
def test_what_must_not_or_has_joints_or_sensors_does_not_sleep(world, inside, more):
    text = (
        '<sdf version="1.6"><model name="m"><link name="l"><collision name="c"><geometry><box>'
        f"<size>1 1 1</size></box></geometry></collision>{inside}</link>{more}</model></sdf>"
    )
    world.spawn(sdf.ground_plane())
    box = world.spawn_sdf("box", text, Pose((0.0, 0.0, 0.5)), str)
    world.step(2500)
    assert not box.body.is_resting()


def test_a_saved_state_knows_who_sleeps(world):
    box = spawn(world, BOX, Pose((0.0, 0.0, 0.2)), ground=True)
    world.step(500)
    awake = world.save_state()
    world.step(1000)
    sleeping, touching = world.save_state(), box.body.touching()
    world.restore_state(awake)
    world.step(10)
    assert not box.body.is_resting()
    world.restore_state(sleeping)
    assert box.body.is_resting() and box.body.touching() == touching


# states -------------------------------------------------------------------------------------------
def bits(world):
    """All numbers of the world's state."""
    state = world.engine.save_state().data
    return [state[kind][body].tobytes() for kind in ("bodies", "joints") for body in state[kind]]


@pytest.mark.parametrize("mu, low, high", [(1.0, 0.2, 0.4), (4.0, 0.0, 0.05)])
def test_on_the_built_in_ground_the_friction_of_what_stands_there_counts(world, mu, low, high):
    """Gazebo's ground plane has mu 100, mu2 50, and the smaller coefficient counts."""
    tyre = f'<gazebo reference="base"><mu1>{mu}</mu1><mu2>{mu}</mu2></gazebo>'
    box = spawn(world, BOX.replace("</robot>", f"{tyre}</robot>"), Pose((0, 0, 0.2)), ground=True)
    for _ in range(500):
        foot = (*box.pose.position[:2], 0.01)
        box.body.apply_force(box.root, (1.2 * 9.81, 0.0, 0.0), foot)
        world.step()
    assert low < box.pose.position[0] < high


def test_velocity_decays_also_after_a_state_was_restored(world):
    decay = '<gazebo reference="base"><dampingFactor>0.01</dampingFactor></gazebo>'
    text = BALL.replace("</robot>", f"{decay}</robot>")
    ball = world.spawn_urdf("ball", text, Pose((0.0, 0.0, 9.0)), str)
    world.step(100)
    saved = world.save_state()
    world.step(400)
    there = ball.pose
    _, _, (_, _, speed), _ = ball.body.link_motion(ball.root)
    assert speed == pytest.approx(-0.001 * 9.81 * 0.99 / 0.01, rel=0.02)  # as much as is gained
    world.restore_state(saved)
    world.step(400)
    assert ball.pose == there


def test_batches_and_a_reset_do_not_matter(world):
    world.spawn(sdf.ground_plane())
    car = world.spawn_urdf("racecar", published(CAR), Pose((0.0, 0.0, 0.05)), resolve)
    wheels = [name for name in car.joints.names if "wheel" in name]

    def story(batch):
        drive_velocities(car.joints, wheels, [10.0, 11.0, 12.0, 13.0])
        for _ in range(400 // batch):
            world.step(batch)
        return bits(world)

    first = story(400)
    world.reset()
    assert story(1) == first


def test_models_come_and_go_while_others_keep_their_states(world):
    world.spawn(sdf.ground_plane())
    text = robot(link("base", 1.0, shape='<sphere radius="0.1"/>'))
    one = world.spawn_urdf("one", text, Pose((0.0, 0.0, 0.1)), str)
    one.set_velocity((0.5, 0.0, 0.0))
    world.step(100)
    x = one.pose.position[0]
    world.spawn_urdf("two", text, Pose((0.0, 3.0, 0.1)), str)
    world.step(100)
    assert one.pose.position[0] > x + 0.02
    world.delete("one")
    world.step(100)
    assert world.model("two").pose.position == pytest.approx((0.0, 3.0, 0.1), abs=1e-3)
    world.model("two").set_state(Pose((1.0, 1.0, 2.0)))
    world.step(10)
    assert 1.98 < world.model("two").pose.position[2] < 2.0


def test_a_position_that_is_set_is_taken(world):
    text = robot(
        '<link name="world"/>', joint("held", "fixed", "world", "base"), link("base"), link("arm"),
        joint("hinge", "continuous", "base", "arm", axis="0 0 1"),
    )  # fmt: skip
    bot = spawn(world, text)
    bot.joints.set_positions({"hinge": 7.5})  # more than a rotation
    world.step(10)
    assert bot.joints.positions_of(("hinge",))[0] == pytest.approx(7.5, abs=1e-9)


# bad input ----------------------------------------------------------------------------------------
def test_an_unknown_solver_is_named():
    with pytest.raises(ModelError, match="solver is 'dart', must be ode or bullet"):
        make_engine("dart", 0.001, (0.0, 0.0, 0.0))


@pytest.mark.parametrize("count", [1, 2])
def test_joints_yield_by_their_cfm(world, count):
    """J v = error erp / h - cfm f: what hangs at rest has sunk by cfm f h / erp at each joint."""
    cfm, erp, mass = 2e-3, 0.2, 3.0
    world.engine.configure(replace(world.engine.settings, cfm=cfm, erp=erp))
    links = "".join(link(f"l{i}", mass, center="0 0 -0.3") for i in range(count))
    joints = "".join(
        joint(f"j{i}", "continuous", f"l{i - 1}" if i else "world", f"l{i}", "0 0 -0.5")
        for i in range(count)
    )
    model = spawn(world, robot('<link name="world"/>', links, joints), Pose((0.0, 0.0, 5.0)))
    world.step(6000)
    sunk = 0.0
    for i in range(count):
        sunk += cfm * (count - i) * mass * G * world.time_step / erp
        height = model.link_state(f"l{i}")[0].position[2]
        assert height == pytest.approx(5.0 - 0.5 * (i + 1) - sunk, abs=1e-7)


def test_models_are_spawned_without_the_arrays_of_all_others(monkeypatch):
    """Else a world's time to load grows with the square of its models."""
    built = []
    arm = robot(link("base"), link("tip"), joint("swing", "continuous", "base", "tip"))
    block = static("<box><size>1 1 1</size></box>")
    world = World()
    try:
        engine = world.engine
        build = engine._build_arrays
        monkeypatch.setattr(engine, "_build_arrays", lambda: (built.append(1), build())[1])
        for number in range(10):
            world.spawn_sdf(f"block{number}", block, Pose((2.0 * number, 0.0, 0.0)), str)
            world.spawn_urdf(f"arm{number}", arm, Pose((2.0 * number, 2.0, 0.0)), str)
        assert not built
        world.step()
        assert len(built) == 1
    finally:
        world.close()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_what_each_iteration_changes_is_in_whole_lines_of_the_cache(world, count):
    """Else steps take up to a sixth longer, as the memory happens to lie."""
    arm = robot(link("base"), link("tip"), joint("swing", "continuous", "base", "tip"))
    for number in range(count):
        world.spawn_urdf(f"arm{number}", arm, Pose((number, 0.0, 0.0)), str)
    world.step()
    blocks = world.engine.arrays.state.blocks
    for block in blocks.places[:count]:  # of each joint: where its bodies' accelerations are
        for place in block[1:3]:
            assert (blocks.work.ctypes.data + 8 * place) % 64 == 0, (count, block)
