"""free OPTIONS: turns of the bridge, as fast as possible, and of bare stepping.

OPTIONS is JSON: topics (subscribed), cars (see bare.bare_world). First answers its pid and the
physics step; then takes a line with JSON: roles (role -> pids) and threads (name -> pid, tid) to
watch. Then each line "bridge SECONDS" or "bare SECONDS" is a turn with one answer. The bridge is
paused while the bare engine runs, and the other way round.
"""

import json
import os
import time

from usage import Watch, between

from observers import bare, graph

UP_TO_SPEED = 1.0  # [s] simulated time until the cars drive steadily
QUIET = 0.2  # [s] after a pause, until what was under way has arrived
SETTLE = 0.3  # [s] after going on, until the window begins


class Turns:
    """Alternates between the bridge and the bare engine."""

    def __init__(self, topics, cars):
        self._received = {topic: graph.record(topic) for topic in topics}
        self._cars = cars
        for car in cars:
            graph.wait_for_controllers(car["namespace"])
        self._simulation = graph.Simulation()
        for car in cars:
            graph.start_circle(graph.publishers(car["namespace"]))
        self._simulation.wait(UP_TO_SPEED)
        self._simulation.pause()
        self.world = bare.bare_world(cars)
        self.world.step(round(UP_TO_SPEED / self.world.time_step))
        self.watch = None

    def bridge(self, seconds):
        """A window of the bridge: pace, simulated time, messages, speed, who had the CPU."""
        self._simulation.unpause()
        time.sleep(SETTLE)
        before = {topic: len(found) for topic, found in self._received.items()}
        reading = self.watch.read()
        pace, sim = self._simulation.pace(seconds)
        spent = between(reading, self.watch.read())
        counts = {topic: len(found) - before[topic] for topic, found in self._received.items()}
        speeds = [graph.car_speed(car["model"]) for car in self._cars]
        self._simulation.pause()
        return {"pace": pace, "sim": sim, "received": counts, "speeds": speeds, "spent": spent}

    def bare(self, seconds):
        """A window of bare stepping: pace, speed, who had the CPU meanwhile."""
        time.sleep(QUIET)
        reading = self.watch.read()
        pace = bare.pace_of(self.world, seconds)
        spent = between(reading, self.watch.read())
        speeds = [bare.speed_of(self.world, car["model"]) for car in self._cars]
        return {"pace": pace, "speeds": speeds, "spent": spent}


def main(options):
    """Start, then turns until bench.py closes the pipe."""
    options = json.loads(options)
    graph.join()
    turns = Turns(options["topics"], options["cars"])
    graph.say(pid=os.getpid(), step=turns.world.time_step)
    watched = graph.hear_json()
    turns.watch = Watch(watched["roles"], watched["threads"])
    kinds = {"bridge": turns.bridge, "bare": turns.bare}
    while True:
        kind, seconds = graph.hear()
        graph.say(**kinds[kind](float(seconds)))
