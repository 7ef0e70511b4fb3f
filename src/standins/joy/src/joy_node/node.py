"""The node joy_node: a gamepad's state, when it is published, the wait for a pad."""

import time

import rospy
from paddock_common.settings import Number, parameter
from sensor_msgs.msg import Joy

from joy_node.sdl_pads import SdlPads
from paddock_common import nodes


class PublishTimer:
    """Decides when to publish. All times are wall time: operators do not move in simulated time.

    Args:
        autorepeat_rate: messages per second while nothing changes [Hz]; 0: none.
        coalesce_interval: wait for more movement after the first [s].
    """

    def __init__(self, autorepeat_rate=0.0, coalesce_interval=0.001):
        for name, value in (
            ("autorepeat_rate", autorepeat_rate),
            ("coalesce_interval", coalesce_interval),
        ):
            if not 0.0 <= value < float("inf"):
                raise ValueError(f"{name} is {value!r}, must be 0 or more")
        if autorepeat_rate and coalesce_interval > 1.0 / autorepeat_rate:
            raise ValueError(
                f"coalesce_interval is {coalesce_interval:g} s, must be at most "
                f"{1.0 / autorepeat_rate:g} s, one period of autorepeat_rate"
            )
        self._repeat = 1.0 / autorepeat_rate if autorepeat_rate else float("inf")
        self._coalesce = coalesce_interval
        self._due, self._last = float("inf"), float("-inf")

    def input_changed(self, now, axis, button):
        """An axis or a button changed at wall time [s]."""
        if button:
            self._due = now
        elif axis:
            self._due = min(self._due, now + self._coalesce)

    def due(self, now):
        """Whether to publish now; if so, it counts as published."""
        if now < self._due and now - self._last < self._repeat:
            return False
        self._due, self._last = float("inf"), now
        return True

    def stop(self):
        """Publish nothing until an input changes."""
        self._due, self._last = float("inf"), float("inf")

    def start(self, now):
        self._due, self._last = float("inf"), now


# Fraction of the full range: an axis that moved less since the start counts as not moved.
REST_NOISE = 0.02


class PadState:
    """Axes and buttons of one pad.

    Axes are positive to the left and up, -1..1; a hat (the cross of four arrows) is two axes
    after all others. A trigger rests at 1 and goes to -1, but the driver cannot know which axis is
    a trigger: like upstream, an axis is 0 until it is first moved, unless default_trigger is set.

    Args:
        deadzone: fraction of an axis' range around its center that counts as 0; the rest is scaled.
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
            index for index, value in enumerate(raw) if abs(value - self._rest[index]) > REST_NOISE
        }
        axes = [self._axis(index, value) for index, value in enumerate(raw)]
        buttons = self._pressed([int(bool(value)) for value in raw_buttons])
        changed = axes != self.axes, buttons != self.buttons
        self.axes, self.buttons = axes, buttons
        return changed

    def _axis(self, index, value):
        if not self._default_trigger and index not in self._moved:
            return 0.0
        deflection = max(0.0, abs(value) - self._deadzone) / (1.0 - self._deadzone)
        return min(1.0, deflection) * (-1.0 if value > 0 else 1.0) if deflection else 0.0

    def _pressed(self, raw):
        if not self._sticky:
            return raw
        before = self._raw_buttons + [0] * (len(raw) - len(self._raw_buttons))
        states = self.buttons + [0] * (len(raw) - len(self.buttons))
        self._raw_buttons = raw
        return [
            int(not old) if now and not was else old for old, was, now in zip(states, before, raw)
        ]


RETRY_PERIOD = 1.0  # wall time between two checks for a missing pad [s]


class Driver:
    """Reads one pad and sends its state.

    Args:
        open_pad: function -> pad or None. A pad has name, attached(), read() -> (axes, buttons,
            hats) for PadState.update, and close().
        send: function (axes, buttons).
        log, warn: functions (text): a pad that was found, one that is missing.
        clock: function -> wall time [s].
        label: name of the pad for the log.
    """

    def __init__(
        self, open_pad, state, timer, send, log, warn, clock=time.monotonic, label="a joystick"
    ):
        self._label = label
        self._open_pad, self._state, self._timer = open_pad, state, timer
        self._send, self._log, self._warn, self._clock = send, log, warn, clock
        self._pad, self._next_check, self._logged = None, float("-inf"), False

    def spin_once(self):
        """One round; returns whether there is a pad."""
        now = self._clock()
        if self._pad is None and not self._open(now):
            return False
        if not self._pad.attached():
            self._disconnect(now)
            return False
        self._timer.input_changed(now, *self._state.update(*self._pad.read()))
        if self._timer.due(now):
            self._send(self._state.axes, self._state.buttons)
        return True

    def _open(self, now):
        if now < self._next_check:
            return False
        self._next_check = now + RETRY_PERIOD
        self._pad = self._open_pad()
        if self._pad is None:
            if not self._logged:
                self._warn(f"waiting for {self._label}, checking every {RETRY_PERIOD:g} s")
            self._logged = True
            return False
        self._logged = False
        self._state.clear()
        self._timer.start(now)
        self._log(f"joystick '{self._pad.name}'")
        return True

    def _disconnect(self, now):
        """Send zeros once: a client must not continue with the last values."""
        self._warn(
            f"joystick '{self._pad.name}' is disconnected; sent zeros; waiting for {self._label}, "
            f"checking every {RETRY_PERIOD:g} s"
        )
        self._pad.close()
        self._pad, self._next_check, self._logged = None, now + RETRY_PERIOD, True
        self._state.zero()
        self._timer.stop()
        self._send(self._state.axes, self._state.buttons)

    def close(self):
        if self._pad is not None:
            self._pad.close()
            self._pad = None


POLL_PERIOD = 0.004  # wall time between two readings [s]
IDLE_PERIOD = 0.1  # wall time between two checks without a pad [s]


def make_driver():
    """SdlPads and a Driver with this node's parameters.

    Raises:
        ValueError: names the parameter, its value and what is valid.
    """

    def number(name, default):
        return float(parameter(rospy.get_param, name, default, Number()))

    device = str(rospy.get_param("~dev", "/dev/input/js0"))
    pads = SdlPads(device, rospy.get_param("~dev_name", ""))
    publisher = rospy.Publisher("joy", Joy, queue_size=1)
    state = PadState(
        number("deadzone", 0.05),
        bool(rospy.get_param("~default_trig_val", False)),
        bool(rospy.get_param("~sticky_buttons", False)),
    )
    timer = PublishTimer(number("autorepeat_rate", 0.0), number("coalesce_interval", 0.001))

    def send(axes, buttons):
        message = Joy(axes=axes, buttons=buttons)
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = device
        publisher.publish(message)

    log = rospy.loginfo, rospy.logwarn  # a warning comes on the terminal also by output="log"
    return pads, Driver(pads.open, state, timer, send, *log, label=pads.label)


def main():
    pads, driver = nodes.start("joy_node", make_driver)
    while not rospy.is_shutdown():
        time.sleep(POLL_PERIOD if driver.spin_once() else IDLE_PERIOD)
    driver.close()
    pads.close()
