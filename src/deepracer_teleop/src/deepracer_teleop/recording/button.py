"""The record button and its line in the window."""

import threading

from PyQt5.QtCore import QObject, pyqtSignal

from deepracer_teleop.recording.recording import Recording


class RecordButton(QObject):
    """Starts and ends recordings by a checkable button and shows them in a label.

    Args:
        button: QPushButton.
        label: QLabel, hidden until there is something to say.
        folder: For the recordings.
    """

    ended = pyqtSignal(str)  # from the thread that ends a recording to Qt's

    def __init__(self, button, label, folder):
        super().__init__(button)
        self._button, self._label, self._folder = button, label, folder
        self._recording = self._ending = None
        button.toggled.connect(self._toggle)
        self.ended.connect(self._show_end)

    @property
    def recording(self):
        """The running Recording, or None."""
        return self._recording

    def check(self):
        """Shows how far the recording is."""
        if self._recording is not None:
            self._show(self._recording.words())

    def finish(self):
        """Ends a running recording and waits for its files."""
        self._button.setChecked(False)
        if self._ending is not None:
            self._ending.join()

    def _toggle(self, on):
        if on:
            self._start()
        elif self._recording is not None:
            self._button.setEnabled(False)  # until the files are complete
            recording, self._recording = self._recording, None
            self._ending = threading.Thread(
                target=lambda: self._end(recording), name="record-end", daemon=True
            )
            self._ending.start()
        self._button.setText("Record" if self._recording is None else "End recording")

    def _start(self):
        recording = Recording(self._folder)
        try:
            recording.start()
        except OSError as error:
            self._show(f"Recording: {error}")
            self._button.setChecked(False)
            return
        self._recording = recording
        self.check()

    def _end(self, recording):
        """Ends a recording without holding up the window; runs in a thread of its own."""
        words = recording.stop()
        print(f"teleop: {words}", flush=True)
        try:
            self.ended.emit(words)
        except RuntimeError:  # the Qt object is deleted already
            pass

    def _show_end(self, words):
        self._button.setEnabled(True)
        self._show(words)

    def _show(self, words):
        if words != self._label.text():
            self._label.setText(words)
        self._label.show()
