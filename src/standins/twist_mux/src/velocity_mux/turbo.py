"""The joystick's speed scale: so many equal steps between a smallest and a largest speed."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Range:
    """Speeds of the first and the last step [m/s or rad/s]."""

    smallest: float
    largest: float

    def at(self, step, steps):
        """Speed at a step, 1..steps; with one step alone the smallest."""
        if steps == 1:
            return self.smallest
        return self.smallest + (self.largest - self.smallest) * (step - 1) / (steps - 1)


class Turbo:
    """Steps for driving and for turning, changed by buttons.

    Args:
        parameters: Values of `~turbo`: steps, init_step, linear_forward_min, _max and so on.

    Raises:
        ValueError: A value is no positive number.
    """

    def __init__(self, parameters):
        def number(name, default):
            value = parameters.get(name, default)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not value > 0:
                raise ValueError(f"turbo/{name} is {value!r}, must be a number above 0")
            return value

        def speeds(name, default):
            return Range(
                number(name + "_min", default.smallest), number(name + "_max", default.largest)
            )

        one = Range(1.0, 1.0)
        self.steps = int(number("steps", 1))
        self.forward = speeds("linear_forward", one)
        self.backward = speeds("linear_backward", self.forward)
        self.lateral = speeds("linear_lateral", one)
        self.angular = speeds("angular", one)
        middle = (self.steps + 1) // 2
        first = parameters.get("init_step", middle)
        self._first = int(first) if 1 <= first <= self.steps else middle
        self.reset()

    def reset(self):
        """Back to the first steps."""
        self.step = self.angular_step = self._first

    def change(self, by):
        """One step more (1) or less (-1) of both."""
        self.step = min(max(self.step + by, 1), self.steps)
        self.change_angular(by)

    def change_angular(self, by):
        """One step more (1) or less (-1) of the turn rate."""
        self.angular_step = min(max(self.angular_step + by, 1), self.steps)

    def scale(self, x, y, turn):
        """Speeds of a joystick's command.

        Args:
            x: Forward, -1..1.
            y: To the left, -1..1.
            turn: To the left, -1..1.

        Returns:
            (forward [m/s], left [m/s], turn rate [rad/s]).

        Raises:
            ValueError: A number is not within -1..1.
        """
        for name, value in (("linear.x", x), ("linear.y", y), ("angular.z", turn)):
            if not -1.0 <= value <= 1.0:
                raise ValueError(f"{name} is {value:g}, must be within -1..1")
        ahead = self.forward if x >= 0.0 else self.backward
        return (
            x * ahead.at(self.step, self.steps),
            y * self.lateral.at(self.step, self.steps),
            turn * self.angular.at(self.angular_step, self.steps),
        )
