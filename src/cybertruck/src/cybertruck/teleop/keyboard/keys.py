"""The keyboard teleop's logic: keys pressed and released -> wanted motion. No ROS, no terminal."""

from cybertruck.teleop.speeds import Speeds

DRIVE = {"up": 1, "down": -1}
TURN = {"left": 1, "right": -1}
SPEED_KEYS = {"q": "faster", "z": "slower", "w": "turn_faster", "x": "turn_slower", "r": "reset"}
STOP_KEY, MODE_KEY = "s", "mode"
KEYS = (*DRIVE, *TURN, *SPEED_KEYS, STOP_KEY, MODE_KEY)


class KeyTeleop:
    """Commands from the keys.

    Held mode: the truck moves while keys are down, and keys add up. Continuous mode: the motion
    stays when its keys are released. A drive arrow begins a new motion (with the turn arrows that
    are down at that moment), a turn arrow changes the turn of the running one, S ends it.
    """

    def __init__(self, speeds=None):
        """Starts at rest in held mode.

        Args:
            speeds: Speeds; None: the defaults.
        """
        self.speeds = speeds or Speeds()
        self.continuous = False
        self._down = set()  # keys that are down
        self._spent = set()  # keys that are down but were ended by S: they need a new press
        self._latched = (0, 0)  # drive and turn of continuous mode

    def press(self, key):
        """A key goes down; a key that is down already (auto-repeat) changes nothing.

        Args:
            key: One of KEYS; anything else is ignored.
        """
        if key not in KEYS or key in self._down:
            return
        self._down.add(key)
        if key in SPEED_KEYS:
            self.speeds.apply(SPEED_KEYS[key])
        elif key == STOP_KEY:
            self.stop()
        elif key == MODE_KEY:
            self.continuous = not self.continuous
            self._latched = self._held()
        elif key in DRIVE:
            self._latched = self._held()
        else:
            self._latched = (self._latched[0], self._held()[1])

    def release(self, key):
        """A key goes up."""
        self._down.discard(key)
        self._spent.discard(key)

    def release_all(self):
        """Releases all keys after their source is lost."""
        self._down.clear()
        self._spent.clear()

    def stop(self):
        """Ends all motion; keys that are down must be pressed again."""
        self._spent = set(self._down)
        self._latched = (0, 0)

    @property
    def motion(self):
        """Drive (1 forward, -1 backward, 0) and turn of the wheels (1 left, -1 right, 0)."""
        drive, turn = self._latched if self.continuous else self._held()
        return (drive, turn) if drive else (0, 0)

    @property
    def wanted(self):
        """The wanted command: (linear.x [m/s], angular.z [rad/s]).

        A turn alone gives no command: the truck cannot turn at rest. Backwards, wheels that point
        to the left turn the truck to the right.
        """
        drive, turn = self.motion
        return drive * self.speeds.linear, drive * turn * self.speeds.angular + 0.0

    def _held(self):
        """Returns the sum of the arrows that are down: (drive, turn)."""
        active = self._down - self._spent
        return (
            sum(value for key, value in DRIVE.items() if key in active),
            sum(value for key, value in TURN.items() if key in active),
        )
