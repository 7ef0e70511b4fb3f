"""Rates of sensors whose period is no multiple of the physics step, as Gazebo's.

The threads of sensors/SensorManager.cc that update rays and others sleep for a period of their
fastest sensor, and wake in the step in which it has passed. Cameras are updated apart, and
Sensor::Update makes up for what was late; hector's UpdateTimer has its times since the start.
"""

import pytest
from bullet_sim.parts import base
from bullet_sim.parts.base import PARTS, PartContext
from bullet_sim.plugins import contacts, inertial, lidars
from bullet_sim.pose import Pose
from bullet_sim.world import World

STEP = 0.01
RAY = (
    "<ray><scan><horizontal><samples>3</samples></horizontal></scan>"
    "<range><min>0.1</min><max>9</max></range></ray>"
)
SENSORS = {  # plugin of a <sensor>: its type, tags
    "gazebo_ros_laser": ("ray", RAY),
    "gazebo_ros_gpu_laser": ("gpu_ray", RAY),
    "gazebo_ros_block_laser": ("ray", RAY),
    "gazebo_ros_velodyne_laser": ("ray", RAY),
    "gazebo_ros_range": ("ray", RAY),
    "hector_gazebo_ros_sonar": ("ray", RAY),
    "gazebo_ros_imu_sensor": ("imu", ""),
    "gazebo_ros_bumper": ("contact", "<contact><collision>base_collision</collision></contact>"),
}
URDF = """<robot name="r"><link name="base">
<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
<collision><geometry><box size="1 1 1"/></geometry></collision></link>
<gazebo reference="base"><sensor name="s" type="{type}"><update_rate>40</update_rate>{tags}
<plugin name="p" filename="lib{library}.so"><frameName>base</frameName>
<updateRateHZ>40</updateRateHZ><updateRate>40</updateRate></plugin></sensor></gazebo></robot>"""
# Plugins that have a rate and are no sensor of Gazebo's: they keep the mean.
OTHERS = {"BiasedImuSensor", "GpsSensor", "MagneticSensor", "JointStatesSensor", "LinkForceSensor"}


KEEP_THE_MEAN = {"gazebo_ros_gpu_laser", "hector_gazebo_ros_sonar"}  # a camera; an UpdateTimer


class Sender:
    """Has a subscriber; keeps the times of messages."""

    def __init__(self, times):
        self._times = times

    def has_subscribers(self):
        return True

    def send(self, time, *_values, **_options):
        self._times.append(round(time, 9))


def messages(library, seconds):
    """Times of a sensor's messages [s], and its nominal rate [Hz]."""
    kind, tags = SENSORS[library]
    world, times = World(STEP, (0.0, 0.0, 0.0)), []
    model = world.spawn_urdf(
        "r", URDF.format(type=kind, tags=tags, library=library), Pose((0.0, 0.0, 9.0)), str
    )
    (spec,) = model.description.sensors
    context = PartContext(world, model, spec, connect=lambda _output: Sender(times))
    part = PARTS[type(spec)](context)
    part.reset(0.0)
    part.schedule.check_subscribers(0)
    while world.time < seconds - STEP / 2:
        world.step()
        if part.schedule.due(world.step_count):
            part.update(world.time, world.time - part.updated)
            part.updated = world.time
    world.close()
    return times, part.nominal_rate


@pytest.mark.parametrize("library", SENSORS)
def test_periods_are_whole_steps_but_of_cameras(library):
    times, nominal = messages(library, 0.6)
    if library in KEEP_THE_MEAN:
        assert nominal == 40.0 and len(times) == 24
        return
    assert nominal == pytest.approx(100.0 / 3.0)
    assert times == pytest.approx([0.03 * number for number in range(1, 21)])


def test_each_sensor_is_listed():
    """Of the table above, a camera, or one whose own source has another rule."""
    tested = {contacts.ContactSensor, inertial.ImuSensor, *_below(lidars.RaysSensor)}
    for part in PARTS.values():
        if issubclass(part, base.Sensor) and part.reports and not part.takes_images:
            known = part in tested or part.whole_periods or part.__name__ in OTHERS
            assert known, f"{part.__name__}: which rule has its rate?"


def _below(kind):
    return {kind, *(each for child in kind.__subclasses__() for each in _below(child))}
