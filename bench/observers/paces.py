"""Observer of a world of worlds/causes.py, which runs in Paddock or in Gazebo, beside bare steps.

world NAME: answers once the robot drives; then each line "world SECONDS" or "bare SECONDS" is a
round with one answer. The world is paused while the bare engine steps.
"""

import tempfile
import time

import pybullet
import rospy
from geometry_msgs.msg import Twist
from pairs import rate_of_work
from worlds import causes, core

from observers import graph

STEPS_A_CALL = 200
STEP = 0.001  # [s]
UP_TO_SPEED = 1.5  # [s] simulated time until the robot drives steadily and things have come down
SETTLE = 0.3  # [s] after going on or pausing, until a window begins
SPEED = 10.0  # of the bare car's wheels [rad/s]


class BareCar:
    """PyBullet alone: a car of four wheels on a plane, with nothing of Paddock's.

    How fast it steps is what this machine is worth at this moment.
    """

    def __init__(self):
        self._engine = pybullet.connect(pybullet.DIRECT)
        pybullet.setTimeStep(STEP, physicsClientId=self._engine)
        pybullet.setGravity(0, 0, -9.81, physicsClientId=self._engine)
        plane = pybullet.createCollisionShape(
            pybullet.GEOM_PLANE, planeNormal=(0, 0, 1), physicsClientId=self._engine
        )
        pybullet.createMultiBody(0, plane, physicsClientId=self._engine)
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
            file.write(core.car())
            file.flush()
            car = pybullet.loadURDF(file.name, (0, 0, 0.031), physicsClientId=self._engine)
        wheels = range(pybullet.getNumJoints(car, physicsClientId=self._engine))
        pybullet.setJointMotorControlArray(
            car,
            wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=[SPEED + number % 2 for number in wheels],
            forces=[0.1] * len(wheels),
            physicsClientId=self._engine,
        )

    def pace(self, seconds):
        """Simulated seconds per wall second, over some wall time [s]."""

        def work():
            for _ in range(STEPS_A_CALL):
                pybullet.stepSimulation(physicsClientId=self._engine)
            return STEPS_A_CALL * STEP

        return rate_of_work(work, seconds)


class Rounds:
    """A running world and the bare car by turns.

    Args:
        topics: subscribed.
    """

    def __init__(self, topics):
        self._received = {topic: graph.record(topic) for topic in topics}
        self._simulation, self._bare = graph.Simulation(), BareCar()
        self._output = rospy.Publisher(causes.COMMANDS, Twist, queue_size=1)
        self._wait(self._output.get_num_connections, f"a subscriber of {causes.COMMANDS}")
        self._wait(self._drives, f"a robot that drives by {causes.COMMANDS}")
        self._simulation.wait(UP_TO_SPEED)
        for topic, found in self._received.items():
            self._wait(lambda found=found: found, f"a message on {topic}")
        self._simulation.pause()

    def _drives(self):
        """Sends the command; whether the robot drives by it."""
        command = Twist()
        command.linear.x, command.angular.z = causes.SPEED, causes.TURN
        self._output.publish(command)
        return graph.car_speed("robot") > 0.5 * causes.SPEED

    @staticmethod
    def _wait(condition, name):
        limit = time.monotonic() + graph.START_LIMIT
        while not condition():
            if time.monotonic() > limit:
                graph.fail(f"{name} does not come within {graph.START_LIMIT:g} s")
            time.sleep(0.05)

    def world(self, seconds):
        """A window of the world: pace, messages per wall second by topic, the robot's speed."""
        self._simulation.unpause()
        time.sleep(SETTLE)
        before, begin = graph.counts(self._received), time.monotonic()
        pace, _ = self._simulation.pace(seconds)
        after, wall = graph.counts(self._received), time.monotonic() - begin
        speed = graph.car_speed("robot")
        self._simulation.pause()
        received = {topic: (count - before[topic]) / wall for topic, count in after.items()}
        return {"pace": pace, "received": received, "speed": speed}

    def bare(self, seconds):
        """A window of the bare car: pace."""
        time.sleep(SETTLE)
        return {"pace": self._bare.pace(seconds)}


def world(name):
    """Rounds of a world until the pipe is closed."""
    graph.join()
    rounds = Rounds((causes.ODOMETRY, "/tf", *causes.CAUSES[name].topics))
    graph.say(world=name)
    graph.serve({"world": rounds.world, "bare": rounds.bare})
