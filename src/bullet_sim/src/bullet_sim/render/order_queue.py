"""Requests for pictures from any thread, queued for the render client's thread."""

import threading
from collections import Counter

from bullet_sim.errors import RenderError
from bullet_sim.render.orders import Order


class OrderQueue:
    """Queued requests: the latest one of each camera, or one whose caller waits.

    Attributes:
        dropped: Counter of camera name -> requests that were replaced before being drawn.
        epoch: number of discard() calls.
        closing: whether close() was called.
        failed: why there will be no pictures any more, or ''.
    """

    def __init__(self):
        self.dropped, self.epoch = Counter(), 0
        self.closing, self.failed = False, ""
        self._changed = threading.Condition()
        self._pending = {}  # camera name -> (snapshot, request), oldest camera first
        self._blocking = None
        self._sources, self._scene, self._sources_sent = None, None, True

    def has_pending(self):
        """Whether a request of submit() is queued."""
        return bool(self._pending)

    def set_sources(self, sources, scene=None):
        """Set the bodies and the Scene (None: as before) that go with the next order."""
        with self._changed:
            self._scene = scene or self._scene
            self._sources = (tuple(sources), self._scene)
            self._sources_sent = False

    def resend_sources(self):
        """Let the bodies go with the next order again: the worker is a new one."""
        with self._changed:
            self._sources_sent = self._sources is None

    def submit(self, snapshot, requests):
        """Queue requests of a snapshot; each replaces the queued one of its camera."""
        with self._changed:
            for request in requests:
                if request.name in self._pending or self.failed or self.closing:
                    self.dropped[request.name] += 1
                if not (self.failed or self.closing):
                    self._pending[request.name] = (snapshot, request)
            self._changed.notify()

    def discard(self):
        """Drop queued requests and begin a new epoch."""
        with self._changed:
            self.epoch += 1
            self._pending.clear()

    def put_blocking(self, job):
        """Queue a BlockingRequest before all others.

        Raises:
            RenderError: there will be no pictures any more, or another one is queued.
        """
        with self._changed:
            if self.failed or self.closing:
                raise RenderError(self.failed or "the render client is not running")
            if self._blocking is not None:
                raise RenderError("render_sync is already waiting in another thread")
            self._blocking = job
            self._changed.notify()

    def withdraw(self, job):
        """Remove a BlockingRequest that is still queued."""
        with self._changed:
            if self._blocking is job:
                self._blocking = None

    def next_order(self, wait):
        """The next order: a blocking request first, else the oldest queued request and all others
        of the same snapshot.

        Args:
            wait: whether to wait until something is queued.

        Returns:
            Order; None when nothing is queued, and after close().
        """
        with self._changed:
            if wait:
                self._changed.wait_for(lambda: self.closing or self._pending or self._blocking)
            if self.closing:
                return None
            job, self._blocking = self._blocking, None
            if job is not None:
                snapshot, requests = job.snapshot, job.requests
            elif self._pending:
                snapshot = next(iter(self._pending.values()))[0]
                names = [name for name, (other, _) in self._pending.items() if other is snapshot]
                requests = [self._pending.pop(name)[1] for name in names]
            else:
                return None
            sources = None if self._sources_sent else self._sources
            self._sources_sent = True
            return Order(job, sources, snapshot, requests, self.epoch)

    def fail(self, reason):
        """Take no requests any more, for a reason, and drop the queued ones."""
        with self._changed:
            self.failed = reason
            self._pending.clear()

    def close(self):
        """Take no requests any more; wakes the thread that waits for an order."""
        with self._changed:
            self.closing = True
            self._changed.notify()

    def end_blocking(self):
        """Let a queued BlockingRequest fail: nobody takes orders any more."""
        with self._changed:
            if self._blocking and not self._blocking.done.is_set():
                self._blocking.error = self.failed or "the render client was closed"
                self._blocking.done.set()
