"""The parent's side of the render worker."""
import sys
import threading
from collections import Counter

import numpy as np

from bullet_sim.errors import RenderError
from bullet_sim.render.process import Worker
from bullet_sim.render.request import RENDERERS, Frame, Renderer

MAX_RESTARTS = 3


class _Lockstep:
    """A render_sync call that waits for its frames."""

    def __init__(self, snapshot, requests):
        self.snapshot, self.requests = snapshot, requests
        self.frames, self.error = {}, None
        self.done = threading.Event()


class RenderClient:
    """Draws snapshots in another process, without ever holding up the caller of submit().

    The newest snapshot per camera wins: while the worker draws, a new request replaces the
    waiting one of the same camera, which counts in `dropped`. If the worker dies it is started
    again, at most MAX_RESTARTS times; on_error is told.

    Args:
        on_frame: called with each Frame of submit(), in the client's thread.
        on_error: called with one line of text for each trouble, in the client's thread.
        environment: variables for the worker, e.g. EGL_VISIBLE_DEVICES.

    Attributes:
        renderer: Renderer, once start() has returned.
        dropped: Counter of camera name -> requests that were replaced before being drawn.
        restarts: how often the worker was started again.
        epoch: how often forget() was called; frames tell in which one they were asked for.
    """

    def __init__(self, on_frame=None, on_error=None, environment=None):
        self.on_frame = on_frame or (lambda frame: None)
        self.on_error = on_error or (lambda text: None)
        self.renderer = None
        self.dropped = Counter()
        self.restarts = 0
        self.epoch = 0
        self._environment = dict(environment or {})
        self._worker = None
        self._thread = None
        self._changed = threading.Condition()
        self._pending = {}          # camera name -> (snapshot, request), oldest camera first
        self._lockstep = None
        self._sources = None
        self._sources_sent = True
        self._closing = False
        self._failed = ''

    # for the caller's threads -----------------------------------------------------------------
    def start(self, kind='auto'):
        """Start the worker and wait until its renderer has drawn a test picture (about 1 s).

        Args:
            kind: 'egl', 'tiny', or 'auto': EGL, and TinyRenderer when that fails.

        Returns:
            Renderer; its reason says why 'auto' did not take EGL.

        Raises:
            RenderError: unknown kind, or the renderer does not work.
        """
        if kind not in RENDERERS:
            raise RenderError(f"renderer is '{kind}', must be one of {', '.join(RENDERERS)}")
        if self._thread is not None:
            raise RenderError('the render client is already started')
        reason = ''
        if kind != 'tiny':
            try:
                self._worker = Worker('egl', self._environment)
            except RenderError as error:
                if kind == 'egl':
                    raise
                reason = str(error)
        if self._worker is None:
            self._worker = Worker('tiny', self._environment)
        self.renderer = Renderer(self._worker.kind, reason)
        self._thread = threading.Thread(target=self._run, name='render-client', daemon=True)
        self._thread.start()
        return self.renderer

    def set_sources(self, sources):
        """Tell which bodies there are from now on; sent ahead of the next picture.

        Args:
            sources: iterable of BodySource, the complete list.
        """
        with self._changed:
            self._sources = tuple(sources)
            self._sources_sent = False

    def submit(self, snapshot, requests):
        """Ask for pictures; returns at once.

        Args:
            snapshot: Snapshot.
            requests: iterable of CameraRequest, the cameras that are due.
        """
        with self._changed:
            for request in requests:
                if request.name in self._pending or self._failed or self._closing:
                    self.dropped[request.name] += 1
                if not (self._failed or self._closing):
                    self._pending[request.name] = (snapshot, request)
            self._changed.notify()

    def forget(self):
        """Drop the pictures that wait; one that is being drawn still comes, of the old epoch."""
        with self._changed:
            self.epoch += 1
            self._pending.clear()

    def render_sync(self, snapshot, requests, timeout=10.0):
        """Draw now and wait for it (lockstep); on_frame is not called for these.

        Args:
            snapshot: Snapshot.
            requests: iterable of CameraRequest.
            timeout: [s] of wall time for all of them.

        Returns:
            list of Frame in the order of requests.

        Raises:
            RenderError: a camera could not be drawn, the worker died, or time is over.
        """
        requests = list(requests)
        job = _Lockstep(snapshot, requests)
        with self._changed:
            if self._failed or self._closing or self._thread is None:
                raise RenderError(self._failed or 'the render client is not running')
            if self._lockstep is not None:
                raise RenderError('render_sync is already waiting in another thread')
            self._lockstep = job
            self._changed.notify()
        finished = job.done.wait(timeout)
        with self._changed:
            if self._lockstep is job:
                self._lockstep = None
        if job.error:
            raise RenderError(job.error)
        if not finished:
            missing = [r.name for r in requests if r.name not in job.frames]
            raise RenderError(f"no picture of {', '.join(missing)} for step {snapshot.step} "
                              f'within {timeout:g} s')
        return [job.frames[request.name] for request in requests]

    def close(self):
        """End the worker and the thread; no callback comes afterwards. May be called twice."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(2.0)
            if self._thread.is_alive():     # the worker hangs in a picture
                self._worker.process.kill()
                self._thread.join(5.0)
        elif self._thread is None and self._worker is not None:
            self._worker.close()

    @property
    def worker_pid(self):
        """Process id of the worker."""
        return self._worker.process.pid

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    # the client's own thread ------------------------------------------------------------------
    def _run(self):
        while True:
            with self._changed:
                self._changed.wait_for(
                    lambda: self._closing or self._pending or self._lockstep)
                if self._closing:
                    break
                job, snapshot, requests, sources = self._take()
                epoch = self.epoch
            try:
                self._draw(job, snapshot, requests, sources, epoch)
            except (EOFError, OSError):
                if self._closing or not self._revive(job):
                    break
            else:
                if job:
                    job.done.set()
        with self._changed:
            if self._lockstep and not self._lockstep.done.is_set():
                self._lockstep.error = self._failed or 'the render client was closed'
                self._lockstep.done.set()
        self._worker.close()

    def _take(self):
        """Next work, with the lock held: a lockstep job first, else the camera that waits
        longest and all others that wait for the same snapshot."""
        sources = None if self._sources_sent else self._sources
        self._sources_sent = True
        job = self._lockstep
        if job is not None:
            self._lockstep = None
            return job, job.snapshot, job.requests, sources
        snapshot = next(iter(self._pending.values()))[0]
        names = [name for name, (its, _) in self._pending.items() if its is snapshot]
        return None, snapshot, [self._pending.pop(name)[1] for name in names], sources

    def _draw(self, job, snapshot, requests, sources, epoch):
        connection = self._worker.connection
        connection.send(('draw', sources, [(snapshot, requests)]))
        while True:
            kind, *rest = connection.recv()
            if kind == 'done':
                return
            if kind == 'error':
                if job and rest[0]:     # a body that does not load spoils no picture
                    job.error = rest[1]
                self._call(self.on_error, rest[1])
                continue
            name, time, step, shape, deep = rest
            rgb = np.frombuffer(connection.recv_bytes(), np.uint8).reshape(shape)
            depth = None
            if deep:
                depth = np.frombuffer(connection.recv_bytes(), np.float32).reshape(shape[:2])
            frame = Frame(name, time, step, rgb, depth, epoch)
            if job:
                job.frames[name] = frame
            elif not self._closing:
                self._call(self.on_frame, frame)

    def _call(self, function, argument):
        """Run a callback; its exception must not end the thread."""
        try:
            function(argument)
        except Exception as error:  # pylint: disable=broad-except
            if function is self.on_error:
                sys.excepthook(type(error), error, error.__traceback__)
            else:
                self._call(self.on_error, f'on_frame failed: {type(error).__name__}: {error}')

    def _revive(self, job):
        """Start the worker again after it died. Returns whether there is one."""
        text = self._worker.obituary()
        kind = self._worker.kind
        self._worker.close()
        worker = None
        if self.restarts < MAX_RESTARTS:
            try:
                worker = Worker(kind, self._environment)
                self.restarts += 1
                message = f'{text}; started again ({self.restarts} of {MAX_RESTARTS})'
            except RenderError as error:
                message = f'{text}; it could not be started again: {error}'
        else:
            message = f'{text}; it is not started again after {MAX_RESTARTS} times'
        with self._changed:
            if worker:
                self._worker = worker
                self._sources_sent = self._sources is None
            else:
                self._failed = f'no pictures any more: {message}'
                self._pending.clear()
        if job:
            job.error = message
            job.done.set()
        self._call(self.on_error, message)
        return worker is not None
