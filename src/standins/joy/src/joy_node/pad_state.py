"""A pad's raw values -> sensor_msgs/Joy, in the order of Linux' joystick driver."""

REST_NOISE = (
    0.02  # part of the full range: an axis that moved less since the start counts as not moved
)


class PadState:
    """Axes and buttons of one pad.

    Axes are positive to the left and up, -1..1; a hat (the cross of four arrows) gives two axes
    after all others. A trigger rests at 1 and goes to -1, but the driver cannot know which axis is
    a trigger: like upstream, an axis is 0 until it is first moved, unless default_trigger is set.

    Args:
        deadzone: part of an axis' range around its middle that counts as 0; the rest is scaled.
        default_trigger: report an axis unchanged from the start.
        sticky_buttons: a press toggles a button, a release does nothing.
    """

    def __init__(self, deadzone=0.05, default_trigger=False, sticky_buttons=False):
        if not 0.0 <= deadzone < 1.0:
            raise ValueError(f"deadzone is {deadzone!r}, must be 0 or more and below 1")
        self._deadzone, self._default_trigger = deadzone, default_trigger
        self._sticky = sticky_buttons
        self.clear()

    def clear(self):
        """Reset for another pad, or for this one reconnected."""
        self._rest = None
        self._moved = set()
        self._raw_buttons = []
        self.axes, self.buttons = [], []

    def zero(self):
        """All axes and buttons 0, as many as there were."""
        self.axes, self.buttons = [0.0] * len(self.axes), [0] * len(self.buttons)

    def update(self, raw_axes, raw_buttons, hats=()):
        """Update with a reading.

        Args:
            raw_axes: -1..1 each, positive to the right and down.
            raw_buttons: 0 or 1 each.
            hats: (x, y) each, -1, 0 or 1, positive to the right and up.

        Returns:
            (whether an axis changed, whether a button changed).
        """
        raw = [float(value) for value in raw_axes]
        for x, y in hats:
            raw += [float(x), -float(y)]
        if self._rest is None or len(self._rest) != len(raw):
            self._rest, self._moved = list(raw), set()
        self._moved |= {
            number
            for number, value in enumerate(raw)
            if abs(value - self._rest[number]) > REST_NOISE
        }
        axes = [self._axis(number, value) for number, value in enumerate(raw)]
        buttons = self._pressed([int(bool(value)) for value in raw_buttons])
        changed = axes != self.axes, buttons != self.buttons
        self.axes, self.buttons = axes, buttons
        return changed

    def _axis(self, number, value):
        if not self._default_trigger and number not in self._moved:
            return 0.0
        way = max(0.0, abs(value) - self._deadzone) / (1.0 - self._deadzone)
        return min(1.0, way) * (-1.0 if value > 0 else 1.0) if way else 0.0

    def _pressed(self, raw):
        if not self._sticky:
            return raw
        before = self._raw_buttons + [0] * (len(raw) - len(self._raw_buttons))
        held = self.buttons + [0] * (len(raw) - len(self.buttons))
        self._raw_buttons = raw
        return [
            int(not old) if now and not was else old for old, was, now in zip(held, before, raw)
        ]
