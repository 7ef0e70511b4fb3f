"""Launches that several files share, and how each file finds their worlds.

A file says `from shared_worlds import CAR as LAUNCH`; its tests run where those of other files have
run before, so node_fixture.py resets the world first.
"""

import rospy
from sensor_msgs.msg import JointState
from sim_client import (
    CAR_COMMANDS,
    HINGES,
    START_LIMIT,
    WHEELS,
    Recorder,
    command_publishers,
    joint,
    wait_for_car,
    wait_running,
    wait_until,
)
from std_srvs.srv import Empty
from stepping import PHYSICS_STEP, Time
from truck_client import wait_for_truck

# state_rate is low: robot_state_publisher asks the master three times each time that it publishes.

# The car at its start; /cmd_vel drives it in ackermann mode, /original/cmd_vel in the original's.
CAR = """<launch>
  <include file="$(find track_model)/launch/world.launch">
    <arg name="headless" value="true"/>
    <arg name="lidar" value="false"/>
    <arg name="state_rate" value="5"/>
  </include>
  <include file="$(find deepracer_control)/launch/control.launch">
    <arg name="mode" value="ackermann"/>
  </include>
  <group ns="original">
    <remap from="/cmd_vel" to="/original/cmd_vel"/>
    <include file="$(find deepracer_control)/launch/control.launch">
      <arg name="mode" value="original"/>
    </include>
  </group>
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""

# The car with lidar and a small camera, driven in the original's units, and a referee.
SEEING_CAR = """<launch>
  <include file="$(find track_model)/launch/world.launch">
    <arg name="headless" value="true"/>
    <arg name="camera_width" value="160"/>
    <arg name="camera_height" value="121"/>
    <arg name="camera_rate" value="10"/>
    <arg name="state_rate" value="5"/>
  </include>
  <include file="$(find deepracer_control)/launch/control.launch"/>
  <include file="$(find track_model)/launch/referee.launch"/>
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""

# A robot with effort and velocity joints; which controllers run is what its tests start.
EFFORT_BOT = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
    <arg name="headless" value="true"/>
  </include>
  <param name="robot_description" textfile="$(find paddock_tests)/ros/effort_bot.urdf"/>
  <rosparam file="$(find paddock_tests)/ros/effort_controllers.yaml" command="load"/>
  <node name="spawn_bot" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -param robot_description -model effort_bot -z 0.1"/>
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""

# The truck with its trailer; its odometry is the truth, time waits for its commands.
TRUE_TRUCK = """<launch>
  <include file="$(find cybertruck)/launch/truck.launch">
    <arg name="world" value="$(find paddock_tests)/ros/coarse.world"/>
    <arg name="lidar" value="false"/>
    <arg name="odom_source" value="ground_truth"/>
    <arg name="yaw" value="-1.0"/>
    <arg name="headless" value="true"/>
    <arg name="lockstep" value="true"/>
  </include>
  <include file="$(find cybertruck)/launch/back_up.launch">
    <arg name="steering_map" value="$(find cybertruck)/config/steering_map.yaml"/>
  </include>
  <include file="$(find paddock_tests)/ros/pacer.launch">
    <arg name="topics" value="[/odom, /cmd_cyberdrive]"/>
    <arg name="settle" value="0.2"/>  <!-- below state_timeout -->
  </include>
</launch>
"""


def gazebo(name):
    """Calls one of the simulator's services without arguments."""
    rospy.wait_for_service(f"/gazebo/{name}", START_LIMIT)
    rospy.ServiceProxy(f"/gazebo/{name}", Empty)()


def reset_car():
    """Time goes on, wheels and hinges are commanded to 0, the car stands at its start."""
    gazebo("unpause_physics")
    wait_for_car()
    publishers = command_publishers()
    time = Time(CAR_COMMANDS, node=rospy.get_name())
    time.go(PHYSICS_STEP)  # what arrived until now counts no more
    for publisher in publishers.values():
        publisher.publish(0.0)
    time.go(PHYSICS_STEP, commands=1)  # else a late one would count as the next test's command
    time.close()
    joints = Recorder("/racecar/joint_states", JointState)
    wait_until(lambda: stands(joints.newest), "wheels and hinges at 0")
    gazebo("restart")
    for item in [joints, *publishers.values()]:
        item.close() if item is joints else item.unregister()


def stands(message):
    """Whether wheels are at rest and hinges straight, by joint states."""
    return all(abs(joint(message, f"{name}_joint")[1]) < 0.01 for name in WHEELS) and all(
        abs(joint(message, f"{name}_joint")[0]) < 0.01 for name in HINGES
    )


def reset_effort_bot():
    """The robot is where it was spawned, without controllers."""
    wait_running("/effort_bot", 0)
    gazebo("restart")


def reset_truck():
    """The truck is where it was spawned, and its drive node goes on from there."""
    wait_for_truck()
    gazebo("restart")
    wait_for_truck()


RESETS = {
    "CAR": reset_car,
    "SEEING_CAR": reset_car,
    "EFFORT_BOT": reset_effort_bot,
    "TRUE_TRUCK": reset_truck,
}
