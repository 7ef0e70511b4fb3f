"""The lists `topics` and `locks` of the parameters, as upstream's YAML files write them."""

from dataclasses import dataclass

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
    timeout, priority = (_number(member, item[member]) for member in ("timeout", "priority"))
    if not timeout >= 0.0:
        raise ValueError(f"timeout is {item['timeout']!r}, must be 0 s or more")
    return Entry(str(item["name"]), topic.strip(), timeout, int(priority))


def _number(member, value):
    try:
        if isinstance(value, bool):
            raise ValueError
        number = float(value)
        if number - number != 0.0:
            raise ValueError
        return number
    except (TypeError, ValueError):
        raise ValueError(f"{member} is {value!r}, must be a number") from None
