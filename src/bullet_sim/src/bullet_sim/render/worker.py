"""The render process: python -m bullet_sim.render.worker SOCKET MEMORY TYPE SHADOWS ANTIALIAS.

Messages (pickled through the socket):
    to the worker    ((sources, scene) or None, snapshot, [CameraRequest, ...], [offsets, ...]);
                     offsets are (of the colors, of the distances or None, of the labels or None)
                     in the SharedMemory of the descriptor MEMORY, to which the images are written
    from the worker  ('ready', details), then for each job lists of ('error', camera or '', text),
                     ('frame', index of the request), and ('done',) at the end of the last one.
The process exits when the other end of the socket closes, also if its parent crashed, and also
while it starts. SIGINT is left to the parent. Drivers' output goes to the file descriptors 1 and 2
that the parent has set. A failing driver crashes the process, which is one reason why rendering has
a separate one.
"""

from __future__ import annotations

import importlib
import os
import select
import signal
import sys
import threading
from collections.abc import Iterable, Sequence
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

from bullet_sim.description.model import Geometry, Shape, VisualLink
from bullet_sim.errors import RenderError
from bullet_sim.pose import Pose
from bullet_sim.render.request import CameraRequest, Quality
from bullet_sim.render.worker_process import Offsets, SharedMemory
from bullet_sim.snapshot import BodySource, Snapshot

if TYPE_CHECKING:
    from bullet_sim.description.world import Scene
    from bullet_sim.render.renderer import Renderer

PROBE = Shape(Geometry("box", (1.0, 1.0, 1.0)), Pose((2.0, 0.0, 0.0)), (1.0, 0.0, 0.0, 1.0))


def check_renderer(renderer: Renderer) -> None:
    """Render a red box and check the image: some drivers start but render nothing.

    Args:
        renderer: without bodies; it has none afterwards either.

    Raises:
        RenderError: the center of the image is not red.
    """
    renderer.sync_sources([BodySource(0, True, (VisualLink(shapes=(PROBE,)),))])
    pixel = renderer.render(
        CameraRequest("probe", 0, 0, ((0, 0, 0), (0, 0, 0)), 32, 24, 1.0, 0.1, 10.0)
    )[12, 16]
    renderer.sync_sources([])
    red, green, blue = map(int, pixel)
    if red < 40 or max(green, blue) > red // 2:
        raise RenderError(f"the renderer shows a red box as RGB {(red, green, blue)}")


def make_renderer(renderer_type: str, quality: Quality) -> tuple[Renderer, str]:
    """The renderer of a type, and its details in a few words.

    Args:
        renderer_type: 'gl', or 'tiny', PyBullet's.

    Raises:
        RenderError: it does not start.
    """
    if renderer_type == "gl":
        from bullet_sim.render.gl.renderer import GlRenderer

        renderer = GlRenderer(quality)
        return renderer, renderer.details
    from bullet_sim.render.pybullet_renderer import PyBulletRenderer

    return PyBulletRenderer(), "PyBullet"


def render(
    connection: Connection,
    renderer: Renderer,
    memory: SharedMemory,
    sources: tuple[Iterable[BodySource], Scene | None] | None,
    snapshot: Snapshot,
    requests: Sequence[CameraRequest],
    layout: Sequence[Offsets],
) -> None:
    """Reply to one message; see the module's docstring."""
    replies: list[tuple[Any, ...]] = []
    if sources is not None:
        try:
            renderer.sync_sources(*sources)
        except RenderError as error:
            replies.append(("error", "", str(error)))
    renderer.apply(snapshot)
    for index, (request, offsets) in enumerate(zip(requests, layout)):
        rgb, depth, labels = memory.images(request, offsets)
        try:
            renderer.render_with_depth(request, snapshot.step, rgb, depth)
            if labels is not None:
                renderer.labels(request, labels)
            replies.append(("frame", index))
        except ValueError as error:
            replies.append(("error", request.name, str(error)))
        if index < len(requests) - 1:
            connection.send(replies)
            replies = []
    connection.send([*replies, ("done",)])


def warm_up() -> None:
    """Import what reads meshes and textures while nothing is requested yet."""
    for name in ("trimesh", "PIL.Image", "collada"):
        try:
            importlib.import_module(name)
        except ImportError:
            pass  # an error when a mesh needs it


def serve(
    connection: Connection, memory: SharedMemory, renderer_type: str, quality: Quality
) -> None:
    """Start the renderer, send `ready`, render until the connection closes."""
    renderer, details = make_renderer(renderer_type, quality)
    check_renderer(renderer)
    try:
        connection.send(("ready", details))
        if renderer_type == "gl":  # PyBullet's renderers read prepared files themselves
            warm_up()
        while True:
            render(connection, renderer, memory, *connection.recv())
    except (EOFError, ConnectionError):
        pass  # the parent closed its end or has exited
    finally:
        renderer.close()


def exit_with_parent(socket: int) -> None:
    """Exit as soon as the other end of the socket closes, whatever it does meanwhile."""
    poller = select.poll()
    poller.register(socket, 0)  # POLLHUP is always reported
    poller.poll()
    os._exit(0)


def main(arguments: list[str]) -> None:
    """Args: arguments: [socket and memory file descriptors, renderer_type, Quality's values]."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    socket, memory, renderer_type, *quality = arguments
    threading.Thread(target=exit_with_parent, args=[int(socket)], daemon=True).start()
    serve(Connection(int(socket)), SharedMemory(int(memory)), renderer_type, Quality(*quality))


if __name__ == "__main__":
    main(sys.argv[1:])
