"""The page of results: Markdown, plots, JSON."""

import dataclasses
import json
import statistics

import matplotlib

from soaking.monitor import neighbors, rates, real_time_factor, real_time_factors

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of the backend)

BLUE, RED = "#2f6f8f", "#b3541e"
ROLES = ("bridge", "relay", "render_worker", "control", "teleop", "drive")
NAMES = {"teleop": "window", "bridge": "simulator"}
PLOTTED = ("/clock", "/racecar/odom", "/scan", "/camera/image", "/cybertruck/joint_states")


def failures(timeline):
    """All failures, one message each."""
    found = [
        f"{event.begin:.0f} s: {event.name}: {event.failure}"
        for event in timeline.events
        if event.failure
    ]
    return found + timeline.failures


def write(timeline, folder, minutes):
    """Writes soak.json, soak.md and the plots.

    Returns:
        Failures.
    """
    bad = failures(timeline)
    figures = summary(timeline, minutes)
    result = {
        "ok": not bad,
        "failures": bad,
        "figures": figures,
        "events": [dataclasses.asdict(event) for event in timeline.events],
        "samples": [[dataclasses.asdict(s) for s in part] for part in timeline.samples],
    }
    (folder / "soak.json").write_text(json.dumps(result) + "\n")
    plots = draw(timeline, folder)
    (folder / "soak.md").write_text(text(timeline, figures, bad, plots))
    return bad


def summary(timeline, minutes):
    """The figures of a soak."""
    counts = {}
    for event in timeline.events:
        counts[event.name] = counts.get(event.name, 0) + 1
    samples = [sample for part in timeline.samples for sample in part]
    most = {}
    for sample in samples:
        for role, (_, memory, threads, files) in sample.processes.items():
            old = most.get(role, (0, 0, 0))
            most[role] = tuple(map(max, old, (memory, threads, files)))
    pairs = [pair for part in timeline.samples for pair in neighbors(part)]
    calm = [
        real_time_factor(before, after) for before, after in pairs if before.calm and after.calm
    ]
    return {
        "seed": timeline.seed,
        "minutes": minutes,
        "seconds": timeline.now(),
        "sessions": len(timeline.samples),
        "simulated": sum(after.simulated - before.simulated for before, after in pairs),
        "faults": counts,
        "most": most,
        "calm_pace_median": statistics.median(calm) if calm else None,
    }


def text(timeline, figures, bad, plots):
    """The page in Markdown."""
    lines = [
        f"# Soak, seed {figures['seed']}: {'FAILED' if bad else 'ok'}",
        "",
        f"{figures['seconds'] / 60:.1f} minutes, {figures['sessions']} sessions, "
        f"{sum(figures['faults'].values())} faults and checks, {figures['simulated']:.0f} s "
        f"simulated; real-time factor between faults {figures['calm_pace_median'] or 0:.2f} "
        "(median).",
        "",
    ]
    if bad:
        lines += ["## Failures", ""] + [f"    {line}" for item in bad for line in item.split("\n")]
        lines.append("")
    lines += ["## What was done", "", "| fault or check | times |", "| --- | --- |"]
    lines += [f"| {name} | {count} |" for name, count in sorted(figures["faults"].items())]
    lines += ["", "## The most that was seen", "", "| process | memory | threads | files |"]
    lines.append("| --- | --- | --- | --- |")
    for role in ROLES:
        if role in figures["most"]:
            memory, threads, files = figures["most"][role]
            lines.append(
                f"| {NAMES.get(role, role)} | {memory / 1e6:.0f} MB | {threads} | {files} |"
            )
    lines += ["", *(f"![{name}]({name})" for name in plots), "", "## One after the other", ""]
    for event in timeline.events:
        words = f"FAILED: {event.failure}" if event.failure else event.text
        lines.append(f"- {event.begin:.0f} s, {event.name}: {words}".replace("\n", " "))
    return "\n".join(lines) + "\n"


def draw(timeline, folder):
    """Draws all plots; returns their names."""
    columns = {"memory": (1, 1e-6, "memory [MB]"), "threads": (2, 1, "threads")}
    columns["files"] = (3, 1, "open files")
    names = []
    for name, (column, scale, label) in columns.items():
        figure, axes = _axes(timeline, label)
        for number, role in enumerate(ROLES):
            for part in timeline.samples:
                points = [
                    (s.wall, s.processes[role][column] * scale) for s in part if role in s.processes
                ]
                axes.plot(
                    *zip(*points) if points else ((), ()),
                    color=f"C{number}",
                    label=NAMES.get(role, role) if part is timeline.samples[0] else None,
                )
        _legend(axes, 4)
        names.append(_save(figure, folder, name))
    figure, axes = _axes(timeline, "simulated s per wall s")
    for part in timeline.samples:
        axes.plot(*zip(*real_time_factors(part)) if len(part) > 1 else ((), ()), color=BLUE)
    axes.set_ylim(0, 2.5)
    names.append(_save(figure, folder, "pace"))
    figure, axes = _axes(timeline, "messages per wall s")
    for number, topic in enumerate(PLOTTED):
        for part in timeline.samples:
            axes.plot(
                *zip(*rates(part, topic)) if len(part) > 1 else ((), ()),
                color=f"C{number}",
                label=topic if part is timeline.samples[0] else None,
            )
    axes.set_yscale("symlog")
    _legend(axes, 3)
    names.append(_save(figure, folder, "rates"))
    return names


def _axes(timeline, label):
    figure, axes = pyplot.subplots(figsize=(9, 3.0))
    for event in timeline.events:
        axes.axvspan(event.begin, event.end, color=RED if event.failure else "#dddddd", lw=0)
    axes.set_xlabel("wall time [s]")
    axes.set_ylabel(label)
    return figure, axes


def _legend(axes, columns):
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=7, ncol=columns)


def _save(figure, folder, name):
    figure.tight_layout()
    figure.savefig(folder / f"{name}.png", dpi=110)
    pyplot.close(figure)
    return f"{name}.png"
