"""The client of the render process: it sends snapshots and requests and receives frames."""

import sys
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from bullet_sim.description.world import Scene
from bullet_sim.errors import RenderError
from bullet_sim.render.request import DEFAULT, RENDERERS, CameraRequest, Frame, Quality, Renderer
from bullet_sim.render.worker_process import AHEAD, Offsets, Restarts, Worker
from bullet_sim.snapshot import BodySource, Snapshot

Sources = tuple[tuple[BodySource, ...], Scene | None]


class BlockingRequest:
    """A request whose caller waits for its frames.

    Attributes:
        frames: camera name -> Frame, so far.
        error: why some are missing, or ''.
        done: set when it is complete or has failed.
    """

    def __init__(self, snapshot: Snapshot, requests: list[CameraRequest]) -> None:
        self.snapshot, self.requests = snapshot, requests
        self.frames: dict[str, Frame] = {}
        self.error = ""
        self.done = threading.Event()


class Order:
    """One message to the worker.

    Args:
        job: BlockingRequest whose pictures these are, or None.
        sources: (BodySources, Scene or None) that are new to the worker, or None.
        epoch: RenderClient.epoch.

    Attributes:
        job: as above.
        count: of the requests.
    """

    def __init__(
        self,
        job: BlockingRequest | None,
        sources: Sources | None,
        snapshot: Snapshot,
        requests: list[CameraRequest],
        epoch: int,
    ) -> None:
        self.job, self._sources, self._snapshot = job, sources, snapshot
        self._requests, self._epoch = requests, epoch
        self._offsets: list[Offsets] = []
        self.count = len(requests)

    def send(self, worker: Worker) -> None:
        """Send it; if the worker is gone, reading its answer fails."""
        self._offsets = worker.buffers.next_layout(self._requests)
        try:
            worker.connection.send((self._sources, self._snapshot, self._requests, self._offsets))
        except OSError:
            pass

    def frame(self, worker: Worker, number: int, zero_copy: bool) -> Frame:
        """The finished picture of a request.

        Args:
            number: of the request.
            zero_copy: its arrays are those that the worker has written, valid until AHEAD + 1
                more orders are sent; False: copies.
        """
        request = self._requests[number]
        arrays = worker.memory.pictures(request, self._offsets[number])
        if not zero_copy:
            arrays = [None if array is None else array.copy() for array in arrays]
        rgb, depth, labels = arrays
        snapshot, epoch = self._snapshot, self._epoch
        return Frame(request.name, snapshot.time, snapshot.step, rgb, depth, labels, epoch)


class OrderQueue:
    """Queued requests: the latest one of each camera, or one whose caller waits.

    Attributes:
        dropped: Counter of camera name -> requests that were replaced before being drawn.
        epoch: number of discard() calls.
        closing: whether close() was called.
        failed: why there will be no pictures any more, or ''.
    """

    def __init__(self) -> None:
        self.dropped: Counter[str] = Counter()
        self.epoch = 0
        self.closing, self.failed = False, ""
        self._changed = threading.Condition()
        # camera name -> (snapshot, request), oldest camera first
        self._pending: dict[str, tuple[Snapshot, CameraRequest]] = {}
        self._blocking: BlockingRequest | None = None
        self._sources: Sources | None = None
        self._scene: Scene | None = None
        self._sources_sent = True

    def has_pending(self) -> bool:
        """Whether a request of submit() is queued."""
        return bool(self._pending)

    def set_sources(self, sources: Iterable[BodySource], scene: Scene | None = None) -> None:
        """Set the bodies and the Scene (None: as before) that go with the next order."""
        with self._changed:
            self._scene = scene or self._scene
            self._sources = (tuple(sources), self._scene)
            self._sources_sent = False

    def resend_sources(self) -> None:
        """Let the bodies go with the next order again: the worker is a new one."""
        with self._changed:
            self._sources_sent = self._sources is None

    def submit(self, snapshot: Snapshot, requests: Iterable[CameraRequest]) -> None:
        """Queue requests of a snapshot; each replaces the queued one of its camera."""
        with self._changed:
            for request in requests:
                if request.name in self._pending or self.failed or self.closing:
                    self.dropped[request.name] += 1
                if not (self.failed or self.closing):
                    self._pending[request.name] = (snapshot, request)
            self._changed.notify()

    def discard(self) -> None:
        """Drop queued requests and begin a new epoch."""
        with self._changed:
            self.epoch += 1
            self._pending.clear()

    def put_blocking(self, job: BlockingRequest) -> None:
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

    def withdraw(self, job: BlockingRequest) -> None:
        """Remove a BlockingRequest that is still queued."""
        with self._changed:
            if self._blocking is job:
                self._blocking = None

    def next_order(self, wait: bool) -> Order | None:
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

    def fail(self, reason: str) -> None:
        """Take no requests any more, for a reason, and drop the queued ones."""
        with self._changed:
            self.failed = reason
            self._pending.clear()

    def close(self) -> None:
        """Take no requests any more; wakes the thread that waits for an order."""
        with self._changed:
            self.closing = True
            self._changed.notify()

    def end_blocking(self) -> None:
        """Let a queued BlockingRequest fail: nobody takes orders any more."""
        with self._changed:
            if self._blocking and not self._blocking.done.is_set():
                self._blocking.error = self.failed or "the render client was closed"
                self._blocking.done.set()


SYNC_TIMEOUT = 60.0  # [s] of wall time; a renderer that hangs is noticed much sooner


class RenderClient:
    """Renders snapshots in another process; submit() does not block.

    While the worker draws, a new request replaces the queued one of the same camera, which counts
    in `dropped`. If the worker dies it is restarted, see Restarts, and on_error is
    called. The worker draws the next pictures while on_frame runs for the last ones.

    Args:
        on_frame: called with each Frame of submit(), in the client's thread.
        on_error: called with one line of text for each error, in the client's thread.
        environment: variables for the worker, e.g. EGL_VISIBLE_DEVICES.
        quality: Quality.
        zero_copy: a Frame's arrays are those that the worker has written, valid until on_frame
            returns; False: copies.

    Attributes:
        renderer: Renderer, once start() has returned.
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
        self.renderer: Renderer | None = None
        self._environment, self._zero_copy = dict(environment or {}), zero_copy
        self._quality = quality
        self._worker: Any = None  # a Worker, once start() has returned
        self._thread: threading.Thread | None = None
        self._orders = OrderQueue()
        self._restarts = Restarts(self._environment, quality)

    @property
    def dropped(self) -> "Counter[str]":
        """Counter of camera name -> requests that were replaced before being drawn."""
        return self._orders.dropped

    @property
    def restarts(self) -> int:
        """How often the worker was restarted."""
        return self._restarts.count

    @property
    def epoch(self) -> int:
        """Number of discard() calls; a Frame has the epoch of its request."""
        return self._orders.epoch

    # for the caller's threads -----------------------------------------------------------------
    def start(self, kind: str = "auto") -> Renderer:
        """Start the worker and wait until its renderer has drawn a test picture (about 1 s).

        Args:
            kind: 'gl', 'tiny', or 'auto': OpenGL, and TinyRenderer when that fails.

        Returns:
            Renderer; its reason says why 'auto' did not choose OpenGL.

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
        self.renderer = Renderer(self._worker.kind, reason, self._worker.details)
        self._thread = threading.Thread(target=self._run, name="render-client", daemon=True)
        self._thread.start()
        return self.renderer

    def set_sources(self, sources: Iterable[BodySource], scene: Scene | None = None) -> None:
        """Set the bodies; sent to the worker before the next request.

        Args:
            sources: iterable of BodySource, the complete list.
            scene: Scene with the lights; None: as before, at first Gazebo's sun.
        """
        self._orders.set_sources(sources, scene)

    def submit(self, snapshot: Snapshot, requests: Iterable[CameraRequest]) -> None:
        """Request pictures; returns at once.

        Args:
            snapshot: Snapshot.
            requests: iterable of CameraRequest, the cameras that are due.
        """
        self._orders.submit(snapshot, requests)

    def discard(self) -> None:
        """Drop queued requests; a picture being drawn is still emitted, with the old epoch."""
        self._orders.discard()

    def render_sync(
        self, snapshot: Snapshot, requests: Iterable[CameraRequest], timeout: float = SYNC_TIMEOUT
    ) -> list[Frame]:
        """Render now and wait for the pictures (lockstep), for which on_frame is not called.

        Args:
            timeout: [s] of wall time for all of them.

        Returns:
            list of Frame in the order of requests.

        Raises:
            RenderError: a camera could not be drawn, the worker died, or the time-out has passed.
        """
        requests = list(requests)
        job = BlockingRequest(snapshot, requests)
        if self._thread is None:
            raise RenderError("the render client is not running")
        self._orders.put_blocking(job)
        finished = job.done.wait(timeout)
        self._orders.withdraw(job)
        if job.error:
            raise RenderError(job.error)
        if not finished:
            missing = [r.name for r in requests if r.name not in job.frames]
            raise RenderError(
                f"no picture of {', '.join(missing)} for step {snapshot.step} within {timeout:g} s"
            )
        return [job.frames[request.name] for request in requests]

    def close(self) -> None:
        """End the worker and the thread; no callback is called after that. Idempotent."""
        self._orders.close()
        if self._worker is not None:
            self._worker.process.kill()  # it keeps nothing; ending by itself takes it a second
        if self._thread is None and self._worker is not None:
            self._worker.close()
        elif self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join(5.0)

    @property
    def worker_pid(self) -> int:
        """Process id of the worker."""
        return self._worker.process.pid

    def __enter__(self) -> "RenderClient":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    # the client's own thread ------------------------------------------------------------------
    def _run(self) -> None:
        sent: deque[Order] = deque()  # orders that the worker has, the oldest first
        last = None  # the newest picture, emitted while the worker draws the next one
        while True:
            self._send_orders(sent, wait=last is None)
            if self._orders.closing:
                break
            self._emit(last)
            last = None
            if not sent:
                continue
            try:
                last = self._collect(sent[0])
            except (EOFError, OSError):
                if self._orders.closing or not self._restart_worker(sent):
                    break
                sent.clear()
            else:
                job = sent.popleft().job
                if job:
                    job.done.set()
        self._orders.end_blocking()
        self._worker.close(kill=True)

    def _send_orders(self, sent: "deque[Order]", wait: bool) -> None:
        """Send what is queued, until the worker has AHEAD orders; wait for one when it has none."""
        while len(sent) < AHEAD:
            order = self._orders.next_order(wait=wait and not sent)
            if order is None:
                return
            order.send(self._worker)
            sent.append(order)

    def _collect(self, order: Order) -> Frame | None:
        """Wait for the pictures of an order; emit all but the last, which is returned."""
        last = None
        while True:
            for kind, *rest in self._worker.receive():
                if kind == "done":
                    return last
                if kind == "error":
                    if (
                        order.job and rest[0]
                    ):  # a body that does not load is no failure of a picture
                        order.job.error = rest[1]
                    self._call(self.on_error, rest[1])
                elif order.job:
                    frame = order.frame(self._worker, rest[0], zero_copy=False)
                    order.job.frames[frame.camera] = frame
                elif rest[0] < order.count - 1:  # the worker draws the next one already
                    self._emit(order.frame(self._worker, rest[0], self._zero_copy))
                else:
                    last = order.frame(self._worker, rest[0], self._zero_copy)

    def _emit(self, frame: Frame | None) -> None:
        if frame is not None and not self._orders.closing:
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

    def _restart_worker(self, lost: Iterable[Order]) -> bool:
        """Restart the worker after it died with these orders; returns whether it runs."""
        worker, message = self._restarts.replace(self._worker)
        if worker:
            self._worker = worker
            self._orders.resend_sources()
        else:
            self._orders.fail(f"no pictures any more: {message}")
        for job in (order.job for order in lost if order.job):
            job.error = message
            job.done.set()
        self._call(self.on_error, message)
        return worker is not None
