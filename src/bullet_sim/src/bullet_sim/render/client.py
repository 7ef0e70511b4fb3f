"""The client of the render process: it sends snapshots and requests and receives frames."""

from __future__ import annotations

import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Optional, Tuple

from bullet_sim.description.world import Scene
from bullet_sim.errors import RenderError
from bullet_sim.render.request import (
    DEFAULT,
    RENDERERS,
    CameraRequest,
    Frame,
    Quality,
    RendererInfo,
)
from bullet_sim.render.worker_process import AHEAD, Offsets, Worker
from bullet_sim.snapshot import BodySource, Snapshot

Sources = Tuple[Tuple[BodySource, ...], Optional[Scene]]


class BlockingRequest:
    """A request whose caller waits for its frames.

    Attributes:
        error: why some are missing, or ''.
        done: set when it is complete or has failed.
    """

    def __init__(self, snapshot: Snapshot, requests: list[CameraRequest]) -> None:
        self.snapshot, self.requests = snapshot, requests
        self.frames: dict[str, Frame] = {}
        self.error = ""
        self.done = threading.Event()

    def fail(self, reason: str) -> None:
        """End it without the missing frames."""
        self.error = reason
        self.done.set()


class RenderJob:
    """One message to the worker.

    Args:
        blocking: whose images these are, or None.
        sources: what is new to the worker, or None.
        epoch: RenderClient.epoch.
    """

    def __init__(
        self,
        blocking: BlockingRequest | None,
        sources: Sources | None,
        snapshot: Snapshot,
        requests: list[CameraRequest],
        epoch: int,
    ) -> None:
        self.blocking, self._sources, self._snapshot = blocking, sources, snapshot
        self._requests, self._epoch = requests, epoch
        self._offsets: list[Offsets] = []
        self.count = len(requests)

    def send(self, worker: Worker) -> None:
        """Send it; if the worker has exited, reading its reply fails."""
        self._offsets = worker.buffers.next_layout(self._requests)
        try:
            worker.connection.send((self._sources, self._snapshot, self._requests, self._offsets))
        except OSError:
            pass

    def frame(self, worker: Worker, index: int, zero_copy: bool) -> Frame:
        """The finished image of a request.

        Args:
            zero_copy: its arrays are those that the worker has written, valid until AHEAD + 1
                more jobs are sent; False: copies.
        """
        request = self._requests[index]
        arrays = worker.memory.images(request, self._offsets[index])
        if not zero_copy:
            arrays = [None if array is None else array.copy() for array in arrays]
        rgb, depth, labels = arrays
        snapshot, epoch = self._snapshot, self._epoch
        return Frame(request.name, snapshot.time, snapshot.step, rgb, depth, labels, epoch)


MAX_RESTARTS = 3  # within ...
WINDOW = 60.0  # [s] ... of wall time: a worker that dies again and again is given up
SYNC_TIMEOUT = 60.0  # [s] of wall time; a renderer that hangs is noticed much sooner
REFRESH = 0.005  # [s] of wall time; a queued request is not replaced sooner: that costs a snapshot


class RenderClient:
    """Renders snapshots in another process; submit() does not block.

    While the worker renders, a new request replaces the queued one of the same camera, which counts
    in `dropped`. If the worker dies it is restarted, at most MAX_RESTARTS times within WINDOW, and
    on_error is called. The worker renders the next images while on_frame runs for the last ones.

    Args:
        on_frame: called with each Frame of submit(), in the client's thread.
        on_error: called with one line of text for each error, in the client's thread.
        environment: variables for the worker, e.g. EGL_VISIBLE_DEVICES.
        zero_copy: a Frame's arrays are those that the worker has written, valid until on_frame
            returns; False: copies.

    Attributes:
        renderer: what renders, once start() has returned.
        dropped: camera name -> requests that were replaced before being rendered.
        epoch: number of discard() calls; a Frame has the epoch of its request.
        restarts: how often the worker was restarted.
    """

    def __init__(
        self,
        on_frame: Callable[[Frame], object] | None = None,
        on_error: Callable[[str], object] | None = None,
        environment: Mapping[str, str] | None = None,
        zero_copy: bool = False,
        quality: Quality = DEFAULT,
    ) -> None:
        self.on_frame: Callable[[Frame], object] = on_frame or (lambda frame: None)
        self.on_error: Callable[[str], object] = on_error or (lambda text: None)
        self.renderer: RendererInfo | None = None
        self.dropped: Counter[str] = Counter()
        self.epoch = self.restarts = 0
        self._environment, self._zero_copy = dict(environment or {}), zero_copy
        self._quality = quality
        self._worker: Any = None  # a Worker, once start() has returned
        self._thread: threading.Thread | None = None
        self._last_restarts: list[float] = []  # their times [s]
        self._changed = threading.Condition()  # guards what follows
        self._closing, self._failed = False, ""  # why there will be no images any more, or ''
        # camera name -> (snapshot, request, time [s] at which it was queued), oldest camera first
        self._pending: dict[str, tuple[Snapshot, CameraRequest, float]] = {}
        self._blocking: BlockingRequest | None = None
        self._sources: Sources | None = None
        self._scene: Scene | None = None
        self._sources_sent = True

    # for the caller's threads -----------------------------------------------------------------
    def start(self, kind: str = "auto") -> RendererInfo:
        """Start the worker and wait until its renderer has rendered a test image (about 1 s).

        Args:
            kind: 'gl', 'tiny', or 'auto': OpenGL, and TinyRenderer when that fails.

        Returns:
            RendererInfo; its reason is why 'auto' did not choose OpenGL.

        Raises:
            RenderError: unknown kind, or the renderer does not work.
        """
        if kind not in RENDERERS:
            raise RenderError(f"renderer is '{kind}', must be one of {', '.join(RENDERERS)}")
        if self._thread is not None:
            raise RenderError("the render client is already started")
        reason = ""
        if kind != "tiny":
            try:
                self._worker = Worker("gl", self._environment, self._quality)
            except RenderError as error:
                if kind == "gl":
                    raise
                reason = str(error)
        if self._worker is None:
            self._worker = Worker("tiny", self._environment)
        self.renderer = RendererInfo(self._worker.renderer_type, reason, self._worker.details)
        self._thread = threading.Thread(target=self._run, name="render-client", daemon=True)
        self._thread.start()
        return self.renderer

    def set_sources(self, sources: Iterable[BodySource], scene: Scene | None = None) -> None:
        """Set the bodies; sent to the worker before the next request.

        Args:
            sources: the complete list.
            scene: with the lights; None: as before, at first Gazebo's sun.
        """
        with self._changed:
            self._scene = scene or self._scene
            self._sources = (tuple(sources), self._scene)
            self._sources_sent = False

    def needing_snapshot(self, requests: list[CameraRequest]) -> list[CameraRequest]:
        """Those requests that need a snapshot: not where one was queued REFRESH ago or less.

        In a world that runs free a camera is due many times while the worker renders one image.
        """
        latest = time.monotonic() - REFRESH
        with self._changed:
            fresh = {name for name, (_, _, queued) in self._pending.items() if queued > latest}
            self.dropped.update(request.name for request in requests if request.name in fresh)
        return [request for request in requests if request.name not in fresh]

    def submit(self, snapshot: Snapshot, requests: Iterable[CameraRequest]) -> None:
        """Request images from the cameras that are due; returns immediately."""
        now = time.monotonic()
        with self._changed:
            stopped = self._failed or self._closing
            for request in requests:
                if request.name in self._pending or stopped:
                    self.dropped[request.name] += 1
                if not stopped:
                    self._pending[request.name] = (snapshot, request, now)
            self._changed.notify()

    def discard(self) -> None:
        """Drop queued requests; an image being rendered is still emitted, with the old epoch."""
        with self._changed:
            self.epoch += 1
            self._pending.clear()

    def render_sync(
        self, snapshot: Snapshot, requests: Iterable[CameraRequest], timeout: float = SYNC_TIMEOUT
    ) -> list[Frame]:
        """Render now and wait for the images (lockstep), for which on_frame is not called.

        Args:
            timeout: [s] of wall time for all of them.

        Returns:
            list of Frame in the order of requests.

        Raises:
            RenderError: a camera could not be rendered, the worker died, or the time-out has
                passed.
        """
        requests = list(requests)
        blocking = BlockingRequest(snapshot, requests)
        with self._changed:
            if self._thread is None or self._failed or self._closing:
                raise RenderError(self._failed or "the render client is not running")
            if self._blocking is not None:
                raise RenderError("render_sync is already waiting in another thread")
            self._blocking = blocking
            self._changed.notify()
        finished = blocking.done.wait(timeout)
        with self._changed:
            if self._blocking is blocking:  # still queued
                self._blocking = None
        if blocking.error:
            raise RenderError(blocking.error)
        if not finished:
            missing = [r.name for r in requests if r.name not in blocking.frames]
            raise RenderError(
                f"no image of {', '.join(missing)} for step {snapshot.step} within {timeout:g} s"
            )
        return [blocking.frames[request.name] for request in requests]

    def close(self) -> None:
        """Stop the worker and the thread; no callback is called after that. Idempotent."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        if self._worker is not None:
            self._worker.process.kill()  # it stores nothing; exiting alone takes it a second
        if self._thread is None and self._worker is not None:
            self._worker.close()
        elif self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(5.0)

    def __enter__(self) -> RenderClient:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    # the client's thread ----------------------------------------------------------------------
    def _run(self) -> None:
        sent: deque[RenderJob] = deque()  # jobs that the worker has, the oldest first
        last = None  # the newest image, emitted while the worker renders the next one
        while True:
            self._send_jobs(sent, wait=last is None)
            if self._closing:
                break
            self._emit(last)
            last = None
            if not sent:
                continue
            try:
                last = self._collect(sent[0])
            except (EOFError, OSError):
                if self._closing or not self._restart_worker(sent):
                    break
                sent.clear()
            else:
                blocking = sent.popleft().blocking
                if blocking:
                    blocking.done.set()
        with self._changed:  # nothing takes jobs any more
            if self._blocking and not self._blocking.done.is_set():
                self._blocking.fail(self._failed or "the render client was closed")
        self._worker.close(kill=True)

    def _send_jobs(self, sent: deque[RenderJob], wait: bool) -> None:
        """Send what is queued, until the worker has AHEAD jobs; wait for one when it has none."""
        while len(sent) < AHEAD:
            job = self._next_job(wait=wait and not sent)
            if job is None:
                return
            job.send(self._worker)
            sent.append(job)

    def _next_job(self, wait: bool) -> RenderJob | None:
        """The next job: a blocking request first, else the oldest queued request and all others
        of the same snapshot.

        Args:
            wait: whether to wait until something is queued.

        Returns:
            None when nothing is queued, and after close().
        """
        with self._changed:
            if wait:
                self._changed.wait_for(lambda: self._closing or self._pending or self._blocking)
            if self._closing:
                return None
            blocking, self._blocking = self._blocking, None
            if blocking is not None:
                snapshot, requests = blocking.snapshot, blocking.requests
            elif self._pending:
                snapshot = next(iter(self._pending.values()))[0]
                names = [name for name, (other, *_) in self._pending.items() if other is snapshot]
                requests = [self._pending.pop(name)[1] for name in names]
            else:
                return None
            sources = None if self._sources_sent else self._sources
            self._sources_sent = True
            return RenderJob(blocking, sources, snapshot, requests, self.epoch)

    def _collect(self, job: RenderJob) -> Frame | None:
        """Wait for the images of a job; emit all but the last, which is returned."""
        last = None
        while True:
            for message, *rest in self._worker.receive():
                if message == "done":
                    return last
                if message == "error":
                    camera, text = rest
                    if job.blocking and camera:  # a body that does not load spoils no image
                        job.blocking.error = text
                    self._call(self.on_error, text)
                    continue
                index = rest[0]
                zero_copy = self._zero_copy and not job.blocking
                frame = job.frame(self._worker, index, zero_copy)
                if job.blocking:
                    job.blocking.frames[frame.camera] = frame
                elif index < job.count - 1:  # the worker renders the next one already
                    self._emit(frame)
                else:
                    last = frame

    def _emit(self, frame: Frame | None) -> None:
        if frame is not None and not self._closing:
            self._call(self.on_frame, frame)

    def _call(self, function: Callable[[Any], object], argument: object) -> None:
        """Run a callback; its exception must not end the thread."""
        try:
            function(argument)
        except Exception as error:  # pylint: disable=broad-except
            if function is self.on_error:
                sys.excepthook(type(error), error, error.__traceback__)
            else:
                self._call(self.on_error, f"on_frame failed: {type(error).__name__}: {error}")

    def _restart_worker(self, dropped: Iterable[RenderJob]) -> bool:
        """Restart the worker after it died with these jobs; returns whether it runs."""
        worker, message = self._next_worker(self._worker.exit_reason())
        with self._changed:
            if worker:
                self._worker = worker
                self._sources_sent = self._sources is None
            else:
                self._failed = f"no images any more: {message}"
                self._pending.clear()
        for job in dropped:
            if job.blocking:
                job.blocking.fail(message)
        self._call(self.on_error, message)
        return worker is not None

    def _next_worker(self, reason: str) -> tuple[Worker | None, str]:
        """A Worker in place of one that has died for a reason, or None; what happened, one line."""
        self._worker.close()
        now = time.monotonic()
        self._last_restarts = [last for last in self._last_restarts if now - last < WINDOW]
        within = f"{MAX_RESTARTS} times within {WINDOW:g} s"
        if len(self._last_restarts) >= MAX_RESTARTS:
            return None, f"{reason}; it is not started again after {within}"
        try:
            worker = Worker(self._worker.renderer_type, self._environment, self._quality)
        except RenderError as error:
            return None, f"{reason}; it could not be started again: {error}"
        self._last_restarts.append(now)
        self.restarts += 1
        return worker, f"{reason}; started again (at most {within})"
