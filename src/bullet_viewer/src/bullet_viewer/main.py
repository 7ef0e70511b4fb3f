"""The viewer process: python -m bullet_viewer.main SOCKET_FD auto|gl|tiny SHADOWS ANTIALIAS.

The bridge starts it with one end of a socket. When the bridge ends, also by a crash, the viewer
ends; when the viewer ends, the bridge only logs it. SIGINT is left to the bridge.
"""

import signal
import sys

from bullet_sim.render.request import Quality
from PyQt5.QtWidgets import QApplication

from bullet_viewer.feed import Feed
from bullet_viewer.window import Painter, ViewerWindow


def main(arguments):
    """Args: arguments: [socket file descriptor, renderer, Quality's values]. Returns the exit
    code.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    application = QApplication(["bullet_viewer"])
    descriptor, renderer, *quality = arguments
    feed, painter = Feed(int(descriptor)), Painter(renderer, Quality(*quality))
    window = ViewerWindow(feed, painter)
    feed.ended.connect(window.close)
    window.show()
    painter.start()
    return application.exec_()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
