"""From raw receipts to figures."""

import math
from itertools import pairwise


class BenchError(ValueError):
    """A run that gave no figures."""


def percentile(values, part):
    """The value below which a part of them lies (nearest rank)."""
    ordered = sorted(values)
    if not ordered:
        raise BenchError("no samples")
    return ordered[min(len(ordered) - 1, max(0, math.ceil(part * len(ordered)) - 1))]


def median(values):
    """The middle value."""
    return percentile(values, 0.5)


def rate_of(pairs):
    """Simulated seconds per wall second of [(receipt, stamp)]."""
    return (pairs[-1][1] - pairs[0][1]) / (pairs[-1][0] - pairs[0][0])


def gap_figures(pictures, seconds):
    """Rate and gaps [ms] of received pictures [(receipt, stamp)]."""
    if len(pictures) < 3:
        raise BenchError(f"{len(pictures)} pictures in {seconds:g} s")
    gaps = [(b[0] - a[0]) * 1e3 for a, b in pairwise(pictures)]
    return {
        "window_s": seconds,
        "received": len(pictures),
        "rate_hz": (len(pictures) - 1) / (pictures[-1][0] - pictures[0][0]),
        "gap_ms_p50": percentile(gaps, 0.5),
        "gap_ms_p99": percentile(gaps, 0.99),
        "gap_ms_max": max(gaps),
    }


def lateness_figures(ticks):
    """How late /clock arrives against the earliest offset between wall and stamp."""
    if len(ticks) < 3:
        raise BenchError(f"{len(ticks)} messages on /clock")
    offsets = [receipt - stamp for receipt, stamp in ticks]
    late = [(offset - min(offsets)) * 1e3 for offset in offsets]
    return {
        "kind": "proxy: /clock as received by a subscriber in another process, "
        "transport and scheduling of both sides included",
        "samples": len(late),
        "late_ms_p50": percentile(late, 0.5),
        "late_ms_p99": percentile(late, 0.99),
        "late_ms_p999": percentile(late, 0.999),
        "late_ms_max": max(late),
    }
