"""The bridge's end of the viewer, which is a separate process that requests views of the world.

`bullet_viewer.feed` lists the messages. Each access to the world is a job of the simulation thread;
a view takes well under a millisecond.
"""

import os
import sys
import threading
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

import rospy
from bullet_sim.child import Child
from bullet_sim.errors import SimError
from bullet_sim.render.request import DEFAULT, Quality
from bullet_sim.sensors.views import Observer
from std_srvs.srv import Trigger, TriggerResponse

from bullet_bridge.loop.jobs import JobQueue, QueueClosed

if TYPE_CHECKING:
    from bullet_sim.world import World

    from bullet_bridge.loop.server import Server

COMMAND = (sys.executable, "-m", "bullet_viewer.main")
CLOSE_TIMEOUT = 5.0  # [s] wall time for the viewer to exit


def missing_display(environment: Mapping[str, str] = os.environ) -> str:
    """The reason why no window can open, in one line; empty: it can."""
    if any(environment.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM")):
        return ""
    return "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)"


class ViewerLink:
    """Opens the viewer and responds to its requests. If it crashes, the simulation continues.

    Args:
        server: Server, for pause, step and reset.
        renderer: auto, gl or tiny.
        command: of the viewer process; socket, renderer and the Quality's values are appended.
    """

    def __init__(
        self,
        jobs: JobQueue,
        world: "World",
        server: "Server",
        renderer: str,
        command: Sequence[str] = COMMAND,
        quality: Quality = DEFAULT,
    ) -> None:
        self._jobs, self._world, self._server = jobs, world, server
        self._command = tuple(command)
        self._render_arguments = (renderer, quality.shadows, quality.antialias)
        self._opening = threading.Lock()
        self._child: Any = None
        self._thread: Any = None
        self._connection: Any = None
        self._closing = False

    def advertise(self) -> None:
        """Advertise the service that opens the viewer."""
        rospy.Service("~open_viewer", Trigger, self._handle)

    def _handle(self, _: Any) -> TriggerResponse:
        problem = self.open()
        return TriggerResponse(success=not problem, message=problem or "the viewer is open")

    @property
    def process(self) -> Any:
        """The newest viewer's subprocess.Popen, or None."""
        return self._child and self._child.process

    def is_open(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def open(self) -> str:
        """Start the viewer unless it runs.

        Returns:
            The reason why it cannot start, which is also logged; '' otherwise.
        """
        with self._opening:
            if self.is_open():
                return ""
            problem = missing_display() or self._start()
        if problem:
            rospy.logwarn("no viewer: %s; the simulation continues without", problem)
        return problem

    def _start(self) -> str:
        try:
            self._child = Child("the viewer", self._command, self._render_arguments)
        except OSError as error:
            return f"{self._command[0]} does not start: {error.strerror}"
        self._connection = Connection(os.dup(self._child.socket.fileno()))
        self._thread = threading.Thread(target=self._serve, name="viewer-link", daemon=True)
        self._thread.start()
        return ""

    def _serve(self) -> None:
        """Respond to requests until the viewer or the simulation exits."""
        observer = Observer(self._world)
        try:
            while True:
                message = self._connection.recv()
                response = self._execute(observer, *message)
                if response:
                    self._connection.send(response)
        except (EOFError, OSError, QueueClosed):
            pass
        finally:
            self._connection.close()
            self._child.shut_down()
        self._child.wait(CLOSE_TIMEOUT)
        if self.process.returncode and not self._closing and not rospy.is_shutdown():
            rospy.logwarn("%s; the simulation continues", self._child.ending("QStandardPaths"))
        self._child.close()

    def _execute(self, observer: Observer, request: str, *arguments: Any) -> Any:
        """Execute a request; returns the response or None.

        Raises:
            QueueClosed: the simulation has ended.
        """
        server = self._server
        jobs = {
            "view": lambda: ("view", observer.view(server.paused)),
            "show": lambda: observer.show(*arguments),
            "pause": lambda: server.set_paused(True),
            "unpause": lambda: server.set_paused(False),
            "step": lambda: self._step(*arguments),
            "reset": lambda: server.reset(time=True),
        }
        try:
            return self._jobs.call(jobs[request])
        except QueueClosed:
            raise
        except (SimError, TimeoutError) as error:
            return ("error", str(error))

    def _step(self, count: int) -> None:
        """Pause and start so many physics steps."""
        if not self._server.paused:
            self._server.set_paused(True)
        self._server.begin_steps(count)

    def close(self) -> None:
        self._closing = True
        if self.is_open():
            self._child.shut_down()  # the viewer exits, which ends the thread
            self._thread.join(2.0 * CLOSE_TIMEOUT)
