"""Single keys from a terminal."""

import os
import select
import termios
import tty


class Terminal:
    """A terminal that hands out each key at once; to be used with `with`.

    Args:
        descriptor: File descriptor of the terminal.

    Raises:
        ValueError: It is no terminal.
    """

    def __init__(self, descriptor):
        if not os.isatty(descriptor):
            raise ValueError(
                "standard input is no terminal; start the node in one with rosrun, or in a launch "
                "file with launch-prefix, such as launch-prefix='xterm -e'"
            )
        self._descriptor = descriptor

    def __enter__(self):
        self._settings = termios.tcgetattr(self._descriptor)
        tty.setraw(self._descriptor, termios.TCSANOW)
        output_as_before = termios.tcgetattr(self._descriptor)
        output_as_before[1] = self._settings[1]  # lines still end at the left margin
        termios.tcsetattr(self._descriptor, termios.TCSANOW, output_as_before)
        return self

    def __exit__(self, *_):
        termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._settings)

    def key(self, timeout):
        """Waits for a key.

        Args:
            timeout: Longest wait in wall time [s]; None: for good.

        Returns:
            The key, "" when none came in time, or None when the terminal is gone.
        """
        ready, _, _ = select.select([self._descriptor], [], [], timeout)
        if not ready:
            return ""
        try:
            data = os.read(self._descriptor, 1)
        except OSError:
            return None
        return data.decode("latin-1") if data else None
