"""Who drives: of the sources that are heard and not locked, the one of the highest priority."""


class Heard:
    """When something was last heard.

    Args:
        entry: Entry.
    """

    def __init__(self, entry):
        self.entry = entry
        self._time = None

    def note(self, now):
        """It was heard at a time [s]."""
        self._time = now

    def expired(self, now):
        """Whether it was never heard, or longer ago than its timeout; never if that is 0.

        A time before the last message (the clock was set back) counts as longer ago.
        """
        if self.entry.timeout == 0.0:
            return False
        return self._time is None or not 0.0 <= now - self._time <= self.entry.timeout


class Lock(Heard):
    """A lock and its last word."""

    def __init__(self, entry):
        super().__init__(entry)
        self.value = False

    def locked(self, now):
        """Whether it is set, or fell silent."""
        return self.value or self.expired(now)


class Mux:
    """Sources and locks.

    Args:
        topics: Entry of each source.
        locks: Entry of each lock.
    """

    def __init__(self, topics, locks):
        self.sources = [Heard(entry) for entry in topics]
        self.locks = [Lock(entry) for entry in locks]

    def command(self, number, now):
        """A source sent a command.

        Args:
            number: Its place in `topics`.
            now: Time [s].

        Returns:
            Whether the command passes.
        """
        self.sources[number].note(now)
        return self.driving(now) == number

    def lock(self, number, value, now):
        """A lock was set or opened at a time [s]."""
        self.locks[number].value = bool(value)
        self.locks[number].note(now)

    def lock_priority(self, now):
        """Sources below this priority are stopped."""
        return max((item.entry.priority for item in self.locks if item.locked(now)), default=0)

    def masked(self, number, now):
        """Whether a source is silent or locked."""
        source = self.sources[number]
        return source.expired(now) or source.entry.priority < self.lock_priority(now)

    def driving(self, now):
        """Place in `topics` of the source that drives, or None.

        Of equal priorities the first in the list drives. A source of priority 0 never does.
        """
        best = None
        for number, source in enumerate(self.sources):
            priority = source.entry.priority
            if priority > (self.sources[best].entry.priority if best is not None else 0):
                if not self.masked(number, now):
                    best = number
        return best
