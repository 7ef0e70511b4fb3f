"""An observer's process: JSON lines to it and from it, each with a time limit."""

import json
import pathlib
import subprocess
import sys
import threading

from figures import BenchError

SCRIPT = pathlib.Path(__file__).resolve().parents[1] / "observe.py"
ANSWER_LIMIT = 60.0  # wall time for an answer [s]; a service has 30 s of its own


class Silent(BenchError):
    """An observer gave no answer in time."""


class Observer:
    """Starts an observer and asks it.

    Args:
        name: Of its module.
        environment: Of its process.
        log: File for what it says on stderr.
    """

    def __init__(self, name, environment, log):
        self._process = subprocess.Popen(
            [sys.executable, str(SCRIPT), name],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        )
        self._lines, self._changed = [], threading.Condition()
        self._unwanted, self._ended = 0, False  # answers to come that nobody waits for
        self._asking = threading.Lock()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        with self._process.stdout as lines:
            for line in lines:
                with self._changed:
                    if self._unwanted:
                        self._unwanted -= 1
                        continue
                    self._lines.append(line)
                    self._changed.notify_all()
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def ask(self, limit=ANSWER_LIMIT, **question):
        """Sends a question and waits for its answer, a dict.

        Raises:
            Silent: There is none within the limit [s].
            BenchError: The observer has ended.
        """
        with self._asking:
            self._send(question)
            with self._changed:
                if not self._changed.wait_for(lambda: self._lines or self._ended, limit):
                    self._unwanted += 1
                    raise Silent(f"{question} was not answered within {limit:g} s")
                if self._lines:
                    return json.loads(self._lines.pop(0))
        raise BenchError(f"an observer ended early (exit status {self._process.wait()})")

    def tell(self, **question):
        """Sends a question whose answer nobody waits for."""
        with self._asking:
            with self._changed:
                self._unwanted += 1
            self._send(question)

    def _send(self, question):
        try:
            self._process.stdin.write(json.dumps(question) + "\n")
            self._process.stdin.flush()
        except OSError:
            pass  # it has ended, which ask() says

    def close(self):
        """Ends it."""
        self._process.kill()
        self._process.wait()
        try:
            self._process.stdin.close()
        except OSError:  # with a question that it has not read
            pass
