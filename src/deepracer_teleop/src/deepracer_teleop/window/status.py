"""The window's status line: simulation, lap, and problems of the master."""

import os
import time
from collections import deque

import rospy
from paddock_common.master import proxy

from track_model.msg import LapStatus


def run_id(uri, timeout=1.0):
    """Requests the id of a ROS master's run.

    Args:
        timeout: Longest wait for a response [s].

    Returns:
        The id ("" where the master has none).

    Raises:
        paddock_common.master.ERRORS: The master does not respond.
    """
    with proxy(uri, timeout) as master:
        code, _, value = master.getParam("/paddock_teleop", "/run_id")
        return str(value) if code == 1 else ""


def master_problem(monitor, timeout):
    """Returns a message when the master is unavailable, else an empty string.

    Args:
        monitor: MasterMonitor by run_id.
        timeout: Time without a response after which it counts as unavailable [s].
    """
    duration = monitor.unresponsive_for
    if monitor.replaced:
        return (
            f"Another ROS master now runs at {monitor.uri}; this window is not registered there. "
            "Close the window and start it again."
        )
    if duration <= timeout:
        return ""
    return (
        f"The ROS master at {monitor.uri} has not responded for {duration:.0f} s. "
        "Stop still reaches a car that is connected. Start roscore and this window again."
    )


REFEREE_TOPIC = "/referee/status"
SPAN = 2.0  # wall time over which the real-time factor is measured [s]
STILL = 0.5  # wall time after which a clock that does not advance counts as paused [s]


class RealTimeFactor:
    """The real-time factor from samples of the ROS clock."""

    def __init__(self):
        self._samples = deque()  # (wall time, ROS time) [s]

    def sample(self, wall, ros):
        """Adds a sample of both clocks [s]; a ROS clock that jumps backwards starts again."""
        if self._samples and ros < self._samples[-1][1]:
            self._samples.clear()
        self._samples.append((wall, ros))
        while wall - self._samples[0][0] > SPAN and len(self._samples) > 2:
            self._samples.popleft()

    @property
    def factor(self):
        """Simulated time per wall time; 0.0: paused; None: not known yet."""
        if len(self._samples) < 2:
            return None
        wall, ros = self._samples[-1]
        since = next(
            sample for sample in self._samples if sample[1] == ros
        )  # the first with this time
        if wall - since[0] >= STILL:
            return 0.0
        first = self._samples[0]
        return (ros - first[1]) / (wall - first[0]) if ros != first[1] else None


def simulation_text(factor, now):
    """Returns the text about the clock.

    Args:
        factor: RealTimeFactor.factor.
        now: ROS time [s]; 0: nothing was received on /clock.
    """
    if now == 0.0:
        return "waiting for /clock"
    if factor is None:
        return "simulation runs"
    return f"paused at {now:.1f} s" if factor == 0.0 else f"{factor:.2f} × real time"


def lap_texts(track, status: LapStatus):
    """Returns the texts about a lap."""
    texts = [f"track {os.path.splitext(os.path.basename(track))[0]}"] if track else []
    texts.append(
        f"lap {status.laps + 1}, {status.lap_time:.1f} s" if status.running else "lap not started"
    )
    if status.best_lap_time:
        texts.append(f"best {status.best_lap_time:.2f} s")
    if status.off_track:
        texts.append("off the track")
    return texts


class Status:
    """Collects the text of the status line; start() subscribes.

    Args:
        clock: Function -> wall time [s].
    """

    def __init__(self, clock=time.monotonic):
        self._clock, self._real_time_factor, self._subscriber = clock, RealTimeFactor(), None
        self._lap = self._track = None

    def start(self):
        """Subscribes to the referee."""
        self._subscriber = rospy.Subscriber(REFEREE_TOPIC, LapStatus, self.callback, queue_size=1)

    def stop(self):
        """Unsubscribes."""
        if self._subscriber is not None:
            self._subscriber.unregister()

    def callback(self, status):
        """Stores a LapStatus; runs in the subscriber's thread."""
        if self._track is None:
            referee = getattr(status, "_connection_header", {}).get("callerid", "")
            self._track = str(rospy.get_param(f"{referee}/track", "")) if referee else ""
        self._lap = status

    def text(self):
        """Returns the line."""
        now, clock = rospy.get_time(), "no simulation"
        self._real_time_factor.sample(self._clock(), now)
        if not rospy.rostime.is_wallclock():
            clock = simulation_text(self._real_time_factor.factor, now)
        lap = lap_texts(self._track, self._lap) if self._lap is not None else []
        return " · ".join([clock, *lap])
