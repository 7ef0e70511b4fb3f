"""Jobs: calls of other threads, run by the thread that owns the engine."""

from __future__ import annotations

import collections
import math
import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar

TIMEOUT = 30.0  # [s] wall time a caller waits for its job

T = TypeVar("T")


class QueueClosed(TimeoutError):
    """The simulation has ended and takes no more jobs."""


class _Job:
    def __init__(self, work: Callable[[], Any], reads: bool) -> None:
        self.work, self.reads, self.done = work, reads, threading.Event()
        self.result: Any = None
        self.error: BaseException | None = None


class JobQueue:
    """Queue of callables; callers wait for the result or get the exception.

    A deque, and a lock that wakes the owner: every operation is atomic, so a signal handler in the
    owner's thread may close the queue. (queue.SimpleQueue.get blocks for ever in CPython 3.11 when
    a handler takes longer than the time-out.)
    """

    def __init__(self) -> None:
        self._jobs: collections.deque[_Job] = collections.deque()
        self._reads: collections.deque[_Job] = collections.deque()
        self._queues = collections.deque((self._jobs, self._reads))  # whose turn it is first
        self.answered = 0  # jobs so far
        self._wakeup = threading.Lock()
        self._wakeup.acquire()
        self._closed = False

    def close(self) -> None:
        """Raise QueueClosed in all waiting and later callers, so that none blocks the shutdown."""
        self._closed = True
        while True:
            job = self._next()
            if job is None:
                return
            job.error = QueueClosed("the simulation has ended")
            job.done.set()

    @property
    def waiting(self) -> int:
        """Number of jobs that are queued."""
        return len(self._jobs) + len(self._reads)

    def call(self, work: Callable[[], T], timeout: float = TIMEOUT) -> T:
        """Have `work()` run by the owner and return its result.

        Raises:
            TimeoutError: the owner did not start it within `timeout` seconds of wall time; it is
                cancelled then. A job that has started is waited for.
            QueueClosed: the simulation has ended.
            Exception: what the job raised.
        """
        return self._run(_Job(work, reads=False), timeout)

    def read(self, work: Callable[[], T], timeout: float = TIMEOUT) -> T:
        """As call(), for work that changes neither the world nor what is published of it."""
        return self._run(_Job(work, reads=True), timeout)

    def _run(self, job: _Job, timeout: float) -> Any:
        """Queue a job and wait for it; see call()."""
        queue = self._reads if job.reads else self._jobs
        queue.append(job)
        if self._closed:
            self.close()
        try:
            self._wakeup.release()
        except RuntimeError:
            pass  # released already
        if not job.done.wait(timeout):
            try:
                queue.remove(job)
            except ValueError:  # it has started
                job.done.wait()
            else:
                raise TimeoutError(f"the simulation did not respond within {timeout} s")
        if job.error is not None:
            raise job.error
        return job.result

    def run_pending(self, wait: float = 0.0, budget: float = math.inf) -> int:
        """Run queued jobs; wait up to `wait` seconds for a first one.

        Jobs that may change something and those of read() alternate, each in the order of their
        calls: who only reads holds up nobody's changes.

        Args:
            budget: wall time [s] after which no further job begins; one begins in any case.

        Returns:
            Number of jobs run that may have changed something: all but those of read().
        """
        if wait > 0 and not self.waiting:
            self._wakeup.acquire(timeout=wait)
        count, begin = 0, 0.0
        while self._jobs or self._reads:
            job = self._next()
            if job is None:
                break
            begin = begin or time.monotonic()
            try:
                job.result = job.work()
            except Exception as error:  # raised in the caller
                job.error = error
            except BaseException:  # ends the owner's loop; the caller gets QueueClosed
                job.error = QueueClosed("the simulation has ended")
                raise
            finally:
                job.done.set()
            self.answered += 1
            count += not job.reads
            if budget != math.inf and time.monotonic() - begin >= budget:
                break
        return count

    def _next(self) -> _Job | None:
        """The next job, taken from its queue; None: there is none."""
        for _ in range(len(self._queues)):
            queue = self._queues[0]
            self._queues.rotate()
            try:
                return queue.popleft()
            except IndexError:
                continue
        return None
