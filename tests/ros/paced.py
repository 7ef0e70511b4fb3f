"""Launch files as they are, in simulated time that waits for the nodes of a control loop."""

import os


def paced(*topics, lag=0.048, nodes=()):
    """Gives the words that start pacer.py beside a launch file; for roslaunch, after that file.

    Args:
        topics: Of the control loop.
        lag: Simulated time that they may lag behind [s].
        nodes: Of the loop, which repeat commands by themselves.
    """
    file = os.path.join(os.path.dirname(os.path.abspath(__file__)), "pacer.launch")
    lists = f"topics:=[{', '.join(topics)}]", f"nodes:=[{', '.join(nodes)}]"
    return file, *lists, f"lag:={lag}"
