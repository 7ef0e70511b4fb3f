#!/usr/bin/env python3
"""Windows of time, in which stages of sending are on and off by turns, and what each costs."""

import random
import statistics
import threading
import time

from sending_stages import Packing, Switches

QUANTITIES = ("thread, median", "thread, mean", "bridge and relay", "wall")
SETTLE = 0.05  # [s] wall time between a switch and its window


class Alternation:
    """Runs in the simulation thread: switches and reads the clocks between iterations of the loop.

    Args:
        pairs: of windows for each stage.
        seconds: wall time of a window.
        names: parts of the names of the stages; None: all.
    """

    def __init__(self, pairs, seconds, names=None):
        self._pairs, self._seconds, self.ready = pairs, seconds, threading.Event()
        self._names = names or [""]
        self.packing = Packing()
        self._plan, self._until, self.results = None, 0.0, {}
        self._last, self._iterations = (0.0, 0.0), []

    def iterate(self, server):
        """One call after each iteration; returns whether the measurement is complete."""
        now = server._world.time, time.thread_time()
        sim, spent = (b - a for a, b in zip(self._last, now))
        self._last = now
        if sim > 0.0:
            self._iterations.append(spent / sim)
        if not self.ready.is_set():
            return False
        if self._plan is None:
            self.switches = Switches(server, self.packing)
            self._plan = self._windows(server)
        now = time.monotonic()
        if now < self._until:
            return False
        try:
            self._until = time.monotonic() + next(self._plan)
        except StopIteration:
            return True
        return False

    def _windows(self, server):
        """Yields waiting times [s] until all windows are measured."""
        stages = [
            (name, stage)
            for name, stage in self.switches.stages.items()
            if any(part in name for part in self._names)
        ]
        for pair in range(self._pairs):
            for name, (switch, restore) in random.sample(stages, len(stages)):
                found = {}
                for on in (True, False) if pair % 2 else (False, True):
                    switch(on)
                    yield SETTLE
                    before = self._read(server)
                    self._iterations.clear()
                    yield self._seconds
                    found[on] = self._cost(before, self._read(server))
                switch(True)
                restore()
                self.results.setdefault(name, []).append((found[False], found[True]))

    @staticmethod
    def _read(server):
        with open(f"/proc/{server._relay.process.pid}/schedstat", encoding="ascii") as file:
            relay = int(file.read().split()[0]) * 1e-9
        return server._world.time, time.thread_time(), time.process_time() + relay, time.monotonic()

    def _cost(self, before, after):
        sim, *spent = (b - a for a, b in zip(before, after))
        costs = statistics.median(self._iterations), *(value / sim for value in spent)
        return dict(zip(QUANTITIES, costs))
