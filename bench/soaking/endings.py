"""The faults that end a session. ENDINGS is the table of them."""

import signal
import time

from soaking.asking import Failure
from soaking.crowd import Crowd
from soaking.marked import marked

END_LIMIT = 10.0  # wall time for the simulator to end by itself when its core has died [s],
# longer where others want the processors


def kill_simulator(session, rng):
    """SIGKILL of the simulator: roslaunch ends everything."""
    before = time.monotonic()
    session.send("bridge", signal.SIGKILL)
    return _ended(session, before, "the simulator killed", "REQUIRED process")


def kill_roslaunch(session, rng):
    """SIGKILL of roslaunch: the simulator and what it started have to notice."""
    before = time.monotonic()
    number = rng.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT))
    session.send("roslaunch", number)
    said = "roslaunch has left" if number == signal.SIGKILL else "killing on exit"
    return _ended(session, before, f"roslaunch got {number.name}", said)


def kill_master(session, rng):
    """SIGKILL of the ROS master, which may be started anew at once."""
    before = time.monotonic()
    session.send("roscore", signal.SIGKILL)
    session.send("rosmaster", signal.SIGKILL)
    session.send("rosout", signal.SIGKILL)
    anew = rng.random() < 0.5
    if anew:
        time.sleep(rng.uniform(0.0, 3.0))
        session.start_core()
    words = "the ROS master killed" + (" and started anew" if anew else "")
    return _ended(session, before, words, "ROS master")


def _ended(session, before, words, said):
    """Waits for the session's end; a zombie, or an end without a reason, is a failure."""
    crowd = Crowd()
    while session.pid("bridge") is not None:
        crowd.look(marked(session.mark))
        seconds = time.monotonic() - before
        if seconds > END_LIMIT * crowd.slowdown():
            raise Failure(f"{words}; after {seconds:.0f} s the simulator is still there")
        time.sleep(0.05)
    found, _ = session.ended(before)
    if found.left:
        raise Failure(f"{words}; after {found.seconds:.0f} s still there: {found.left}")
    status = session.launch.wait(END_LIMIT)
    if said not in session.said():
        raise Failure(f"{words}; the log does not say '{said}'")
    return f"{words}: all ended within {found.seconds:.1f} s, status {status}"


# Fault -> how often it comes in a round.
ENDINGS = {kill_simulator: 1, kill_roslaunch: 1, kill_master: 1}
