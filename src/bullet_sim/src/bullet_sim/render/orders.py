"""What the render client asks of its worker."""

import threading

import numpy as np

from bullet_sim.render.request import Frame


class Lockstep:
    """A caller that waits for its frames.

    Attributes:
        frames: camera name -> Frame, so far.
        error: why some are missing, or ''.
        done: set when no more come.
    """

    def __init__(self, snapshot, requests):
        self.snapshot, self.requests = snapshot, requests
        self.frames, self.error = {}, ""
        self.done = threading.Event()


class Order:
    """One message to the worker, and for whom it is.

    Args:
        job: Lockstep, or None.
        sources: BodySources that are new to the worker, or None.
        snapshot: Snapshot.
        requests: CameraRequests.
        epoch: RenderClient.epoch.

    Attributes:
        job: as above.
        count: of the requests.
    """

    def __init__(self, job, sources, snapshot, requests, epoch):
        self.job, self._sources, self._snapshot = job, sources, snapshot
        self._requests, self._epoch, self._places = requests, epoch, ()
        self.count = len(requests)

    def send(self, worker):
        """Tell the worker; that it is gone shows when its answer is read."""
        self._places = worker.banks.take(self._requests)
        try:
            worker.connection.send((self._sources, self._snapshot, self._requests, self._places))
        except OSError:
            pass

    def frame(self, worker, number, lend):
        """The finished picture of a request.

        Args:
            number: of the request.
            lend: its arrays are those that the worker drew to; they are good until the order
                after the next one is sent.
        """
        request, (colours, distances) = self._requests[number], self._places[number]
        size, depth = (request.height, request.width), None
        rgb = worker.arena.array(colours, (*size, 3), np.uint8)
        if distances is not None:
            depth = worker.arena.array(distances, size, np.float32)
        if not lend:
            rgb, depth = rgb.copy(), depth if depth is None else depth.copy()
        return Frame(
            request.name, self._snapshot.time, self._snapshot.step, rgb, depth, self._epoch
        )
