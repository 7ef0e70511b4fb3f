"""Which of several sources of twists counts: priorities, time-outs, locks."""

from dataclasses import dataclass

from paddock_common.settings import converted

MEMBERS = ("name", "topic", "timeout", "priority")
PRIORITIES = (0, 255)


@dataclass(frozen=True)
class Entry:
    """One source of commands, or one lock.

    Attributes:
        name: Any.
        topic: Relative to the node's namespace.
        timeout: Age at which what was heard counts no more [s]; 0: it always counts.
        priority: 0..255.
    """

    name: str
    topic: str
    timeout: float
    priority: int


def read(kind, value):
    """Reads one of the two lists; a wrong entry costs nothing but itself.

    Args:
        kind: "topics" or "locks", for the words.
        value: The parameter's value.

    Returns:
        (entries, one sentence for each entry that is left out or changed).
    """
    if not isinstance(value, list):
        return [], [f"{kind} is {value!r}, must be a list of entries with {', '.join(MEMBERS)}"]
    entries, problems = [], []
    for number, item in enumerate(value):
        try:
            entry = _entry(item)
        except ValueError as error:
            problems.append(f"{kind}[{number}] is left out: {error}")
            continue
        priority = min(max(entry.priority, PRIORITIES[0]), PRIORITIES[1])
        if priority != entry.priority:
            problems.append(
                f"{kind}[{number}]: priority is {entry.priority}, must be 0..255; "
                f"{priority} is used"
            )
        entries.append(Entry(entry.name, entry.topic, entry.timeout, priority))
    return entries, problems


def _entry(item):
    if not isinstance(item, dict):
        raise ValueError(f"it is {item!r}, must have {', '.join(MEMBERS)}")
    missing = [member for member in MEMBERS if member not in item]
    if missing:
        raise ValueError(f"it has no {', '.join(missing)}")
    topic = item["topic"]
    if not isinstance(topic, str) or not topic.strip():
        raise ValueError(f"topic is {topic!r}, must be a name")
    timeout, priority = (converted(member, item[member]) for member in ("timeout", "priority"))
    if not timeout >= 0.0:
        raise ValueError(f"timeout is {item['timeout']!r}, must be 0 s or more")
    return Entry(str(item["name"]), topic.strip(), timeout, int(priority))


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
