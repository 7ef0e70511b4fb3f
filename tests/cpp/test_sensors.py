"""Plugins of sensors in C++: what Gazebo's sensors tell of Paddock's world, and when."""

import math
import re

import pytest

SDF = """<sdf version="1.6"><model name="thing"><pose>0 0 1 0 0 0</pose>
<link name="link"><inertial><mass>2</mass>
<inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>
<collision name="hull"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision>
{}</link>{}</model></sdf>"""
SENSOR = """<sensor name="eye" type="{0}"><always_on>1</always_on><update_rate>{2}</update_rate>{1}
<plugin name="p" filename="libacting_sensor.so">{3}</plugin></sensor>"""
RAY = """<pose>0.2 0 0 0 0 0</pose><ray><scan><horizontal><samples>3</samples>
<resolution>1</resolution><min_angle>-0.5</min_angle><max_angle>0.5</max_angle></horizontal></scan>
<range><min>0.1</min><max>5</max></range></ray>"""
CONTACT = "<contact><collision>hull</collision></contact>"
# A wall whose near side is at x = 3 m, made before the first step, and nothing falls.
WALL = """
if world.step_count == 0:
    world.spawn_sdf("wall", '<sdf version="1.6"><model name="wall"><static>1</static>'
        '<link name="l"><collision name="c"><geometry><box><size>1 1 9</size></box></geometry>'
        '</collision></link></model></sdf>', Pose((3.5, 0.0, 0.0)), lambda uri: uri)
"""
FLOOR = WALL.replace("1 1 9", "9 9 1").replace("(3.5, 0.0, 0.0)", "(0.0, 0.0, 0.4)")


def told(output, name="eye"):
    """Times and numbers of what a sensor told."""
    lines = [line.split()[1:] for line in output.splitlines() if re.match(rf"{name} \d", line)]
    return [[float(word) for word in line] for line in lines]


def model(kind, inside="", rate=0, plugin="", after=""):
    return SDF.format(SENSOR.format(kind, inside, rate, plugin), after)


def held(text):
    return text.replace('<link name="link">', '<link name="link"><gravity>0</gravity>')


@pytest.fixture
def steps(steps_of):
    """Function that makes steps of a model: what was printed."""

    def made(text, count=20, code=""):
        status, output = steps_of(text, count, code)
        assert status == 0, output
        return output

    return made


def test_a_lidar_sees_what_is_there(steps):
    scans = told(steps(held(model("ray", RAY, 100)), 40, WALL))
    assert [scan[0] for scan in scans[:3]] == pytest.approx(
        [scans[0][0] + k / 100 for k in range(3)]
    )
    right, front, left = scans[-1][1:]
    assert front == pytest.approx(2.8, abs=1e-6)
    assert (right, left) == (math.inf, math.inf)  # past the wall's edges


def test_an_imu_tells_gravity_at_rest_and_nothing_in_free_fall(steps):
    falling = told(steps(model("imu", "", 100), 50))
    assert falling[-1][1:4] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    resting = told(steps(model("imu", "", 100), 600, FLOOR))
    assert resting[-1][1:4] == pytest.approx([0.0, 0.0, 9.81], abs=1e-3)


def test_contacts_carry_the_weight(steps):
    last = told(steps(model("contact", CONTACT, 0), 1500, FLOOR))[-1]
    assert last[1] == 1
    assert abs(last[2]) == pytest.approx(2 * 9.81, rel=2e-2)
    assert last[3] == 0.0  # the floor never moves


BASE = (
    FLOOR
    + """
    world.spawn_sdf("base", '<sdf version="1.6"><model name="base"><link name="l"><inertial>'
        '<mass>5</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>'
        '<collision name="c"><geometry><box><size>1 1 0.1</size></box></geometry></collision>'
        '</link></model></sdf>', Pose((0.0, 0.0, 0.951)), lambda uri: uri)
    model.set_state(Pose((0.0, 0.0, 1.102)))
"""
)


def test_contacts_of_two_that_move_tell_both_wrenches(steps):
    last = told(steps(model("contact", CONTACT, 0), 1500, BASE))[-1000:]
    assert sum(abs(force) for *_, force, _ in last) / 1000 == pytest.approx(2 * 9.81, rel=0.05)
    for *_, force, back in last:
        assert back == pytest.approx(-force, rel=1e-3)


JOINED = SDF.replace(
    "{}</link>{}",
    """</link>
<link name="arm"><inertial><mass>3</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz>
</inertia></inertial></link><joint name="world" type="fixed"><parent>world</parent>
<child>link</child></joint><joint name="hinge" type="revolute"><parent>link</parent>
<child>arm</child><axis><xyz>0 0 1</xyz></axis>{}</joint>""",
)


def test_a_sensor_of_a_joint_tells_what_it_carries(steps):
    last = told(steps(JOINED.format(SENSOR.format("force_torque", "", 100, "")), 300))[-1]
    # of the child on its parent, in the child's axes, as Gazebo has it by default
    assert last[1:4] == pytest.approx([0.0, 0.0, -3 * 9.81], abs=0.05)
    assert last[4:7] == pytest.approx([0.0, 0.0, 0.0], abs=0.05)


@pytest.mark.parametrize("kind", ["gps", "altimeter", "magnetometer"])
def test_other_sensors_of_gazebo_tell(steps, kind):
    assert len(told(steps(held(model(kind, "", 50)), 100))) == 5


GONE = """
if world.step_count == 20:
    world.delete("thing")
    world.step(40)
    print("gone", len(world.models))
    raise SystemExit
"""


def test_a_model_that_goes_takes_its_sensors_along(steps):
    output = steps(held(model("ray", RAY, 100)), 30, GONE)
    assert "gone 0" in output
    assert len(told(output)) == 2


def test_a_rate_is_in_whole_steps(steps):
    times = [scan[0] for scan in told(steps(held(model("ray", RAY, 300)), 40))]
    gaps = {round(1000 * (later - sooner)) for sooner, later in zip(times, times[1:])}
    assert gaps == {4}


def test_a_plugin_of_a_model_finds_sensors_that_have_none(steps):
    text = SDF.format(
        SENSOR.format("ray", RAY, 100, "").replace(' filename="libacting_sensor.so"', ""),
        '<plugin name="s" filename="libacting_seeker.so"><sensor>eye</sensor></plugin>',
    )
    text = re.sub(r'<plugin name="p">.*?</plugin>', "", text)
    output = steps(held(text), 40, WALL)
    assert "found 1" in output
    assert re.search(r"sought 0\.\d+ inf", output)  # of the ray that passes the wall


def test_what_throws_or_is_not_there_is_named(steps_of):
    status, output = steps_of(held(model("ray", RAY, 100, "<throw/>")), 3)
    assert status != 0
    assert "sensor 'eye' with plugin 'p' is not made: it has thrown" in output
    assert "no lens" in output
    status, output = steps_of(held(model("camera", "<camera/>", 30)), 3)
    assert status != 0
    assert "sensors of type 'camera' need Gazebo's renderer" in output
