"""One PNG per curve."""

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of the backend)

BLUE, RED, GREY = "#2f6f8f", "#b3541e", "#777777"


def save(figure, path):
    """Write a figure and forget it."""
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def bars(spreads, path, label):
    """A bar for each median, with its range, and a line at 1.

    Args:
        spreads: dict of name -> Spread.figures().
        path: of the PNG.
        label: of the axis.
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
        path: of the PNG.
        x_label, y_label: of the axes.
    """
    figure, axes = pyplot.subplots(figsize=(6, 3.2))
    for name, (x, y) in curves.items():
        axes.plot(x, y, "o-", label=name)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    axes.set_ylim(bottom=0)
    axes.legend()
    save(figure, path)
