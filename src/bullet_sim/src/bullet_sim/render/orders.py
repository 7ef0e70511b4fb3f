"""Messages of the render client to its worker."""

import threading

import numpy as np

from bullet_sim.render.request import Frame


class BlockingRequest:
    """A request whose caller waits for its frames.

    Attributes:
        frames: camera name -> Frame, so far.
        error: why some are missing, or ''.
        done: set when it is complete or has failed.
    """

    def __init__(self, snapshot, requests):
        self.snapshot, self.requests = snapshot, requests
        self.frames, self.error = {}, ""
        self.done = threading.Event()


class Order:
    """One message to the worker.

    Args:
        job: BlockingRequest whose pictures these are, or None.
        sources: (BodySources, Scene or None) that are new to the worker, or None.
        snapshot: Snapshot.
        requests: CameraRequests.
        epoch: RenderClient.epoch.

    Attributes:
        job: as above.
        count: of the requests.
    """

    def __init__(self, job, sources, snapshot, requests, epoch):
        self.job, self._sources, self._snapshot = job, sources, snapshot
        self._requests, self._epoch, self._offsets = requests, epoch, ()
        self.count = len(requests)

    def send(self, worker):
        """Send it; if the worker is gone, reading its answer fails."""
        self._offsets = worker.buffers.next_layout(self._requests)
        try:
            worker.connection.send((self._sources, self._snapshot, self._requests, self._offsets))
        except OSError:
            pass

    def frame(self, worker, number, zero_copy):
        """The finished picture of a request.

        Args:
            number: of the request.
            zero_copy: its arrays are those that the worker has written, valid until the order
                after the next one is sent; False: copies.
        """
        request, (colours, distances) = self._requests[number], self._offsets[number]
        size, depth = (request.height, request.width), None
        rgb = worker.memory.array(colours, (*size, 3), np.uint8)
        if distances is not None:
            depth = worker.memory.array(distances, size, np.float32)
        if not zero_copy:
            rgb, depth = rgb.copy(), depth if depth is None else depth.copy()
        return Frame(
            request.name, self._snapshot.time, self._snapshot.step, rgb, depth, self._epoch
        )
