"""A world that goes on from a saved state goes on, to the bit, as if it had never stopped."""

import math
import shutil

import numpy as np
import pytest
from bullet_sim.errors import WorldError
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.pose import Pose
from bullet_sim.world import World
from contact_scenes import ground, nowhere, sdf_box, skid_base, world_of
from fake_joints import COVARIANCES
from test_effort_physics import URDF

STEPS = 300
DIFF = {
    "type": "diff_drive_controller/DiffDriveController",
    **COVARIANCES,
    "left_wheel": ["fl", "rl"],
    "right_wheel": ["fr", "rr"],
    "wheel_separation": 0.6,
    "wheel_radius": 0.2,
    "velocity_rolling_window_size": 7,
    "linear": {"x": {"has_acceleration_limits": True, "max_acceleration": 0.4}},
}


def bits(world):
    """All that can be measured of a world, as bytes."""
    parts = [[world.step_count]]
    for model in world.models.values():
        for part in model.rigid_parts:
            parts += model.body.link_motion(part)
        parts += [] if model.is_static else model.joints.arrays()[:2]
        if model.manager is not None:
            parts.append([model.manager.time])
            for controller in model.manager.controllers():
                odometry = getattr(controller, "odometry", None)
                parts += [] if odometry is None else [[odometry.x, odometry.y, odometry.linear]]
                parts += [(pid.integral, pid.error, pid.output) for pid in controller.pids]
    return np.hstack([np.ravel(np.asarray(part, float)) for part in parts]).tobytes()


def trace(world, act, steps=STEPS, start=0):
    """What is measured after each step, with something done before each."""
    found = []
    for number in range(start, start + steps):
        act(world, number)
        world.step()
        found.append(bits(world))
    return found


def difference(one, other):
    """Number of the first step after which two traces differ, or None."""
    return next((n for n, pair in enumerate(zip(one, other)) if pair[0] != pair[1]), None)


def stays(make, act, before=STEPS, exact=True, disturb=lambda world: None):
    """Compare a world that was saved and restored with one that was not.

    Args:
        make: function -> World.
        act: function of the world and a step's number, done before the step.
        before: steps before the state is saved.
        exact: saving itself must not change anything.
        disturb: function of the world, done before it is restored.
    """
    never = make()
    trace(never, act, before)
    expected = trace(never, act, start=before)
    never.close()
    world = make()
    trace(world, act, before)
    state = world.save_state()
    first = trace(world, act, start=before)
    if exact:
        assert first == expected
    for _ in range(2):
        disturb(world)
        assert world.restore_state(state) == ""
        assert difference(trace(world, act, start=before), first) is None
    world.close()


def push(world, number):
    """Push and turn all that moves."""
    for place, model in enumerate(world.models.values()):
        if not model.is_static:
            force = (3 * math.sin(0.05 * number + place), 2 * math.cos(0.03 * number), 0)
            model.apply_wrench(model.root, force, (0, 0, 0.2))


def twin_box(name):
    """ModelDescription of a link of two boxes that touch the same things."""
    shapes = "".join(
        f'<collision name="c{x}"><pose>{x} 0 0 0 0 0</pose><geometry><box><size>0.2 0.2 0.2</size>'
        "</box></geometry></collision>"
        for x in (0.0, 0.3)
    )
    text = f'<sdf version="1.6"><model name="{name}"><link name="l">{shapes}</link></model></sdf>'
    return parse_model(text, nowhere, name)[0]


def boxes(*heights, make=lambda name: sdf_box(name, (0.2, 0.2, 0.2))):
    """Function that makes a world of boxes at heights [m] above each other."""

    def world():
        rows = [(make(f"b{n}"), Pose((0.02 * n, 0.01 * n, z))) for n, z in enumerate(heights)]
        return world_of((ground(), None), *rows)

    return world


@pytest.mark.parametrize(
    "make, exact",
    [
        (boxes(0.1, 0.302, 0.504), True),
        (boxes(0.101, 0.1), False),  # saved while one is pushed out of the other
        (boxes(1.5), True),  # in the air: no contact is saved, and there are some when it returns
        (boxes(0.1, 0.302, make=twin_box), False),
        (boxes(0.05, make=twin_box), False),
    ],
)
def test_boxes_that_touch(make, exact):
    stays(make, push, exact=exact)


def test_a_box_on_its_way_out_of_the_ground():
    def sink(world):
        world.step(700)
        world.models["b0"].set_state(Pose((1.0, 0.0, 0.0)))
        world.step(20)

    stays(boxes(0.0), push, before=40, exact=False, disturb=sink)


def skid():
    """World of a skid-steered base with limits and odometry."""
    base = skid_base(20.0, 0.3, 0.3, 0.2, 1.0)
    base.control_namespace = ""
    return world_of((ground(), None), (base, Pose((0, 0, 0.2))))


def with_controllers():
    """World of an arm and a slider under PIDs of all kinds."""
    world = World()
    manager = world.spawn_urdf("bot", URDF, Pose(), str).manager
    pid = {"p": 40.0, "i": 30.0, "d": 2.0, "i_clamp": 3.0}
    manager.load("a", {"type": "effort_controllers/JointPositionController", "joint": "arm",
                       "pid": pid})  # fmt: skip
    manager.load("s", {"type": "effort_controllers/JointVelocityController", "joint": "slider",
                       "pid": pid})  # fmt: skip
    manager.switch(["a", "s"], [])
    return world


def swing(world, number):
    """Command both joints now and then."""
    if number % 50 == 0:
        manager = world.models["bot"].manager
        manager.command("a", [math.sin(number)])
        manager.command("s", [0.3 * math.cos(number)])


def test_pids_go_on_with_their_integrals():
    def stop(world):
        manager = world.models["bot"].manager
        manager.switch([], ["a", "s"])
        world.step(50)

    stays(with_controllers, swing, disturb=stop)


def test_a_base_goes_on_with_limits_odometry_and_slip():
    def drive(world, number):
        manager = world.models["skid"].manager
        if number == 0:
            manager.load("d", DIFF)
            manager.switch(["d"], [])
        if number % 100 == 0:
            manager.command("d", (0.5 - 0.002 * number, 1.0))

    def elsewhere(world):
        world.models["skid"].set_state(Pose((4.0, 1.0, 0.25), (0.0, 0.0, 1.0, 0.0)))
        world.step(100)

    stays(skid, drive, disturb=elsewhere)


def test_a_reset_in_between_changes_nothing():
    stays(with_controllers, swing, disturb=World.reset)
    stays(boxes(0.1, 0.302), push, disturb=World.reset)


def test_forces_that_act_for_a_time_go_on():
    def pull(world, number):
        if number == 250:
            box = world.models["b0"]
            world.forces.apply_wrench(box, "l", (4.0, 0, 0), (0, 0, 0), (250, 420))

    stays(boxes(0.1), pull, disturb=lambda world: world.forces.clear())


def test_a_motion_goes_on_and_the_goal_of_the_present_is_cancelled():
    from bullet_sim.controllers.segments import Command, Goal, Point

    world, ends = World(), []
    manager = world.spawn_urdf("bot", URDF, Pose(), str).manager
    manager.load("t", {"type": "position_controllers/JointTrajectoryController",
                       "joints": ["arm"]})  # fmt: skip
    manager.switch(["t"], [])
    arm = manager.get("t")

    def execute(name, position):
        goal = Goal(lambda outcome, code, text: ends.append((name, outcome)))
        arm.execute(Command(("arm",), (Point(0.6, (position,)),)), goal)

    execute("first", 1.0)
    world.step(200)
    state = world.save_state()
    expected = trace(world, lambda *_: None)
    execute("second", -1.0)
    world.step(100)
    world.restore_state(state)
    assert ends == [("first", "canceled"), ("second", "canceled")]
    assert difference(trace(world, lambda *_: None), expected) is None
    assert arm.goal is None
    world.close()


def spawn(world):
    world.spawn(sdf_box("new", (0.1, 0.1, 0.1)), Pose((3, 0, 1)))


def replace(world):
    world.delete("b0")
    world.spawn(sdf_box("b0", (0.2, 0.2, 0.2)), Pose((0, 0, 0.1)))


def other_step(world):
    world.set_time_step(0.002)


@pytest.mark.parametrize(
    "change, words",
    [
        (spawn, "model 'new' was spawned since"),
        (lambda world: world.delete("b0"), "the model 'b0', which was deleted since"),
        (replace, "model 'b0' was deleted and spawned again"),
        (other_step, "the physics step is 0.002 s, and was 0.001 s"),
    ],
)
def test_a_state_of_other_models_is_refused(change, words):
    world = boxes(0.1, 0.302)()
    world.step(10)
    state = world.save_state()
    change(world)
    world.step(5)
    before = bits(world)
    with pytest.raises(WorldError, match=words):
        world.restore_state(state)
    assert bits(world) == before
    world.close()


def test_controllers_that_came_or_went_are_named():
    world = with_controllers()
    state = world.save_state()
    manager = world.models["bot"].manager
    manager.switch([], ["a"])
    manager.unload("a")
    with pytest.raises(WorldError, match="controllers of 'bot' .* they were a, s and are s"):
        world.restore_state(state)
    world.close()


def test_a_state_before_deletions_survives_the_deletion_but_not_a_reset():
    world = boxes(0.1, 0.302, 0.504)()
    world.delete("b0")
    world.step(300)
    state = world.save_state()
    expected = trace(world, push)
    world.restore_state(state)
    assert difference(trace(world, push), expected) is None
    world.reset()
    with pytest.raises(WorldError, match="had been deleted before the state was saved"):
        world.restore_state(state)
    world.close()


def test_saving_needs_no_disk(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    world = boxes(0.1)()
    (folder,) = tmp_path.iterdir()
    shutil.rmtree(folder)  # as bad as one on a full disk
    world.step(10)
    state = world.save_state()
    expected = trace(world, push)
    world.restore_state(state)
    assert difference(trace(world, push), expected) is None
    assert list(tmp_path.iterdir()) == []
    world.close()


@pytest.mark.parametrize("solver", ["bullet", "ode"])
def test_snapshots_have_what_is_static_where_it_is(solver):
    world = World(solver=solver)
    for name, static in (("wall", True), ("box", False)):
        box = sdf_box(name, (0.2, 0.2, 0.2), static=static)
        world.spawn(box, Pose((0.0, 2.0 * static, 0.5)))
    wall = world.models["wall"]

    def places():
        return {name: state.position for name, state in zip(world.models, world.snapshot().bodies)}

    world.step(10)
    first, state = places(), world.save_state()
    world.step(10)
    second = places()
    assert second["wall"] == first["wall"] and second["box"] != first["box"]
    assert world.snapshot().bodies[0] is world.snapshot().bodies[0], "it is read once"
    wall.set_state(Pose((5.0, 0.0, 0.5)))
    assert places()["wall"] == pytest.approx((5.0, 0.0, 0.5))
    moved = world.save_state()
    world.restore_state(state)
    for name, place in places().items():
        assert place == pytest.approx(first[name]), name
    world.restore_state(moved)
    assert places()["wall"] == pytest.approx((5.0, 0.0, 0.5))
    world.reset()
    assert places()["wall"] == pytest.approx((0.0, 2.0, 0.5))
    world.close()
