"""The car of world.launch drives as the gym's does: the same commands at the same times."""

import math
import unittest

import rospy
from deepracer_control.ackermann import Geometry, wheel_commands
from deepracer_control.drivers.pursuit import Path, Pursuit
from gazebo_msgs.srv import GetModelState
from paddock_gym.envs.deepracer import DeepRacerEnv
from paddock_gym.envs.robot import REST
from sim_client import CAR_COMMANDS, START_LIMIT, command_publishers, wait_running
from stepping import Time

LAUNCH = """<launch>
  <include file="$(find track_model)/launch/world.launch">
    <arg name="headless" value="true"/>
    <arg name="lockstep" value="true"/>
    <arg name="state_rate" value="5"/>
  </include>
</launch>
"""
REAR_AXLE = -0.081663  # x in base_link [m]
SPEED, GRIP = 2.5, 4.0  # [m/s], [m/s^2]
TOLERANCE = 1e-9  # [m] and of a quaternion
GEOMETRY = Geometry()


class GymWorld(unittest.TestCase):
    """One lap of the default track."""

    def setUp(self):
        wait_running("/racecar", 7)
        self.publishers = command_publishers()
        self.time = Time(CAR_COMMANDS, node=rospy.get_name())
        rospy.wait_for_service("/gazebo/get_model_state", START_LIMIT)
        self.state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState, persistent=True)
        self.env = DeepRacerEnv(randomize=())

    def tearDown(self):
        self.env.close()
        self.state.close()
        for publisher in self.publishers.values():
            publisher.unregister()

    def command(self, speed, steering):
        """Publishes what the node control does for a command in ackermann mode."""
        yaw_rate = speed * math.tan(steering) / GEOMETRY.wheelbase
        wheels = wheel_commands(speed, yaw_rate, GEOMETRY)
        for name, publisher in self.publishers.items():
            words = name.replace("_wheel", "").replace("_steering_hinge", "_steering")
            publisher.publish(getattr(wheels, words))

    def pose(self):
        """Position and quaternion of the launched car."""
        pose = self.state("racecar", "").pose
        at, turn = pose.position, pose.orientation
        return at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w

    def test_a_lap_has_the_same_poses(self):
        env, car = self.env, self.env.task.car.model
        env.reset(seed=0, options={"start": 0.0})
        env.world.restore(env.saved)  # reset() has put the car to its place, from where it was
        self.time.go(REST)
        path = Path(env.task.track.centreline, closed=True)
        driver = Pursuit(path, max_speed=SPEED, max_lateral_acceleration=GRIP)
        end, farthest = "", 0.0
        while not end:
            x, y, yaw = env.task.motion[:3]
            x, y = x + REAR_AXLE * math.cos(yaw), y + REAR_AXLE * math.sin(yaw)
            speed, curvature = driver.command(x, y, yaw)
            action = env.options.actions.action(speed, math.atan(GEOMETRY.wheelbase * curvature))
            before = env.world.world.step_count
            end = env.step(action)[-1]["end"]
            self.command(*env.options.actions.command(action))
            self.time.go((env.world.world.step_count - before) * 1e-3, 1)
            pose = car.pose
            gaps = (
                abs(one - other)
                for one, other in zip(self.pose(), (*pose.position, *pose.orientation))
            )
            farthest = max(farthest, *gaps)
            self.assertLess(farthest, TOLERANCE, f"after {env.task.state.steps} actions")
        self.assertEqual(end, "lap")
        print(f"largest difference {farthest:g}")
