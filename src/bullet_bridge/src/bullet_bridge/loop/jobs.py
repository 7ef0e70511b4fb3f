"""Jobs: what other threads want done by the one thread that owns the engine."""

import collections
import threading

TIMEOUT = 30.0  # [s] wall time a caller waits for its job


class Ended(TimeoutError):
    """The simulation has ended and takes no more jobs."""


class _Job:
    def __init__(self, work):
        self.work, self.done = work, threading.Event()
        self.result = self.error = None


class JobQueue:
    """Queue of callables; callers wait for the result or get the exception.

    A deque and one lock as the bell: every step is atomic, so a signal handler in the owner's
    thread may close the queue. (queue.SimpleQueue.get waits for ever in CPython 3.11 when a
    handler takes longer than the time-out.)
    """

    def __init__(self):
        self._jobs = collections.deque()
        self._bell = threading.Lock()
        self._bell.acquire()
        self._closed = False

    def close(self):
        """End: whoever waits or still calls gets Ended, so that nobody holds up a shutdown."""
        self._closed = True
        while True:
            try:
                job = self._jobs.popleft()
            except IndexError:
                return
            job.error = Ended("the simulation has ended")
            job.done.set()

    def waiting(self):
        """Number of jobs that wait."""
        return len(self._jobs)

    def call(self, work, timeout=TIMEOUT):
        """Have `work()` run by the owner and return its result.

        Raises:
            TimeoutError: the owner did not get to it in `timeout` seconds of wall time; it is
                withdrawn then. What the owner has begun is waited for.
            Ended: the simulation has ended.
            Exception: whatever the job raised.
        """
        job = _Job(work)
        self._jobs.append(job)
        if self._closed:
            self.close()
        try:
            self._bell.release()
        except RuntimeError:
            pass  # it rings already
        if not job.done.wait(timeout):
            try:
                self._jobs.remove(job)
            except ValueError:  # the owner is at it
                job.done.wait()
            else:
                raise TimeoutError(f"the simulation did not answer within {timeout} s")
        if job.error is not None:
            raise job.error
        return job.result

    def run_pending(self, wait=0.0):
        """Run what is queued, in order; wait up to `wait` seconds for a first job.

        Returns:
            Number of jobs run.
        """
        if wait > 0 and not self._jobs:
            self._bell.acquire(timeout=wait)
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
            except Exception as error:  # handed to the caller
                job.error = error
            except BaseException:  # ends the owner, not the caller
                job.error = Ended("the simulation has ended")
                raise
            finally:
                job.done.set()
            count += 1
