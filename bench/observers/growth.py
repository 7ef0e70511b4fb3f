"""growth SIM_SECONDS: simulated time, idle and then driving; asks for a sample now and then."""

import time

from observers import graph

SAMPLES = 20


def phase(simulation, span):
    """Wait for simulated time to pass, with a sample at even distances."""
    begin = simulation.time()
    for number in range(SAMPLES + 1):
        while simulation.time() - begin < span * number / SAMPLES:
            time.sleep(0.05)
        graph.say(sim=simulation.time() - begin)
        graph.hear()
    graph.say(done=True)


def main(span):
    """Idle: controllers run, nothing is commanded. Driving: a circle, states and odometry heard."""
    graph.join()
    graph.wait_for_controllers()
    simulation = graph.Simulation()
    phase(simulation, float(span))
    for topic in ("/racecar/joint_states", "/racecar/odom", "/tf", "/clock"):
        graph.record(topic).clear()
    graph.start_circle(graph.publishers())
    phase(simulation, float(span))
