"""Commands of the window: timed moves, held commands, stop. No Qt, no ROS."""


class Mover:
    """Publishes commands, ends timed moves and repeats a moving car's command.

    It never blocks: a timer has to call tick() while `active` is true.
    """

    def __init__(self, publish, clock, repeat_rate=10.0):
        """Starts at rest.

        Args:
            publish: Function (linear, angular), called for each command.
            clock: Function that gives the ROS time [s].
            repeat_rate: Repetitions of a moving command [Hz].
        """
        self._publish = publish
        self._clock = clock
        self._period = 1.0 / repeat_rate
        self._since = 0.0  # start of the running move [s]
        self._duration = None  # of the running timed move [s]; None: no timed move
        self._sent = 0.0  # when the command was sent last [s]
        self.command = (0.0, 0.0)

    @property
    def active(self):
        """Whether tick() is needed: a timed move runs or the commanded speed is not 0."""
        return self._duration is not None or self.command[0] != 0.0

    def move(self, linear, angular, duration):
        """Commands for a time, then zero.

        Args:
            linear: linear.x of the command.
            angular: angular.z of the command.
            duration: ROS time [s] after which zero is sent.
        """
        self._since, self._duration = self._clock(), duration
        self._send(linear, angular)

    def hold(self, linear, angular):
        """Commands until the next command; a running timed move ends."""
        self._duration = None
        self._send(linear, angular)

    def stop(self):
        """Commands zero once, at once, and nothing after it."""
        self.hold(0.0, 0.0)

    def tick(self):
        """Ends a timed move whose time is over, and repeats the command when that is due.

        A clock that jumps backwards (the simulation was reset) ends a timed move, too.
        """
        if not self.active:
            return
        now = self._clock()
        if self._duration is not None and not 0.0 <= now - self._since < self._duration - 1e-9:
            self.stop()
        elif not 0.0 <= now - self._sent < self._period - 1e-9:
            self._send(*self.command)

    def _send(self, linear, angular):
        self.command = (linear, angular)
        self._sent = self._clock()
        self._publish(linear, angular)
