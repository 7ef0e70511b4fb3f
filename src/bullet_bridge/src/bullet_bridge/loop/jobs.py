"""Jobs: calls of other threads, run by the thread that owns the engine."""

from __future__ import annotations

import collections
import threading
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
        self._wakeup = threading.Lock()
        self._wakeup.acquire()
        self._closed = False

    def close(self) -> None:
        """Raise QueueClosed in all waiting and later callers, so that none blocks the shutdown."""
        self._closed = True
        while True:
            try:
                job = self._jobs.popleft()
            except IndexError:
                return
            job.error = QueueClosed("the simulation has ended")
            job.done.set()

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
        self._jobs.append(job)
        if self._closed:
            self.close()
        try:
            self._wakeup.release()
        except RuntimeError:
            pass  # released already
        if not job.done.wait(timeout):
            try:
                self._jobs.remove(job)
            except ValueError:  # it has started
                job.done.wait()
            else:
                raise TimeoutError(f"the simulation did not respond within {timeout} s")
        if job.error is not None:
            raise job.error
        return job.result

    def run_pending(self, wait: float = 0.0) -> int:
        """Run the queued jobs in order; wait up to `wait` seconds for a first one.

        Returns:
            Number of jobs run that may have changed something: all but those of read().
        """
        if wait > 0 and not self._jobs:
            self._wakeup.acquire(timeout=wait)
        if not self._jobs:
            return 0
        count = 0
        while True:
            try:
                job = self._jobs.popleft()
            except IndexError:
                return count
            try:
                job.result = job.work()
            except Exception as error:  # raised in the caller
                job.error = error
            except BaseException:  # ends the owner's loop; the caller gets QueueClosed
                job.error = QueueClosed("the simulation has ended")
                raise
            finally:
                job.done.set()
            count += not job.reads
