"""The life of a joystick driver: look for the pad, read it, notice when it is gone."""

import time

RETRY_PERIOD = 1.0  # wall time between two looks for a missing pad [s]


class Driver:
    """Reads one pad and sends what it says.

    Args:
        open_pad: function -> pad or None. A pad has name, attached(), read() -> (axes, buttons,
            hats) as PadState.update takes them, and close().
        state: PadState.
        timer: PublishTimer.
        send: function (axes, buttons).
        log: function (text).
        clock: function -> wall time [s].
        wanted: what open_pad looks for, in words.
    """

    def __init__(
        self, open_pad, state, timer, send, log, clock=time.monotonic, wanted="a joystick"
    ):
        self._wanted = wanted
        self._open_pad, self._state, self._timer = open_pad, state, timer
        self._send, self._log, self._clock = send, log, clock
        self._pad, self._next_look, self._said = None, float("-inf"), False

    def spin_once(self):
        """One round; returns whether there is a pad."""
        now = self._clock()
        if self._pad is None and not self._found(now):
            return False
        if not self._pad.attached():
            self._lose(now)
            return False
        self._timer.input_changed(now, *self._state.update(*self._pad.read()))
        if self._timer.due(now):
            self._send(self._state.axes, self._state.buttons)
        return True

    def _found(self, now):
        if now < self._next_look:
            return False
        self._next_look = now + RETRY_PERIOD
        self._pad = self._open_pad()
        if self._pad is None:
            if not self._said:
                self._log(f"waiting for {self._wanted}; looking for it every {RETRY_PERIOD:g} s")
            self._said = True
            return False
        self._said = False
        self._state.clear()
        self._timer.start(now)
        self._log(f"joystick '{self._pad.name}'")
        return True

    def _lose(self, now):
        """Whoever drives by this pad must not go on with its last numbers: send zeros, once."""
        self._log(
            f"joystick '{self._pad.name}' is gone; sent zeros; waiting for {self._wanted}, looking "
            f"for it every {RETRY_PERIOD:g} s"
        )
        self._pad.close()
        self._pad, self._next_look, self._said = None, now + RETRY_PERIOD, True
        self._state.zero()
        self._timer.stop()
        self._send(self._state.axes, self._state.buttons)

    def close(self):
        """Let go of the pad."""
        if self._pad is not None:
            self._pad.close()
            self._pad = None
