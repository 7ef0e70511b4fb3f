"""What /gazebo/reset_simulation and reset_world do to each plugin and controller, by its source.

Sources: gazebo_plugins and ros_controllers (noetic-devel), hector_gazebo_plugins, Gazebo 11.
"""

import pytest
from bullet_bridge.plugins.base import ROS_SIDE
from bullet_sim.controllers import CONTROLLERS, Controller
from bullet_sim.parts.base import PARTS, Part, Sensor

from bullet_bridge import plugins  # noqa: F401  enters all plugins

RESET = "its source has a Reset(), which both services call"
WAITS = "no Reset(): it keeps the time of its last update and waits for it"
NOTICES = "no Reset(): it notices that time went back, and begins anew"
CAMERA = "no Reset(): it notices; that of a multicamera waits, by its specification"
STEPS = "no Reset(), no time of its own: it does the same in each step, with what it was told"
EITHER = "some of its sources have a Reset(), by its specification; the others wait"
ONCE = "it prepares the model, again after a reset"

PLUGINS = {
    RESET: "ElevatorPlugin GpsSensor MagneticSensor BiasedImuSensor PedestrianPlugin WalkerPlugin "
    "ServoPlugin RandomVelocityPlugin ResetMessagePlugin CppPlugin",
    EITHER: "WheelDrivePlugin ManyWheelsPlugin",
    WAITS: "ForceMovePlugin ForceTorqueSensor ImuSensor ModelImuSensor PlanarMovePlugin "
    "TricyclePlugin",
    NOTICES: "BlockLaserSensor CloudSensor GroundTruthSensor JointStatesSensor "
    "JointTransformsSensor KobukiPlugin LidarSensor PatternSensor RangeSensor RootTransformSensor",
    CAMERA: "CameraSensor DepthCameraSensor RangeCameraSensor TriggeredCameraSensor",
    STEPS: "BuoyancyPlugin ContactSensor ForcePlugin GraspFixPlugin GripperPlugin HandOfGodPlugin "
    "HarnessPlugin JointPosesPlugin LiftDragPlugin LinkForceSensor VacuumGripperPlugin "
    "WheelSlipPlugin",
    ONCE: "InitialVelocityPlugin MimicPidPlugin ProjectorPlugin StandingWheelsPlugin",
}
HOW = {name: how for how, names in PLUGINS.items() for name in names.split()}
OF_CLASS = {part.__name__: (spec, part) for spec, part in (*PARTS.items(), *ROS_SIDE.items())}


def behaviour(spec, part):
    """(whether its class has a reset, whether it waits, whether its specification decides)."""
    own = {name for base in part.__mro__ if base not in (Part, Sensor) for name in vars(base)}
    return part.resets, part.waits_for_time or "go_back" in own, hasattr(spec, "resets")


@pytest.mark.parametrize("name", sorted(OF_CLASS))
def test_each_plugin_does_what_its_source_does(name):
    assert name in HOW, f"say in PLUGINS what a reset does to the source of {name}"
    resets, waits, by_specification = behaviour(*OF_CLASS[name])
    how = HOW[name]
    if how in (RESET, ONCE):
        assert resets
    elif how == EITHER:
        assert by_specification and waits
    elif how == CAMERA:
        assert waits and not (resets or OF_CLASS[name][0].waits)
    else:
        assert not (resets or by_specification) and waits == (how == WAITS)


def test_the_table_has_no_plugin_that_is_gone():
    assert set(HOW) == set(OF_CLASS)


# GazeboRosControlPlugin::Reset forgets the time of the last update alone; what controllers keep:
STAMPS = "the stamp of its command, or of its last movement, in the time of before"
PERIODS = "what it counts in periods, of which the next is the time since zero"
NOTHING = "its command, which has no stamp"
KEPT = {
    STAMPS: "diff_drive_controller ackermann_steering_controller steer_drive_controller "
    "four_wheel_steering_controller GripperActionController",
    PERIODS: "JointTrajectoryController JointStateController ImuSensorController "
    "ForceTorqueSensorController velocity_controllers/JointPositionController "
    "effort_controllers/JointPositionController JointGroupPositionController "
    "effort_controllers/JointVelocityController",
    NOTHING: "JointEffortController JointGroupEffortController JointGroupVelocityController "
    "position_controllers/ velocity_controllers/JointVelocityController",
}


@pytest.mark.parametrize("name", CONTROLLERS.names())
def test_each_controller_keeps_what_its_source_keeps(name):
    found = [how for how, names in KEPT.items() for part in names.split() if part in name]
    assert found, f"say in KEPT what a reset leaves of {name}"
    has_stamps = CONTROLLERS.find(name).go_back is not Controller.go_back
    assert has_stamps == (STAMPS in found)
