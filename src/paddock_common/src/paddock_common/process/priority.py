"""The priority of a process."""

import os


def give_way(niceness=5):
    """Lowers this process's priority, so that nodes that do little leave the processors to others.

    Linux groups processes by their session (autogroup) and looks at a group's niceness first. A
    node of a launch file has a session of its own; one that was started in a terminal has not.

    Args:
        niceness: as of nice(1), 1 to 19.
    """
    os.nice(niceness)
    if os.getsid(0) != os.getpid():
        return
    try:
        with open("/proc/self/autogroup", "w", encoding="ascii") as stream:
            stream.write(str(niceness))
    except OSError:
        pass  # there are no such groups
