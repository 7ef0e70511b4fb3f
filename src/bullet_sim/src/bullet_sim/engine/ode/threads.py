"""Threads that help the solver 'ode' with islands, see quickstep/islands.py."""

from __future__ import annotations

import ctypes
import os
import threading
import weakref
from typing import Any

from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.library import serve
from bullet_sim.pose import Array


def processors() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0))


class Helpers:
    """Threads that solve islands beside the one that makes steps.

    Args:
        owner: with which they end at the latest.
        state, table: what its steps work with.
        count: how many threads.

    Attributes:
        end: function that ends them, between two steps.
    """

    def __init__(self, owner: object, state: Any, table: Array, count: int) -> None:
        self._shared, self._semaphore = state.islands.shared, ctypes.CDLL(None)
        self._at = self._shared[q.T_SEMAPHORE :].ctypes.data_as(ctypes.c_void_p)
        self._shared[q.T_HELPERS], self._shared[q.T_ENDED] = count, 0
        self._semaphore.sem_init(self._at, 0, 0)
        kept = state, table  # until the last thread has ended
        self._threads = [
            threading.Thread(target=_serve, args=kept, name="islands", daemon=True)
            for _ in range(count)
        ]
        for thread in self._threads:
            thread.start()
        self.end = weakref.finalize(owner, self._end)

    def _end(self) -> None:
        self._shared[q.T_ENDED], self._shared[q.T_HELPERS] = 1, 0
        for _ in self._threads:
            self._semaphore.sem_post(self._at)
        for thread in self._threads:
            thread.join()


def _serve(_state: Any, table: Array) -> None:
    serve(table)
