"""The viewer process: python -m bullet_viewer.main SOCKET_FD auto|gl|tiny SHADOWS ANTIALIAS.

The bridge starts it with one end of a socket. When the bridge exits, also by a crash, the viewer
exits; when the viewer exits, the bridge only logs it. SIGINT is left to the bridge.
"""

import signal
import sys

from bullet_sim.render.request import Quality
from PyQt5.QtWidgets import QApplication

from bullet_viewer.feed import Feed
from bullet_viewer.window import Renderer, ViewerWindow


def main(arguments):
    """Show the window until it is closed.

    Args:
        arguments: [socket file descriptor, renderer, Quality's values].

    Returns:
        The exit code.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    application = QApplication(["bullet_viewer"])
    descriptor, renderer_type, *quality = arguments
    feed, renderer = Feed(int(descriptor)), Renderer(renderer_type, Quality(*quality))
    window = ViewerWindow(feed, renderer)
    feed.disconnected.connect(window.close)
    window.show()
    renderer.start()
    return application.exec_()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
