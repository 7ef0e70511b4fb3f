"""Keys from an X server through pynput: presses and releases, with any window focused."""

import os
import queue


class NoServer(RuntimeError):
    """No X server can be used; the text says why."""


class XKeys:
    """Collects key events in pynput's thread and processes them in the caller's."""

    def __init__(self, teleop):
        """Connects to the X server of DISPLAY.

        Args:
            teleop: KeyTeleop.

        Raises:
            NoServer: There is none, or pynput cannot use it.
        """
        display = os.environ.get("DISPLAY", "")
        if not display:
            raise NoServer("DISPLAY is not set")
        try:
            from Xlib.display import Display

            Display(display).close()  # for its clear error; pynput connects when it is imported
            from pynput import keyboard

            self._names = {
                getattr(keyboard.Key, name): name for name in ("up", "down", "left", "right")
            }
            self._names[keyboard.Key.caps_lock] = "mode"
            self._listener = keyboard.Listener(
                on_press=lambda key: self._events.put((True, key)),
                on_release=lambda key: self._events.put((False, key)),
            )
        except Exception as error:  # pynput and Xlib raise many kinds, ImportError among them
            reason = str(error).strip().splitlines()[0] if str(error).strip() else repr(error)
            raise NoServer(f"no X server at DISPLAY={display}: {reason}") from error
        self._events = queue.SimpleQueue()
        self._teleop = teleop
        self._listener.daemon = True
        self._listener.start()
        self._listener.wait()

    @property
    def alive(self):
        """Whether the X server still answers."""
        return self._listener.is_alive()

    def poll(self):
        """Processes the collected events. The server's auto-repeat is presses without releases."""
        while True:
            try:
                down, key = self._events.get_nowait()
            except queue.Empty:
                return
            name = self.name_of(key)
            if name is not None:
                (self._teleop.press if down else self._teleop.release)(name)

    def name_of(self, key):
        """Returns our name of a pynput key, or None."""
        if key in self._names:
            return self._names[key]
        character = getattr(key, "char", None)
        return character.lower() if character else None
