"""The render process: python -m bullet_sim.render.worker SOCKET MEMORY KIND SHADOWS ANTIALIAS.

Messages (pickled through the socket):
    to the worker    ((sources, scene) or None, snapshot, [CameraRequest, ...], [offsets, ...]);
                     offsets are (of the colours, of the distances or None, of the labels or None)
                     in the SharedMemory of the descriptor MEMORY, to which the pictures are written
    from the worker  ('ready', details), then for each draw lists of ('error', camera or '', text),
                     ('frame', number of the request), and ('done',) at the end of the last one.
The process ends when the other end of the socket closes, also if its parent crashed, and also while
it starts. SIGINT is left to the parent. Drivers' output goes to the file descriptors 1 and 2 that
the parent has set. A failing driver ends the process, which is one reason why rendering has a
separate one.
"""

import importlib
import os
import select
import signal
import sys
import threading
from collections.abc import Iterable, Sequence
from multiprocessing.connection import Connection
from typing import Any

from bullet_sim.errors import RenderError
from bullet_sim.files import OwnFolder
from bullet_sim.render.request import CameraRequest, Quality
from bullet_sim.render.worker_process import Offsets, SharedMemory
from bullet_sim.snapshot import BodySource, Snapshot

_has_files = threading.Lock()  # held while there are temporary files
NICENESS = 5  # lower priority than the physics and the user's nodes
PROBE_URDF = """<robot name="probe"><link name="base"><visual>
<origin xyz="2 0 0"/><geometry><box size="1 1 1"/></geometry>
<material name="red"><color rgba="1 0 0 1"/></material></visual></link></robot>"""


def check_renderer(renderer: Any) -> None:
    """Draw a red box and check the picture: some drivers start but draw nothing.

    Args:
        renderer: Pictures, empty; it is left empty.

    Raises:
        RenderError: the middle of the picture is not red.
    """
    with _has_files:
        folder = OwnFolder()
        try:
            path = os.path.join(folder.path, "probe.urdf")
            with open(path, "w", encoding="utf-8") as file:
                file.write(PROBE_URDF)
            renderer.sync_sources([BodySource(0, path, True)])
        finally:
            folder.close()
    pixel = renderer.render(
        CameraRequest("probe", 0, 0, ((0, 0, 0), (0, 0, 0)), 32, 24, 1.0, 0.1, 10.0)
    )[12, 16]
    renderer.sync_sources([])
    red, green, blue = map(int, pixel)
    if red < 40 or max(green, blue) > red // 2:
        raise RenderError(f"the renderer drew a red box as RGB {(red, green, blue)}")


def make_renderer(kind: str, quality: Quality) -> tuple[Any, str]:
    """The Pictures of a kind, and what draws in a few words.

    Args:
        kind: 'gl', or 'tiny' or 'egl' of PyBullet.

    Raises:
        RenderError: it does not start.
    """
    if kind == "gl":
        from bullet_sim.render.gl.renderer import GlRenderer

        renderer = GlRenderer(quality)
        return renderer, renderer.details
    from bullet_sim.render.pybullet_renderer import PyBulletRenderer

    return PyBulletRenderer(kind), "PyBullet"


def draw(
    connection: Connection,
    renderer: Any,
    memory: SharedMemory,
    sources: tuple[Iterable[BodySource], Any] | None,
    snapshot: Snapshot,
    requests: Sequence[CameraRequest],
    layout: Sequence[Offsets],
) -> None:
    """Answer one message; see the module's docstring."""
    answers: list[tuple[Any, ...]] = []
    if sources is not None:
        try:
            renderer.sync_sources(*sources)
        except RenderError as error:
            answers.append(("error", "", str(error)))
    renderer.apply(snapshot)
    for number, (request, offsets) in enumerate(zip(requests, layout)):
        rgb, depth, labels = memory.pictures(request, offsets)
        try:
            renderer.render_with_depth(request, snapshot.step, rgb, depth)
            if labels is not None:
                renderer.labels(request, labels)
            answers.append(("frame", number))
        except ValueError as error:
            answers.append(("error", request.name, str(error)))
        if number < len(requests) - 1:
            connection.send(answers)
            answers = []
    connection.send([*answers, ("done",)])


def warm_up() -> None:
    """Import what reads meshes and pictures while nothing is asked for yet."""
    for name in ("trimesh", "PIL.Image", "collada"):
        try:
            importlib.import_module(name)
        except ImportError:
            pass  # said when a mesh needs it


def serve(connection: Connection, memory: SharedMemory, kind: str, quality: Quality) -> None:
    """Start the renderer, send `ready`, draw until the connection closes."""
    renderer, details = make_renderer(kind, quality)
    check_renderer(renderer)
    try:
        connection.send(("ready", details))
        if kind == "gl":  # PyBullet's renderers read prepared files themselves
            warm_up()
        while True:
            draw(connection, renderer, memory, *connection.recv())
    except (EOFError, ConnectionError):
        pass  # the parent closed its end or is gone
    finally:
        renderer.close()


def end_with_parent(socket: int) -> None:
    """End the process as soon as the other end of the socket closes, whatever it does meanwhile.

    Args:
        socket: file descriptor.
    """
    poller = select.poll()
    poller.register(socket, 0)  # POLLHUP is always reported
    poller.poll()
    with _has_files:
        os._exit(0)


def main(arguments: list[str]) -> None:
    """Args: arguments: [socket file descriptor, memory file descriptor, kind, Quality's values]."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(NICENESS)
    socket, memory, kind, *quality = arguments
    threading.Thread(target=end_with_parent, args=[int(socket)], daemon=True).start()
    serve(Connection(int(socket)), SharedMemory(int(memory)), kind, Quality(*quality))


if __name__ == "__main__":
    main(sys.argv[1:])
