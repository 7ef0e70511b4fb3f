"""The window's status line: what is connected, what is missing."""

import os
import time
from collections import deque

import rospy
from paddock_common.master import proxy

from track_model.msg import LapStatus


def run_id(uri, timeout=1.0):
    """Asks a ROS master for the id of its run.

    Args:
        uri: The master's address, http://host:port.
        timeout: How long to wait for an answer [s].

    Returns:
        The id ("" where the master has none).

    Raises:
        paddock_common.master.ERRORS: The master does not answer.
    """
    with proxy(uri, timeout) as master:
        code, _, value = master.getParam("/paddock_teleop", "/run_id")
        return str(value) if code == 1 else ""


def master_problem(monitor, timeout):
    """Returns a sentence when the master is lost, else an empty string.

    Args:
        monitor: MasterMonitor by run_id.
        timeout: Time without a response after which it counts as lost [s].
    """
    silence = monitor.unresponsive_for
    if monitor.replaced:
        return (
            f"Another ROS master now runs at {monitor.uri}; it does not know this window. "
            "Close the window and start it again."
        )
    if silence <= timeout:
        return ""
    return (
        f"The ROS master at {monitor.uri} has not answered for {silence:.0f} s. "
        "Stop still reaches a car that is connected. Start roscore and this window again."
    )


REFEREE_TOPIC = "/referee/status"
SPAN = 2.0  # wall time over which the real-time factor is measured [s]
STILL = 0.5  # wall time after which a clock that stands counts as paused [s]


class Pace:
    """The real-time factor from looks at the ROS clock."""

    def __init__(self):
        self._looks = deque()  # (wall time, ROS time) [s]

    def look(self, wall, ros):
        """Adds a look at both clocks [s]; a ROS clock that goes backwards starts anew."""
        if self._looks and ros < self._looks[-1][1]:
            self._looks.clear()
        self._looks.append((wall, ros))
        while wall - self._looks[0][0] > SPAN and len(self._looks) > 2:
            self._looks.popleft()

    @property
    def factor(self):
        """Simulated time per wall time; 0.0: paused; None: not known yet."""
        if len(self._looks) < 2:
            return None
        wall, ros = self._looks[-1]
        since = next(look for look in self._looks if look[1] == ros)  # the first at this time
        if wall - since[0] >= STILL:
            return 0.0
        first = self._looks[0]
        return (ros - first[1]) / (wall - first[0]) if ros != first[1] else None


def simulation_words(factor, now):
    """Returns what is said of the clock.

    Args:
        factor: Of Pace.
        now: ROS time [s]; 0: nothing has come on /clock.
    """
    if now == 0.0:
        return "waiting for /clock"
    if factor is None:
        return "simulation runs"
    return f"paused at {now:.1f} s" if factor == 0.0 else f"{factor:.2f} × real time"


def lap_words(track, status):
    """Returns what is said of a lap.

    Args:
        track: Name or file of the track, or "".
        status: LapStatus.
    """
    words = [f"track {os.path.splitext(os.path.basename(track))[0]}"] if track else []
    words.append(
        f"lap {status.laps + 1}, {status.lap_time:.1f} s" if status.running else "lap not started"
    )
    if status.best_lap_time:
        words.append(f"best {status.best_lap_time:.2f} s")
    if status.off_track:
        words.append("off the track")
    return words


class Status:
    """Collects the words of the status line."""

    def __init__(self, clock=time.monotonic):
        """Prepares; start() subscribes.

        Args:
            clock: Function -> wall time [s].
        """
        self._clock, self._pace, self._subscriber = clock, Pace(), None
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

    def words(self):
        """Returns the line."""
        now, clock = rospy.get_time(), "no simulation"
        self._pace.look(self._clock(), now)
        if not rospy.rostime.is_wallclock():
            clock = simulation_words(self._pace.factor, now)
        lap = lap_words(self._track, self._lap) if self._lap is not None else []
        return " · ".join([clock, *lap])
