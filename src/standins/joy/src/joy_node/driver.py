"""The joystick driver: opens the pad, reads it, and notices when it is unplugged."""

import time

RETRY_PERIOD = 1.0  # wall time between two tries to open a missing pad [s]


class Driver:
    """Reads one pad and publishes its state.

    Args:
        open_pad: function -> pad or None. A pad has name, attached(), read() -> (axes, buttons,
            hats) as PadState.update takes them, and close().
        state: PadState.
        timer: PublishTimer.
        send: function (axes, buttons).
        log: function (text).
        clock: function -> wall time [s].
    """

    def __init__(self, open_pad, state, timer, send, log, clock=time.monotonic):
        self._open_pad, self._state, self._timer = open_pad, state, timer
        self._send, self._log, self._clock = send, log, clock
        self._pad, self._next_retry, self._logged = None, float("-inf"), False

    def spin_once(self):
        """Read and publish once; returns whether there is a pad."""
        now = self._clock()
        if self._pad is None and not self._connect(now):
            return False
        if not self._pad.attached():
            self._on_disconnect(now)
            return False
        self._timer.input_changed(now, *self._state.update(*self._pad.read()))
        if self._timer.due(now):
            self._send(self._state.axes, self._state.buttons)
        return True

    def _connect(self, now):
        if now < self._next_retry:
            return False
        self._next_retry = now + RETRY_PERIOD
        self._pad = self._open_pad()
        if self._pad is None:
            if not self._logged:
                self._log(f"no joystick yet; looking for one every {RETRY_PERIOD:g} s")
            self._logged = True
            return False
        self._logged = False
        self._state.clear()
        self._timer.start(now)
        self._log(f"joystick '{self._pad.name}'")
        return True

    def _on_disconnect(self, now):
        """Publish zeros once, so that no subscriber drives on with the last values."""
        self._log(f"joystick '{self._pad.name}' is gone; sent zeros")
        self._pad.close()
        self._pad, self._next_retry, self._logged = None, now + RETRY_PERIOD, True
        self._state.zero()
        self._timer.stop()
        self._send(self._state.axes, self._state.buttons)

    def close(self):
        """Close the pad."""
        if self._pad is not None:
            self._pad.close()
            self._pad = None
