"""The states after recorded steps are those that single steps show."""

import numpy as np
import pytest
from bullet_sim.pose import Pose
from bullet_sim.world import World
from contact_scenes import ground, sdf_box, skid_base, world_of
from test_effort_physics import URDF

COUNT = 30
PID = {
    "type": "effort_controllers/JointPositionController",
    "joint": "arm",
    "pid": {"p": 20.0, "d": 1.0},
}


def falling():
    """A base on wheels, a box that falls on it, an arm under a PID, something that never moves."""
    base = skid_base(20.0, 0.3, 0.3, 0.2, 1.0)
    base.control_namespace = ""
    box = sdf_box("box", (0.2, 0.2, 0.2))
    world = world_of((ground(), None), (base, Pose((0.0, 0.0, 0.2))), (box, Pose((0.0, 0.0, 1.0))))
    manager = world.spawn_urdf("bot", URDF, Pose((3.0, 0.0, 1.0)), str).manager
    manager.load("arm", PID)
    manager.switch(["arm"], [])
    manager.command("arm", [1.0])
    return world


def shown(world):
    """Time, motions of links, positions, velocities and efforts of joints, as bytes."""
    parts = [[world.time]]
    for model in world.models.values():
        parts += [np.hstack(model.link_motion(link)) for link in model.link_names]
        parts += [] if model.is_static else model.joints.arrays()
    return np.hstack(parts).tobytes()


def test_each_recorded_step_shows_what_a_single_one_leaves():
    world, other = falling(), falling()
    single = []
    for _ in range(COUNT):
        other.step()
        single.append(shown(other))
    world.step(COUNT, records=True)
    found = []
    for step in range(1, COUNT + 1):
        world.show(step)
        found.append(shown(world))
    world.show(7)
    world.show_end()
    assert found == single and len(set(single)) == COUNT
    world.step(COUNT)
    other.step(COUNT)
    assert shown(world) == shown(other), "showing changes nothing of what follows"
    world.close()
    other.close()


def test_motions_of_recorded_steps_have_the_bits_of_link_motion():
    world, other = falling(), falling()
    world.step(COUNT, records=True)
    expected = {}
    for _ in range(COUNT):
        other.step()
        for name, model in other.models.items():
            for link in model.link_names:
                expected.setdefault((name, link), []).append(np.hstack(model.link_motion(link)))
    for (name, link), rows in expected.items():
        motion = world.models[name].recorded_motion(link)
        found = np.vstack([np.array(part) for part in motion]).T
        assert found.tobytes() == np.array(rows).tobytes(), (name, link)
    world.close()
    other.close()


def test_a_body_that_is_nowhere_has_no_recorded_motions():
    world = falling()
    world.models["box"].body.set_pose((np.nan,) * 3, (np.nan,) * 4)
    world.step(3, records=True)
    assert world.models["bot"].recorded_motion("stand") is None
    world.close()


def test_what_does_not_record_says_so():
    bullet = World(solver="bullet")
    assert bullet.most_recorded == 0
    bullet.close()
    world = falling()
    assert world.most_recorded > 1
    world.stepper = world.engine.step  # which makes each step by itself
    assert world.most_recorded == 0
    world.close()


@pytest.mark.parametrize("steps, indices", [([11, 12], slice(0, 2)), ([11, 13], [0, 2])])
def test_recorded_steps_are_chosen_by_their_numbers(steps, indices):
    world = falling()
    world.step(10)
    world.step(5, records=True)
    assert world.recorded(steps) == indices
    assert world.times(steps) == [step * world.time_step for step in steps]
    world.close()
