"""Messages of the render client to its worker."""

import threading

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
            zero_copy: its arrays are those that the worker has written, valid until AHEAD + 1
                more orders are sent; False: copies.
        """
        request = self._requests[number]
        arrays = worker.memory.pictures(request, self._offsets[number])
        if not zero_copy:
            arrays = [None if array is None else array.copy() for array in arrays]
        return Frame(
            request.name, self._snapshot.time, self._snapshot.step, *arrays, epoch=self._epoch
        )
