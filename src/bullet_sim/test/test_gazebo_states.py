"""Solver 'ode': robots are where real Gazebo 11.1 had them, step by step (gazebo_states.py)."""

import gazebo_states
import numpy as np
import pytest
from bullet_sim.formats.sdf.world import parse_world
from bullet_sim.models.changes import set_joint_parameter
from bullet_sim.pose import Pose
from bullet_sim.world import World

RECORDED = gazebo_states.recorded()
TOLERANCE = 1e-6  # [m], of quaternions: 1; contacts let rounding grow


def drive(world, model, commands, steps=gazebo_states.STEPS):
    """Yield (step, poses of the links' centers) at each recorded step, with a robot's commands."""
    efforts, planar = {}, None
    for step in range(steps):
        for at, joint, kind, value, effort in commands:
            if at != step:
                continue
            if kind == "velocity":
                model.body.motor(joint).track_velocity(value, effort)
            elif kind == "imposed":
                model.body.motor(joint).impose_velocity(value, effort)
            elif kind == "planar":
                planar = (value, 0.0, 0.0), (0.0, 0.0, effort)
            elif kind == "position":
                model.body.motor(joint).track_position(value, 0.0, 1e9)
            else:
                efforts[joint] = value
        for joint, effort in efforts.items():
            model.body.motor(joint).add_effort(effort)
        if planar:
            model.body.set_velocity(*planar)
        world.engine.step()
        if (step + 1) % gazebo_states.EVERY == 0:
            yield step + 1, model.body.rows[:, :7].copy()  # position, quaternion


def differences_of(name, folder, start):
    """Step -> largest difference from Gazebo, of a robot that starts a little higher."""
    urdf, height, commands = gazebo_states.ROBOTS[name]
    world = World(solver="ode", gravity=gazebo_states.GRAVITY)
    for model, sdf in (
        ("ground_plane", gazebo_states.ground(name)),
        ("crate", gazebo_states.crate(name)),
    ):
        if sdf:
            text = f'<sdf version="1.6">{sdf}</sdf>'.replace("{folder}", str(folder))
            world.spawn_sdf(model, text, Pose(), lambda uri: uri[7:])
    text, pose = urdf.replace("{folder}", str(folder)), Pose((start, 0.0, height + start))
    model = world.spawn_urdf("bot", text, pose, lambda uri: uri[7:])
    differences, steps = {}, gazebo_states.UNTIL.get(name, gazebo_states.STEPS)
    for step, found in drive(world, model, commands, steps):
        wanted = np.array(RECORDED[name][str(step)])
        differences[step] = difference(found[0], wanted)
    world.close()
    return differences


def difference(found, wanted):
    """The largest of two positions and quaternions, which may have the other sign."""
    found[3:] *= np.sign(found[3:] @ wanted[3:])
    return float(np.abs(found - wanted).max())


@pytest.mark.parametrize("name", gazebo_states.ROBOTS)
def test_robots_are_where_gazebo_has_them(name, tmp_path):
    gazebo_states.write_meshes(tmp_path)
    starts = gazebo_states.STARTS.get(name, (0.0,))
    found = [differences_of(name, tmp_path, start) for start in starts]
    assert min(max(each.values()) for each in found) < TOLERANCE, found


def spawned(name, text):
    """A world with the ground of a model and the model of a text."""
    world = World(solver="ode", gravity=gazebo_states.GRAVITY)
    for model, part in (("ground_plane", gazebo_states.ground(name)), ("bot", text)):
        world.spawn_sdf(model, f'<sdf version="1.6">{part}</sdf>', Pose(), str)
    return world, world.model("bot")


def differences_of_links(name, world, model):
    """(step, link) -> how far a link is from where Gazebo has it."""
    links = [link for link in model.rigid_parts if link != "world"]
    assert links
    steps, differences = gazebo_states.UNTIL.get(name, gazebo_states.STEPS), {}
    for step, found in drive(world, model, gazebo_states.MODELS[name][1], steps):
        for link, row in zip(links, found):
            row[3:] = model.link_state(link)[0].orientation  # the root's row has the model's
            wanted = np.array(RECORDED[name][str(step)][link])
            differences[step, link] = difference(row, wanted)
    return differences


@pytest.mark.parametrize("name", gazebo_states.MODELS)
def test_links_are_where_gazebo_has_them(name):
    world, model = spawned(name, gazebo_states.model(name))
    differences = differences_of_links(name, world, model)
    world.close()
    assert max(differences.values()) < TOLERANCE, differences


def windy(name):
    """A world with the wind and the model of one of WINDS."""
    parts = gazebo_states.ground(name) + gazebo_states.wind(name) + gazebo_states.model(name)
    world = World(solver="ode")
    text = f'<sdf version="1.6"><world name="w">{parts}</world></sdf>'
    assert not [each for each in world.load(parse_world(text, str)) if "wind" in each.lower()]
    return world, world.model("bot")


@pytest.mark.parametrize("name", gazebo_states.WINDS)
def test_links_are_where_gazebos_wind_has_them(name):
    world, model = windy(name)
    start, differences = world.save_state(), {}
    for again in range(2):  # a state has the wind's as well
        for step in range(gazebo_states.STEPS):
            world.step()
            if (step + 1) % gazebo_states.EVERY == 0:
                poses = model.body.rows[:, :7].copy()
                for link, row in zip(model.rigid_parts, poses):
                    row[3:] = model.link_state(link)[0].orientation
                    wanted = np.array(RECORDED[name][str(step + 1)][link])
                    differences[again, step + 1, link] = difference(row, wanted)
        world.restore_state(start)
    world.close()
    assert max(differences.values()) < TOLERANCE, differences


def test_erp_and_cfm_of_a_joint_can_be_set():
    name = "erp and cfm of joints"
    text = gazebo_states.model(name).replace("<erp>0.02</erp><cfm>0.001</cfm>", "")
    world, model = spawned(name, text)
    for joint in model.joints.names:
        set_joint_parameter(model, joint, "erp", 0.02)
        set_joint_parameter(model, joint, "cfm", 0.001)
    differences = differences_of_links(name, world, model)
    world.close()
    assert max(differences.values()) < TOLERANCE, differences
