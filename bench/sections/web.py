"""The page in a browser: pace with one page over none, processor time of its node."""

import time

from figures import BenchError
from launching import Launch
from pairs import Round, alternate, pairs_of
from report import Row, ratio_row
from usage import cpu_seconds

SECONDS = 4.0  # of a round


def measure(quick, log):
    """Running free: pace with and without a page; at real time: the node's processor time."""
    seconds = SECONDS / 2.0 if quick else SECONDS
    with Launch(log, ["real_time_factor:=0", "lidar:=false", "headless:=true"]) as launch:
        page, _ = _observer(launch)

        def one_round(open_it):
            if open_it:
                page.ask("open")
            before, begin = page.ask("time")["sim"], time.monotonic()
            time.sleep(seconds)
            pace = (page.ask("time")["sim"] - before) / (time.monotonic() - begin)
            return Round(pace, {"views": page.ask("close")["views"] if open_it else 0})

        measured = alternate(
            lambda: one_round(False), {"page": lambda: one_round(True)}, pairs_of(quick)
        )["page"]
    if not all(each.details["views"] > seconds for each in measured.variant):
        views = [each.details["views"] for each in measured.variant]
        raise BenchError(f"a page got {views} views in rounds of {seconds:g} s")
    return {"free": measured.figures(), "real_time": _real_time(seconds, log)}


def _observer(launch):
    """The observer of the page, and the pid of the page's node."""
    page = launch.observer("page.look")
    return page, page.answer()["pid"]


def _real_time(seconds, log):
    """Processor time of the node [cores] without a page, and with one; views a second."""
    with Launch(log, ["real_time_factor:=1", "lidar:=false", "headless:=true"]) as launch:
        page, pid = _observer(launch)
        found = {}
        for name in ("nobody", "page"):
            if name == "page":
                page.ask("open")
            views = page.ask("count")["views"]
            before, begin = cpu_seconds(pid), time.monotonic()
            time.sleep(2.0 * seconds)
            past = time.monotonic() - begin
            found[name] = {
                "cores": (cpu_seconds(pid) - before) / past,
                "views_hz": (page.ask("count")["views"] - views) / past,
            }
        return found


def rows(figures):
    """The ratio, and the node's processor time."""
    yield ratio_row("pace with a page", figures["free"], "that without", "x real time")
    for name, text in (("nobody", "page's node, nobody looks"), ("page", "page's node, one page")):
        row = figures["real_time"][name]
        yield Row(
            text,
            f"{100.0 * row['cores']:.1f} % of a core, {row['views_hz']:.1f} views a second",
            row["cores"],
            "cores",
            ".3f",
        )
