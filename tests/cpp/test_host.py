"""What a plugin in C++ does to a model is what the same calls of the engine do, to the bit."""

import re

import pytest

MODEL = """<sdf version="1.6"><model name="thing">
<link name="link"><gravity>0</gravity><pose>0.1 0 0 0 0 0</pose>
<inertial><pose>0 0 0.05 0 0 0.3</pose><mass>2</mass>
<inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.15</izz></inertia></inertial>
<collision name="c"><geometry><box><size>0.2 0.2 0.4</size></box></geometry></collision></link>
<link name="arm"><gravity>0</gravity><pose>0.5 0 0 0 0 0</pose><inertial><mass>1</mass>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>
<link name="cart"><gravity>0</gravity><pose>-0.5 0 0 0 0 0</pose><inertial><mass>1</mass>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>
<joint name="hinge" type="revolute"><parent>link</parent><child>arm</child>
<axis><xyz>0 0 1</xyz></axis></joint>
<joint name="slide" type="prismatic"><parent>link</parent><child>cart</child>
<axis><xyz>0 1 0</xyz></axis></joint>{}</model></sdf>"""
PLUGIN = '<plugin name="p" filename="lib{}.so"><kind>{}</kind><value>{}</value></plugin>'
MOTOR = "model.body.motor('hinge')"
CENTER = "model.body.link_center('link')"
# Kind of the plugin and its value -> what makes the same steps without one.
SAME = {
    ("force", 3.0): f"model.body.apply_force('link', (3.0, 0.0, 0.0), {CENTER})",
    ("torque", 0.3): f"model.body.apply_force('link', (0, 0, 0), {CENTER}, (0.0, 0.0, 0.3))",
    ("speed", 0.4): "model.set_velocity((0.4, 0.0, 0.0), model.link_state('link')[2])",
    ("effort", 0.2): f"{MOTOR}.add_effort(0.2)",
    ("joint_speed", 0.7): f"{MOTOR}.impose_velocity(0.7, 0.0)",
    ("motor", 0.7): f"{MOTOR}.track_velocity(0.7, 100.0)",
}


@pytest.fixture
def run(steps_of):
    """Function that makes steps of MODEL: exit status, and what was printed."""

    def made(plugin, steps=50, code="", model=MODEL):
        return steps_of(model.format(plugin), steps, code)

    return made


def states(output):
    """(name, numbers) of the states that were printed."""
    lines = [line.split() for line in output.splitlines() if re.match(r"\w+ -?0x", line)]
    return {name: [float.fromhex(number) for number in numbers] for name, *numbers in lines}


def flat(output):
    """All numbers of the states that were printed, by name and place."""
    return {(name, k): n for name, numbers in states(output).items() for k, n in enumerate(numbers)}


@pytest.mark.parametrize(("kind", "value"), SAME)
def test_it_acts_as_the_engine_does(run, kind, value):
    status, output = run(PLUGIN.format("acting_model", kind, value))
    expected = run("", code=SAME[kind, value])[1]
    assert status == 0, output
    assert len(states(expected)) == 3, expected
    assert flat(output) == pytest.approx(flat(expected), rel=1e-12, abs=1e-14)
    again = run(PLUGIN.format("acting_model", kind, value))[1]
    assert states(output) == states(again)  # to the bit


def test_a_joint_is_put_where_a_plugin_says(run):
    state = states(run(PLUGIN.format("acting_model", "joint_position", 0.25))[1])
    assert state["hinge"][0] == pytest.approx(0.25, abs=1e-9)
    state = states(run(PLUGIN.format("acting_model", "slide_speed", 0.5))[1])
    assert state["slide"] == pytest.approx([0.5 * 0.05, 0.5], rel=1e-2)


def test_a_pose_counts_in_the_same_step(run):
    x, y, z, *_ = states(run(PLUGIN.format("acting_model", "pose", 7.0), steps=20)[1])["state"]
    assert (x, y, z) == pytest.approx((7.1, 2.0, 3.0), abs=3e-3)


def test_the_joint_controller_of_gazebo_acts(run):
    state = states(run(PLUGIN.format("acting_model", "pid", 5.0), steps=400)[1])
    assert state["hinge"][1] == pytest.approx(1.0, rel=1e-3)


def test_gazebos_own_plugins_act(run):
    plugin = """<plugin name="p" filename="libJointControlPlugin.so"><controller type="velocity">
    <joint>hinge</joint><target>0.7</target><pid_gains>5 0 0</pid_gains></controller></plugin>"""
    state = states(run(plugin, steps=400)[1])
    assert state["hinge"][1] == pytest.approx(0.7, rel=1e-3)


LOAD = """
if world.step_count == 0:
    world.spawn_sdf("load", '<sdf version="1.6"><model name="load"><link name="l">'
        '<gravity>0</gravity><inertial><mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia>'
        '</inertial></link></model></sdf>', Pose((0.1, 0.0, 1.05)), lambda uri: uri)
"""


@pytest.mark.parametrize("detached", [0, 1])
def test_a_joint_that_a_plugin_makes_holds_until_it_is_detached(run, detached):
    alone = MODEL.partition('<link name="arm">')[0] + "{}</model></sdf>"
    push = f"\nif 10 <= world.step_count < 40: {SAME['force', 3.0]}"
    told = "\nif world.step_count == 99: print('load', world.models['load'].link_state('l')[1][0])"
    stopped = "\nif world.step_count == 60: model.set_velocity((0, 0, 0), (0, 0, 0))"
    code = LOAD + push + (stopped if detached else "") + told
    output = run(PLUGIN.format("acting_model", "weld", detached), 100, code, alone)[1]
    load = next(float(line.split()[1]) for line in output.splitlines() if line.startswith("load"))
    # 3 N for 30 ms on 2 kg and 2 kg; what is let go keeps its speed when the other is stopped
    assert load == pytest.approx(3.0 * 0.03 / 4.0, rel=0.02)
    state = states(output)["state"]
    assert state[7] == pytest.approx(0.0 if detached else load, abs=1e-4)


def test_a_joint_that_a_plugin_makes_has_a_motor(run):
    alone = MODEL.partition('<link name="arm">')[0] + "{}</model></sdf>"
    output = run(PLUGIN.format("acting_model", "crane", 0), 400, LOAD, alone)[1]
    last = [line for line in output.splitlines() if line.startswith("crane")][-1].split()
    assert float(last[2]) == pytest.approx(1.0, rel=1e-3)
    assert float(last[1]) == pytest.approx(0.39, abs=0.01)


@pytest.mark.parametrize(("kind", "place"), [("insert", (3.0, 5.0)), ("factory", (4.0, 6.0))])
def test_models_that_a_plugin_inserts_and_removes_are_the_solvers(run, kind, place):
    told = "\nif 'dropped' in world.models: print('there', world.step_count, flush=True)"
    output = run(PLUGIN.format("acting_model", kind, 0), 60, told)[1]
    lines = [line.split() for line in output.splitlines() if line.startswith("dropped")]
    x, first = float(lines[0][2]), int(lines[0][1])
    assert 5 < first <= 8, output
    assert x == place[0]
    falling = {int(step): float(speed) for _, step, _, _, speed in lines}
    assert falling[40] == pytest.approx(-9.81 * 0.001 * (40 - first), abs=2e-6)
    heights = [float(line[3]) for line in lines]
    assert heights[0] == pytest.approx(place[1], abs=1e-4)
    there = [int(line.split()[1]) for line in output.splitlines() if line.startswith("there")]
    assert there[-1] in (40, 41)  # it has gone with the step in which it was removed


BATCH = """
calls, inner = [], world.stepper
world.stepper = lambda count=1, *rest: (calls.append(count), inner(count, *rest))[1]
world.step(100)
print("calls", calls)
world.stepper = inner
"""


@pytest.mark.parametrize(("kind", "calls"), [("still", [100]), ("tell", [1] * 100)])
def test_steps_are_made_together_where_no_plugin_is_called_at_each(run, kind, calls):
    output = run(PLUGIN.format("acting_model", kind, 0), 1, SAME["speed", 0.4] + BATCH)[1]
    assert f"calls {calls}" in output
    alone = run("", 1, SAME["speed", 0.4] + "\nworld.step(100)")[1]
    assert states(output) == states(alone)  # to the bit


def test_mass_and_gravity_are_changed(run):
    push = f"model.body.apply_force('link', (1.0, 0.0, 0.0), {CENTER})"
    alone = MODEL.partition('<link name="arm">')[0] + "{}</model></sdf>"
    heavy = run(PLUGIN.format("acting_model", "heavy", 8.0), code=push, model=alone)[1]
    assert states(heavy)["state"][7] == pytest.approx(50 * 0.001 / 8.0, rel=0.03)
    falling = alone.replace("<gravity>0</gravity>", "")
    held = run(PLUGIN.format("acting_model", "gravity", 0.0), model=falling)[1]
    assert states(held)["state"][9] == 0.0
    moon = run(PLUGIN.format("acting_model", "world_gravity", -1.6), model=falling)[1]
    assert states(moon)["state"][9] == pytest.approx(-1.6 * 0.05, rel=1e-9)


def test_a_plugin_reads_the_state_of_before_the_step(run):
    alone = MODEL.partition('<link name="arm">')[0] + "{}</model></sdf>"
    falling = alone.replace("<gravity>0</gravity>", "")
    output = run(PLUGIN.format("acting_model", "tell", 0.0), steps=3, model=falling)[1]
    told = [list(map(float, line.split()[1:])) for line in output.splitlines() if "told" in line]
    assert [line[1] for line in told] == pytest.approx([0.001, 0.002, 0.003], abs=1e-12)
    assert [line[3] for line in told] == pytest.approx([0.0, -9.81e-3, -19.62e-3], abs=1e-12)
    assert told[0][6] == pytest.approx(1.2)  # of the box around it


def test_without_physics_time_goes_on_and_nothing_moves(run):
    push = "model.set_velocity((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))"
    state = states(run(PLUGIN.format("acting_model", "physics_off", 0), code=push)[1])["state"]
    assert state[0] == pytest.approx(0.1 + 9 * 0.001, abs=1.1e-3)


def test_a_plugin_that_throws_is_named_and_unloaded(run):
    status, output = run(PLUGIN.format("acting_model", "throw", 0), code="")
    assert status == 0, output
    assert "plugin 'p' of model 'thing' (libacting_model.so): is unloaded" in output
    assert "no more fuel" in output


def test_a_plugin_that_does_not_return_is_named(run):
    status, output = run(PLUGIN.format("acting_model", "hang", 0))
    assert status == 0, output
    line = next(line for line in output.splitlines() if "has not returned" in line)
    assert re.search(r"plugin 'p' of model 'thing' \(libacting_model.so, in gazebo::Acting", line)


def test_a_crash_names_the_plugin(run):
    status, output = run(PLUGIN.format("acting_model", "crash", 0))
    assert status != 0
    line = next(line for line in output.splitlines() if "[FATAL]" in line)
    assert re.search(r"Segmentation fault in plugin 'p' of model 'thing' \(libacting_model", line)


def test_a_missing_symbol_is_named_with_its_class(run):
    status, output = run(PLUGIN.format("acting_broken", "", 0))
    assert status != 0
    assert re.search(r"plugin 'p' is not loaded: .*undefined symbol: .*gazebo::Nowhere", output)
