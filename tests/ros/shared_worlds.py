"""Launches that several files share, and how each file finds their worlds.

A file says `from shared_worlds import CAR as LAUNCH`; its tests run where those of other files have
run before, so node_fixture.py resets the world first.
"""

import rospy
from sensor_msgs.msg import JointState
from sim_client import (
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

# The car at its start; /cmd_vel drives it in ackermann mode, /original/cmd_vel in the original's.
CAR = """<launch>
  <include file="$(find track_model)/launch/world.launch">
    <arg name="headless" value="true"/>
    <arg name="lidar" value="false"/>
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


def gazebo(name):
    """Calls one of the simulator's services without arguments."""
    rospy.wait_for_service(f"/gazebo/{name}", START_LIMIT)
    rospy.ServiceProxy(f"/gazebo/{name}", Empty)()


def reset_car():
    """Time goes on, wheels and hinges are commanded to 0, the car stands at its start."""
    gazebo("unpause_physics")
    wait_for_car()
    publishers = command_publishers()
    for publisher in publishers.values():
        publisher.publish(0.0)
    joints = Recorder("/racecar/joint_states", JointState)
    wait_until(lambda: stands(joints.newest), "wheels and hinges at 0")
    gazebo("reset_simulation")
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
    gazebo("reset_simulation")


RESETS = {"CAR": reset_car, "EFFORT_BOT": reset_effort_bot}
