"""What is promised of an end, and a table of many."""

import statistics

PROMISE = 5.0  # [s] from the signal until nothing is left, where nobody else wants the processors


def limit(found):
    """Longest time [s] that an end may take: longer by what others have slowed it down.

    Args:
        found: Ending.
    """
    return PROMISE * found.slowdown


def broken(found, files=()):
    """Which promise an end has broken, one sentence; '' when it has kept all.

    Args:
        found: Ending.
        files: Names of temporary files that are left and should not be.
    """
    if found.left:
        return f"left {found.left} after {found.seconds:.1f} s"
    if found.seconds > limit(found):
        return f"took {words(found)}, at most {limit(found):.1f} s; {latest(found.lives)}"
    if files:
        return f"left files in the temporary folder: {list(files)}"
    return ""


def words(found):
    """The time of an end and what others have slowed it down."""
    if found.slowdown < 1.1:
        return f"{found.seconds:.1f} s"
    return f"{found.seconds:.1f} s (others slowed it down {found.slowdown:.1f} times)"


def latest(lives, count=4):
    """The last processes to end and when."""
    return "last came " + ", ".join(f"{role} {seconds:.1f} s" for role, seconds in lives[-count:])


def table(results, signals):
    """Times by state and signal, in Markdown.

    Args:
        results: list of dict of state, signal, seconds, slowdown, lives and problem.
        signals: Names of the columns.

    Returns:
        Lines.
    """
    states = list(dict.fromkeys(result["state"] for result in results))
    lines = ["Median and longest time until nothing was left [s], by state and signal:", ""]
    lines += [f"| state | {' | '.join(signals)} | by others | ended last |"]
    lines += ["| --- |" + " --- |" * (len(signals) + 2)]
    for state in states:
        mine = [result for result in results if result["state"] == state and result["lives"]]
        cells = [_cell([r["seconds"] for r in mine if r["signal"] == name]) for name in signals]
        slow = f"x {statistics.median(r['slowdown'] for r in mine):.1f}" if mine else ""
        lines.append(f"| {state} | {' | '.join(cells)} | {slow} | {_last(mine)} |")
    return lines


def _cell(seconds):
    return f"{statistics.median(seconds):.1f}, {max(seconds):.1f}" if seconds else ""


def _last(results, count=4):
    """Median time of the roles that end last."""
    times = {}
    for result in results:
        for role, seconds in dict(result["lives"]).items():
            times.setdefault(role, []).append(seconds)
    medians = {role: statistics.median(found) for role, found in times.items()}
    order = sorted(medians, key=medians.get)[-count:]
    return ", ".join(f"{role} {medians[role]:.1f}" for role in order)
