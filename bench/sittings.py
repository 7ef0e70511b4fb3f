"""Several runs in one table of ranges: what one sitting says is true of that sitting only."""

import json

from report import IDLE, busiest, rows_of
from spread import Spread


def read_sittings(paths, form):
    """Read the JSON that runs of the bench have written.

    Args:
        paths: of the files, pathlib.Path.
        form: number of the format that is understood.

    Returns:
        list of results, by date.

    Raises:
        ValueError: a file cannot be read, is of another format, or holds the same run as another.
    """
    results, dates = [], {}
    for path in paths:
        try:
            result = json.loads(path.read_text())
        except (OSError, ValueError) as error:
            raise ValueError(f"{path} cannot be read as a bench.json: {error}") from error
        found = result.get("format") if isinstance(result, dict) else None
        if found != form:
            raise ValueError(f"{path} is of the format {found}, it must be {form}; measure again")
        if result["date"] in dates:
            raise ValueError(f"{path} holds the same run as {dates[result['date']]}")
        dates[result["date"]] = path
        results.append(result)
    return sorted(results, key=lambda result: result["date"])


def _middle(row):
    return row.value.median if isinstance(row.value, Spread) else row.value


def _cell(row):
    if isinstance(row.value, Spread) and row.value.count > 1:
        return (
            f"{row.value.median:{row.form}} ({row.value.least:{row.form}} to "
            f"{row.value.greatest:{row.form}})"
        )
    return f"{_middle(row):{row.form}}"


def merged(results):
    """The Markdown table: a line for each value, a column for each sitting, and their range.

    A sitting that lacks a value has an empty cell. Below it says what keeps the sittings from
    being comparable.
    """
    sittings = [
        {row.label: row for row in rows_of(result) if row.value is not None} for result in results
    ]
    labels = list(dict.fromkeys(label for rows in sittings for label in rows))
    heads = [result["date"] for result in results]
    lines = [
        "| what | " + " | ".join(heads) + " | medians |",
        "| --- |" + " --- |" * (len(heads) + 1),
    ]
    for label in labels:
        found = [rows[label] for rows in sittings if label in rows]
        least, greatest = min(map(_middle, found)), max(map(_middle, found))
        unit, form = found[0].unit, found[0].form
        cells = [_cell(rows[label]) if label in rows else "" for rows in sittings]
        both = f"{least:{form}} to {greatest:{form}}" if len(found) > 1 else f"{least:{form}}"
        lines.append(f"| {label} | " + " | ".join(cells) + f" | {both} {unit}".rstrip() + " |")
    return "\n".join([*lines, *_doubts(results)])


def _doubts(results):
    if len({json.dumps(result["machine"], sort_keys=True) for result in results}) > 1:
        yield "\nThe sittings were on different machines."
    quick = [result["date"] for result in results if result["quick"]]
    if quick:
        yield f"\nQuick runs, not to be quoted: {', '.join(quick)}."
    for result in results:
        if busiest(result) > IDLE:
            yield (
                f"\nNot an idle machine in {result['date']}: others had up to "
                f"{busiest(result):.2f} processors."
            )
        if result["errors"]:
            yield f"\nFailed in {result['date']}: {', '.join(result['errors'])}."
