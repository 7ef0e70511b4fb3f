"""Jobs: what other threads want done by the one thread that owns the engine."""

import queue
import threading

TIMEOUT = 30.0      # [s] wall time a caller waits for its job


class _Job:
    def __init__(self, work):
        self.work, self.done = work, threading.Event()
        self.result = self.error = None


class JobQueue:
    """Queue of callables; callers wait for the result or get the exception."""

    def __init__(self):
        self._queue = queue.SimpleQueue()

    def call(self, work, timeout=TIMEOUT):
        """Have `work()` run by the owner and return its result.

        Raises:
            TimeoutError: the owner did not get to it in `timeout` seconds of wall time.
            Exception: whatever the job raised.
        """
        job = _Job(work)
        self._queue.put(job)
        if not job.done.wait(timeout):
            raise TimeoutError(f'the simulation did not answer within {timeout} s')
        if job.error is not None:
            raise job.error
        return job.result

    def run_pending(self, wait=0.0):
        """Run what is queued, in order; wait up to `wait` seconds for a first job.

        Returns:
            Number of jobs run.
        """
        count = 0
        while True:
            try:
                job = self._queue.get(block=wait > 0, timeout=wait or None)
            except queue.Empty:
                return count
            wait = 0.0
            try:
                job.result = job.work()
            except Exception as error:  # handed to the caller
                job.error = error
            job.done.set()
            count += 1
