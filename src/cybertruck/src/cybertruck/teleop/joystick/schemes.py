"""The two ways to drive with a pad: pad states -> wanted motion. No ROS."""

from dataclasses import dataclass

from cybertruck.teleop.speeds import Speeds


@dataclass(frozen=True)
class Scheme:
    """Functions of a pad's sticks, triggers and buttons.

    Attributes:
        drive: Function (PadState) -> -1..1, forward positive.
        buttons: Name of a button -> action: a step of Speeds.apply, "stop" or "continuous".
        help: Lines of key help.
    """

    drive: object
    buttons: dict
    help: tuple


SCHEMES = {
    "traditional": Scheme(
        lambda pad: pad.triggers["r2"] - pad.triggers["l2"],
        {
            "triangle": "turn_faster",
            "cross": "turn_slower",
            "square": "faster",
            "circle": "slower",
            "l1": "stop",
            "r1": "reset",
            "r3": "continuous",
        },
        (
            "R2, L2             forward, backward",
            "left stick         wheels left, right",
            "Triangle / Cross   turning +10 % / -10 %",
            "Square / Circle    speed +10 % / -10 %",
            "R1   speeds back to the defaults",
            "L1   stop",
            "R3   held or continuous mode",
            "Ctrl-C   end",
        ),
    ),
    "alternate": Scheme(
        lambda pad: -pad.sticks["left_y"],  # up drives backward
        {
            "circle": "reset",
            "cross": "stop",
            "square": "continuous",
            "l1": "turn_slower",
            "r1": "turn_faster",
            "l2": "slower",
            "r2": "faster",
        },
        (
            "left stick down, up       forward, backward",
            "left stick sideways       wheels left, right",
            "R1 / L1   turning +10 % / -10 %",
            "R2 / L2   speed +10 % / -10 %",
            "Circle    speeds back to the defaults",
            "Cross     stop",
            "Square    held or continuous mode",
            "Ctrl-C    end",
        ),
    ),
}


class PadTeleop:
    """Commands from a pad.

    In continuous mode the drive stays at the furthest pull since trigger or stick left its rest,
    until stop or the next pull. The wheels follow the stick in both modes.
    """

    def __init__(self, scheme, speeds=None):
        """Starts at rest in held mode.

        Args:
            scheme: Key of SCHEMES.
            speeds: Speeds; None: the defaults.

        Raises:
            ValueError: There is no such scheme.
        """
        if scheme not in SCHEMES:
            raise ValueError(f"scheme is {scheme!r}; it must be one of {', '.join(SCHEMES)}")
        self.scheme = SCHEMES[scheme]
        self.speeds = speeds or Speeds()
        self.continuous = False
        self.halt()

    def halt(self):
        """Ends all motion: the pad is lost or its message invalid."""
        self._drive, self._turn = 0.0, 0.0
        self._live, self._stopped = 0.0, False

    def update(self, pad):
        """Updates with a pad state.

        Args:
            pad: PadState.
        """
        live = self.scheme.drive(pad)
        self._turn = pad.sticks["left_x"]
        if live == 0.0:
            self._stopped = False  # after a stop the drive must go through rest
        for name in sorted(pad.pressed & self.scheme.buttons.keys()):
            action = self.scheme.buttons[name]
            if action == "stop":
                self._drive, self._stopped = 0.0, live != 0.0
            elif action == "continuous":
                self.continuous = not self.continuous
            else:
                self.speeds.apply(action)
        if self._stopped:
            self._drive = 0.0
        elif not self.continuous:
            self._drive = live
        elif live != 0.0:
            new_pull = self._live == 0.0 or live * self._drive <= 0.0
            self._drive = live if new_pull or abs(live) > abs(self._drive) else self._drive
        self._live = live

    @property
    def motion(self):
        """Drive and turn of the wheels as signs, for the picture."""
        drive = (self._drive > 0.0) - (self._drive < 0.0)
        turn = (self._turn > 0.0) - (self._turn < 0.0)
        return (drive, turn) if drive else (0, 0)

    @property
    def wanted(self):
        """The wanted command: (linear.x [m/s], angular.z [rad/s]); the stick moves the wheels."""
        if self._drive == 0.0:
            return 0.0, 0.0
        sign = 1.0 if self._drive > 0.0 else -1.0
        return (self._drive * self.speeds.linear, sign * self._turn * self.speeds.angular + 0.0)
