"""The two speeds of a teleop, set in steps of ten percent."""

from paddock_common.rules import Number

STEP_UP, STEP_DOWN = 1.1, 0.9  # one step of ten percent
LEAST = 0.01  # least speeds [m/s, rad/s], so that they can grow again


class Speeds:
    """Linear and angular speed of a teleop, changed in steps and within limits."""

    def __init__(self, linear=0.5, angular=0.5, max_linear=3.0, max_angular=3.0):
        """Sets the defaults, to which reset() returns.

        Args:
            linear: Default speed [m/s].
            angular: Default turning speed [rad/s].
            max_linear: Greatest speed [m/s].
            max_angular: Greatest turning speed [rad/s].

        Raises:
            ValueError: A default is no number within the limits.
        """
        for name, value, most in (
            ("linear_speed", linear, max_linear),
            ("angular_speed", angular, max_angular),
        ):
            Number(least=LEAST, most=most).check(name, value)
        self._defaults = (float(linear), float(angular))
        self._most = (max_linear, max_angular)
        self.reset()

    def reset(self):
        """Sets both speeds back to the defaults."""
        self.linear, self.angular = self._defaults

    def scale_linear(self, factor):
        """Multiplies the speed, within the limits."""
        self.linear = min(max(self.linear * factor, LEAST), self._most[0])

    def scale_angular(self, factor):
        """Multiplies the turning speed, within the limits."""
        self.angular = min(max(self.angular * factor, LEAST), self._most[1])

    def apply(self, action):
        """Does a named step.

        Args:
            action: "faster", "slower", "turn_faster", "turn_slower" or "reset".
        """
        {
            "faster": lambda: self.scale_linear(STEP_UP),
            "slower": lambda: self.scale_linear(STEP_DOWN),
            "turn_faster": lambda: self.scale_angular(STEP_UP),
            "turn_slower": lambda: self.scale_angular(STEP_DOWN),
            "reset": self.reset,
        }[action]()
