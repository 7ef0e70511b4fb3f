"""Drives while a button is held; one zero when it is let go."""

STILL = (0.0,) * 6


class Deadman:
    """Turns a pad's messages into commands.

    Args:
        mapping: Mapping.
    """

    def __init__(self, mapping):
        self._mapping = mapping
        self._stopped = False

    def command(self, axes, buttons):
        """Takes one message of the pad.

        Args:
            axes: Joy.axes.
            buttons: Joy.buttons.

        Returns:
            (x, y, z [m/s], roll, pitch, yaw [rad/s]), or None when there is nothing to send.
        """
        turbo = self._held(self._mapping.turbo_button, buttons)
        if turbo or self._held(self._mapping.enable_button, buttons):
            self._stopped = False
            return self._mapping.velocity(axes, turbo)
        if self._stopped:
            return None
        self._stopped = True
        return STILL

    @staticmethod
    def _held(number, buttons):
        return 0 <= number < len(buttons) and bool(buttons[number])
