"""Selects one of several sources of twists: priorities, time-outs, locks."""

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
        timeout: Age at which a message expires [s]; 0: never.
        priority: 0..255.
    """

    name: str
    topic: str
    timeout: float
    priority: int


def read(list_name, value):
    """Reads one of the two lists; an invalid entry is skipped.

    Args:
        list_name: "topics" or "locks", for the messages.

    Returns:
        (entries, one message for each entry that is skipped or changed).
    """
    if not isinstance(value, list):
        return [], [
            f"{list_name} is {value!r}, must be a list of entries with {', '.join(MEMBERS)}"
        ]
    entries, problems = [], []
    for index, item in enumerate(value):
        try:
            entry = _entry(item)
        except ValueError as error:
            problems.append(f"{list_name}[{index}] is skipped: {error}")
            continue
        priority = min(max(entry.priority, PRIORITIES[0]), PRIORITIES[1])
        if priority != entry.priority:
            problems.append(
                f"{list_name}[{index}]: priority is {entry.priority}, must be 0..255; "
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


class Input:
    """An entry and the time of its last message."""

    def __init__(self, entry):
        self.entry = entry
        self._time = None

    def update(self, now):
        """Stores the time of a message [s]."""
        self._time = now

    def expired(self, now):
        """Whether there was no message within its timeout; never if that is 0.

        A time before the last message (the clock was set back) counts as expired.
        """
        if self.entry.timeout == 0.0:
            return False
        return self._time is None or not 0.0 <= now - self._time <= self.entry.timeout


class Lock(Input):
    """A lock and its last value."""

    def __init__(self, entry):
        super().__init__(entry)
        self.value = False

    def locked(self, now):
        """Whether it is set or has expired."""
        return self.value or self.expired(now)


class Mux:
    """Sources and locks.

    Args:
        topics: Entry of each source.
        locks: Entry of each lock.
    """

    def __init__(self, topics, locks):
        self.sources = [Input(entry) for entry in topics]
        self.locks = [Lock(entry) for entry in locks]

    def command(self, index, now):
        """A source sent a command.

        Args:
            index: In `topics`.
            now: Time [s].

        Returns:
            Whether the command passes.
        """
        self.sources[index].update(now)
        return self.active_source(now) == index

    def lock(self, index, value, now):
        """A lock was set or released at a time [s]."""
        self.locks[index].value = bool(value)
        self.locks[index].update(now)

    def lock_priority(self, now):
        """Sources below this priority are stopped."""
        return max((item.entry.priority for item in self.locks if item.locked(now)), default=0)

    def masked(self, index, now):
        """Whether a source is expired or locked."""
        source = self.sources[index]
        return source.expired(now) or source.entry.priority < self.lock_priority(now)

    def active_source(self, now):
        """Index in `topics` of the active source, or None.

        Of equal priorities the first in the list is active. A source of priority 0 never is.
        """
        best = None
        for index, source in enumerate(self.sources):
            priority = source.entry.priority
            if priority > (self.sources[best].entry.priority if best is not None else 0):
                if not self.masked(index, now):
                    best = index
        return best
