"""Trials as processes that can all be ended at once."""

import os
import signal
import subprocess
import threading


class Processes:
    """Runs processes, one for each thread that asks."""

    def __init__(self):
        self._lock, self._running, self._ended = threading.Lock(), set(), False

    def run(self, command, log):
        """Run a program to its end.

        Args:
            command: words.
            log: path of the file for what it prints.

        Returns:
            Its exit status; None: end() was called.
        """
        with open(log, "w", encoding="utf-8") as stream:
            with self._lock:
                if self._ended:
                    return None
                process = subprocess.Popen(
                    command, stdout=stream, stderr=stream, start_new_session=True
                )
                self._running.add(process)
            status = process.wait()
        with self._lock:
            self._running.discard(process)
            return None if self._ended else status

    def end(self):
        """End all that run, with what they have started, and start no more."""
        with self._lock:
            self._ended = True
            for process in self._running:
                try:
                    os.killpg(process.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass  # it has ended by itself
