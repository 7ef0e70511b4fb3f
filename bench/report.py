"""The figures as a table, as plots, and those of several sessions side by side."""

import json
from dataclasses import dataclass

import matplotlib
from figures import WITHIN, Spread, call
from sections import SECTIONS, section

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of the backend)

BLUE, RED, GREY = "#2f6f8f", "#b3541e", "#777777"
IDLE = 0.1  # processors that others may have on a machine that counts as idle


def save(figure, path):
    """Write a figure and close it."""
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def bars(spreads, path, label):
    """A bar for each median, with its range, and a line at 1.

    Args:
        spreads: dict of name -> Spread.figures().
    """
    names = list(spreads)
    medians = [spreads[name]["median"] for name in names]
    below = [spreads[name]["median"] - spreads[name]["least"] for name in names]
    above = [spreads[name]["greatest"] - spreads[name]["median"] for name in names]
    figure, axes = pyplot.subplots(figsize=(7, 1.0 + 0.35 * len(names)))
    axes.barh(names, medians, xerr=(below, above), color=BLUE, ecolor=RED, capsize=3)
    axes.axvline(1.0, color=GREY, linewidth=1)
    axes.set_xlim(left=0)
    axes.invert_yaxis()
    axes.set_xlabel(label)
    save(figure, path)


def lines(curves, path, x_label, y_label):
    """Curves from 0 up with a legend.

    Args:
        curves: dict of name -> (x values, y values).
    """
    figure, axes = pyplot.subplots(figsize=(6, 3.2))
    for name, (x, y) in curves.items():
        axes.plot(x, y, "o-", label=name)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.set_ylim(bottom=0)
    axes.legend()
    save(figure, path)


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        label: what it is about; the same in every run.
        value: Spread or number that is put beside those of other sessions; None: not.
        unit: of the value, "" for a ratio.
        form: how the value is written.
    """

    label: str
    text: str
    value: object = None
    unit: str = ""
    form: str = ".2f"


def ratio_row(label, figures, of, unit):
    """The Row of a ratio, see Pairs.figures.

    Args:
        figures: what Pairs.figures gave.
    """
    ratio = Spread.read(figures["ratio"])
    text = (
        f"{ratio.text()} of {of}, {figures['pairs']} pairs, "
        f"{figures['variant']['median']:.1f} / {figures['reference']['median']:.1f} {unit}"
    )
    if figures["against_reference"] == WITHIN:
        text += f"; {WITHIN}, no difference to call"
    return Row(label, text, ratio)


def compared(figures, other, name):
    """Words for a ratio beside another one's, both as Pairs.figures gave them."""
    verdict = call(Spread.read(figures["ratio"]), Spread.read(other["ratio"]))
    return f"{verdict} of {name}" if verdict == WITHIN else f"{verdict} than {name}"


def spent_text(spent):
    """Words for usage.summarise: who had the processors; roles below a hundredth are left out."""
    roles = sorted(spent["cpu"].items(), key=lambda item: -item[1])
    text = ", ".join(f"{role} {share:.2f}" for role, share in roles if share >= 0.01) or "nobody"
    text += (
        f"; others {spent['others']:.2f} (most {spent['others_most']:.2f}), stolen "
        f"{spent['stolen']:.2f} (most {spent['stolen_most']:.2f})"
    )
    thread = spent["threads"].get("simulation")
    if thread:
        text += (
            f"; simulation thread switched off {thread['switched_off']:.0f} times a second, "
            f"ready but without a processor {100 * thread['waited']:.0f} % of the time"
        )
    return text


def busiest(result):
    """The most processors that others had or that were stolen, a median of some figure's rounds."""
    values = result.values() if isinstance(result, dict) else result
    found = [busiest(value) for value in values if isinstance(value, dict | list)]
    own = []
    if isinstance(result, dict) and "others" in result:
        own = [result["others"] + result["stolen"]]
    return max(found + own, default=0.0)


def rows_of(result):
    """The Rows of a result, section by section."""
    for name in SECTIONS:
        if name in result:
            yield from section(name).rows(result[name])


def table(result):
    """The table's text."""
    load = "/".join(f"{value:.1f}" for value in result["load_average"])
    lines = [f"{row.label:35} {row.text}" for row in rows_of(result)]
    lines += [f"{name} FAILED".ljust(36) + error for name, error in result["errors"].items()]
    lines.append(f"load average before {load} on {result['machine']['cpus']} processors")
    if busiest(result) > IDLE:
        lines.append(
            f"others had up to {busiest(result):.2f} processors meanwhile: this was no idle "
            "machine, the figures are disturbed"
        )
    if result["quick"]:
        lines.append("a quick run: fewer pairs in shorter rounds; its figures are not to be quoted")
    return "\n".join(lines)


def read_sessions(paths, form):
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


def _median(row):
    return row.value.median if isinstance(row.value, Spread) else row.value


def _cell(row):
    if isinstance(row.value, Spread) and row.value.count > 1:
        return (
            f"{row.value.median:{row.form}} ({row.value.least:{row.form}} to "
            f"{row.value.greatest:{row.form}})"
        )
    return f"{_median(row):{row.form}}"


def merged(results):
    """The Markdown table: a line for each value, a column for each session, and their range.

    A session that lacks a value has an empty cell. Below it says what keeps the sessions from
    being comparable.
    """
    sessions = [
        {row.label: row for row in rows_of(result) if row.value is not None} for result in results
    ]
    labels = list(dict.fromkeys(label for rows in sessions for label in rows))
    heads = [result["date"] for result in results]
    lines = [
        "| what | " + " | ".join(heads) + " | medians |",
        "| --- |" + " --- |" * (len(heads) + 1),
    ]
    for label in labels:
        found = [rows[label] for rows in sessions if label in rows]
        least, greatest = min(map(_median, found)), max(map(_median, found))
        unit, form = found[0].unit, found[0].form
        cells = [_cell(rows[label]) if label in rows else "" for rows in sessions]
        both = f"{least:{form}} to {greatest:{form}}" if len(found) > 1 else f"{least:{form}}"
        lines.append(f"| {label} | " + " | ".join(cells) + f" | {both} {unit}".rstrip() + " |")
    return "\n".join([*lines, *_warnings(results)])


def _warnings(results):
    if len({json.dumps(result["machine"], sort_keys=True) for result in results}) > 1:
        yield "\nThe sessions were on different machines."
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
