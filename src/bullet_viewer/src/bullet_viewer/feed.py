"""The viewer's side of the socket to the bridge.

Messages, pickled tuples through a multiprocessing Connection:
    to the bridge     ('view',), ('pause',), ('unpause',), ('step', count), ('reset',),
                      ('show', selected model's name or '', whether contacts are requested)
    from the bridge   ('view', WorldView) for each 'view', ('error', text) for a failed request
The bridge only responds to requests, so a slow or hidden window costs the simulation nothing.
"""

from multiprocessing.connection import Connection

from PyQt5.QtCore import QObject, QSocketNotifier, pyqtSignal


class Feed(QObject):
    """Messages as Qt signals.

    Args:
        descriptor: of the connected socket; the Feed closes it.
    """

    viewed = pyqtSignal(object)  # WorldView
    failed = pyqtSignal(str)
    disconnected = pyqtSignal()

    def __init__(self, descriptor):
        super().__init__()
        self._connection = Connection(descriptor)
        self._notifier = QSocketNotifier(descriptor, QSocketNotifier.Read, self)
        self._notifier.activated.connect(self._receive)

    def send(self, *message):
        """Send a message; a broken connection closes the feed."""
        try:
            self._connection.send(message)
        except OSError:
            self._disconnect()

    def close(self):
        """Close the connection; for the bridge the viewer has exited."""
        self._notifier.setEnabled(False)
        self._connection.close()

    def _receive(self, *_):
        try:
            message_type, content = self._connection.recv()
        except (EOFError, OSError):
            self._disconnect()
            return
        {"view": self.viewed, "error": self.failed}[message_type].emit(content)

    def _disconnect(self):
        if self._notifier.isEnabled():
            self._notifier.setEnabled(False)
            self.disconnected.emit()
