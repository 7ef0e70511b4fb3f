"""The simulation loop: the one thread that owns the engine, simulated time, and its pace."""

import sys
import time as wall

import rospy
from rosgraph_msgs.msg import Clock

from bullet_bridge.conversions import stamp
from bullet_bridge.schedule import Schedule

MAX_LAG = 0.25      # [s] wall time behind which the pace starts anew instead of catching up
PACED_BATCH = 0.001     # [s] wall time that one batch of steps stands for at a given pace
FREE_BATCH = 0.02       # [s] simulated time of the longest batch when it runs free


class Server:
    """Runs the world.

    Args:
        world: of the core.
        jobs: JobQueue that other threads fill.
        robots: Robots, fed and published in every step.
        config: Config.
    """

    def __init__(self, world, jobs, robots, config):
        self._world, self._jobs, self._robots = world, jobs, robots
        self.paused = config.paused
        self._factor = config.real_time_factor
        self._batch = max(1, round((self._factor * PACED_BATCH or FREE_BATCH) / world.time_step))
        self._clock = rospy.Publisher('/clock', Clock, queue_size=10, latch=True)
        self._clock_schedule = Schedule(config.clock_rate, world.time_step)
        self._anchor()

    def _anchor(self):
        """Count the pace from here on."""
        self._wall_start, self._sim_start = wall.monotonic(), self._world.time

    def run(self):
        """Loop until the node shuts down."""
        sys.setswitchinterval(0.0005)   # publishing threads give way to the physics sooner
        self._tell_time()
        while not rospy.is_shutdown():
            self._jobs.run_pending()
            if self.paused:
                self._jobs.run_pending(wait=0.05)
                self._anchor()
                continue
            delay = self._delay()
            if delay > 0:
                self._jobs.run_pending(wait=delay)
                continue
            self.advance(self._batch)

    def _delay(self):
        """Wall time [s] until the next step is due."""
        if self._factor == 0:
            return 0.0
        due = self._wall_start + (self._world.time - self._sim_start) / self._factor
        delay = due - wall.monotonic()
        if delay < -MAX_LAG:
            self._anchor()
        return delay

    def advance(self, limit):
        """Commands in, physics steps until something is due or `limit` is reached, results out."""
        self._robots.deliver()
        step = self._world.step_count
        due = min(self._clock_schedule.next, self._robots.next_due())
        self._world.step(max(1, min(limit, due - step)))
        step = self._world.step_count
        if self._clock_schedule.due(step):
            self._tell_time()
        self._robots.publish(step, self._world.time)

    def _tell_time(self):
        self._clock.publish(Clock(clock=stamp(self._world.time)))

    def set_paused(self, paused):
        """Stop or go on (simulation thread)."""
        self.paused = paused
        self._anchor()
        self._tell_time()

    def reset(self, time):
        """Back to the start; with time=True simulated time starts at 0, too."""
        self._world.reset(time=time)
        self._clock_schedule.restart(self._world.step_count)
        self._robots.restart()
        self._anchor()
        self._tell_time()
