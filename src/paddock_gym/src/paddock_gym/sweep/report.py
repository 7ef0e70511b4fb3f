"""Results of a sweep: table, CSV, plots."""

import csv
import os

import numpy as np
from matplotlib import pyplot

from paddock_gym.evaluation import plots

TABLE, CURVE, OPTIONS_PLOT = "table.csv", "history.png", "options.png"
MAX_ROWS = 20  # rows on the screen
COLUMNS = 3  # of panels


def write(rows, names, folder):
    """Write table and plots.

    Args:
        rows: of Study.rows().
        names: of the varied options.
    """
    with open(os.path.join(folder, TABLE), "w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["trial", *names, "seconds", "good", "starts"])
        for row in ranked(rows):
            options = [row["options"][name] for name in names]
            writer.writerow([row["number"], *options, f"{row['score']:.4f}", *good(row)])
    history(rows, os.path.join(folder, CURVE))
    by_option(rows, names, os.path.join(folder, OPTIONS_PLOT))


def ranked(rows):
    """Rows, best first."""
    return sorted(rows, key=lambda row: (row["score"], row["number"]))


def good(row):
    """(laps or goals reached, starts) of a row."""
    report = row["report"]
    if "good" in report:
        return report["good"], report["starts"]
    return report["laps"], report["evaluated_starts"]


def text_table(rows, names):
    """The best rows as lines of text."""
    lines = [("trial", *names, "seconds", "good")]
    for row in ranked(rows)[:MAX_ROWS]:
        options = [format_value(row["options"][name]) for name in names]
        reached = "{} of {}".format(*good(row))
        lines.append((str(row["number"]), *options, f"{row['score']:.2f}", reached))
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    return "\n".join("  ".join(f"{cell:{w}}" for cell, w in zip(line, widths)) for line in lines)


def history(rows, path):
    """Plot the scores in the order of the trials, and the best so far."""
    rows = sorted(rows, key=lambda row: row["number"])
    indices = [row["number"] for row in rows]
    scores = [row["score"] for row in rows]
    figure, axes = pyplot.subplots(figsize=(9, 4), dpi=110)
    axes.plot(indices, scores, ".", label="trial")
    axes.step(indices, np.minimum.accumulate(scores), where="post", label="best so far")
    axes.set(xlabel="trial", ylabel="mean time of a start [s]")
    axes.legend()
    plots.write(figure, path)


def by_option(rows, names, path):
    """Plot the score over each option."""
    height = -(-len(names) // COLUMNS)
    width = min(len(names), COLUMNS)
    figure, panels = pyplot.subplots(
        height, width, squeeze=False, sharey=True, figsize=(3.5 * width, 3.2 * height), dpi=110
    )
    scores = [row["score"] for row in rows]
    for name, axes in zip(names, panels.flat):
        values = [row["options"][name] for row in rows]
        numeric = all(isinstance(value, (int, float)) for value in values)
        axes.plot(values if numeric else [format_value(value) for value in values], scores, ".")
        axes.set(xlabel=name)
        axes.tick_params(axis="x", labelrotation=0 if numeric else 30)
    for axes in panels[:, 0]:
        axes.set(ylabel="mean time of a start [s]")
    for axes in list(panels.flat)[len(names) :]:
        axes.set_visible(False)
    plots.write(figure, path)


def format_value(value):
    """Text of a value in a table."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        return "+".join(map(str, value))
    return os.path.basename(value) if isinstance(value, str) else str(value)
