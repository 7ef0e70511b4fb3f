"""One PNG per curve."""

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  (after the choice of the backend)


def _save(figure, path):
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


def _bars(result, path):
    names = list(result)
    figure, axes = pyplot.subplots(figsize=(7, 3.2))
    axes.barh(names, [result[name]["ratio"] for name in names], color="#2f6f8f")
    axes.axvline(1.0, color="#777777", linewidth=1)
    axes.set_xlim(0, 1.1)
    axes.invert_yaxis()
    for index, name in enumerate(names):
        axes.text(
            min(result[name]["ratio"], 0.98) - 0.02,
            index,
            f"{result[name]['ratio']:.2f}",
            va="center",
            ha="right",
            color="white",
        )
    return figure, axes, path


def draw_all(result, folder):
    """Write the curves of what was measured into a folder."""
    if "efficiency" in result:
        figure, axes, path = _bars(result["efficiency"], folder / "efficiency.png")
        axes.set_xlabel("bridge's simulated s per s / PyBullet's stepping alone")
        _save(figure, path)
    if "camera" in result:
        figure, axes, path = _bars(result["camera"], folder / "camera.png")
        axes.set_xlabel("received pictures per s / bare getCameraImage per s")
        _save(figure, path)
    if "scale" in result:
        rows = result["scale"]["rows"]
        figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.4))
        cars = [row["cars"] for row in rows]
        left.plot(cars, [row["wall_ms_per_sim_s_and_car"] for row in rows], "o-", color="#2f6f8f")
        left.set_ylabel("wall ms per simulated s and car")
        right.plot(cars, [row["pace"] for row in rows], "o-", color="#b3541e")
        right.axhline(1.0, color="#777777", linewidth=1)
        right.set_yscale("log")
        right.set_ylabel("simulated s per s")
        for axes in (left, right):
            axes.set_xscale("log", base=2)
            axes.set_xticks(cars, [str(count) for count in cars])
            axes.set_xlabel("cars with a lidar")
        left.set_ylim(bottom=0)
        _save(figure, folder / "scale.png")
    if "growth" in result:
        figure, axes = pyplot.subplots(figsize=(6, 3.2))
        for phase, row in result["growth"].items():
            axes.plot(row["at_sim_s"], row["memory_mb"], "o-", label=phase)
        axes.set_xlabel("simulated s")
        axes.set_ylabel("memory of the bridge (PSS) [MB]")
        axes.set_ylim(bottom=0)
        axes.legend()
        _save(figure, folder / "growth.png")
