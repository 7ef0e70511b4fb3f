"""start T0: the first picture and the controllers since T0 (time.monotonic)."""

import sys
import time

from observers import graph


def main(began):
    """Answers first_image, first_joint_state, controllers [s]."""
    began = float(began)
    graph.join()
    pictures = graph.record("/camera/image")
    states = graph.record("/racecar/joint_states")
    controllers = graph.wait_for_controllers() - began
    limit = time.monotonic() + graph.START_LIMIT
    while not (pictures and states):
        if time.monotonic() > limit:
            sys.exit("observer: no picture or no joint states")
        time.sleep(0.01)
    graph.say(
        first_image=pictures[0][0] - began,
        first_joint_state=states[0][0] - began,
        controllers=controllers,
    )
