"""Alternation of the bench, with workloads whose ratio is known by counting, on a clock of ours."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from figures import (
    WITHIN,  # noqa: E402
    BenchError,  # noqa: E402
)
from pairs import PAIRS, QUICK_PAIRS, Round, alternate, pairs_of, rate_of_work  # noqa: E402
from usage import Machine as Processors  # noqa: E402
from usage import Reading  # noqa: E402


class Machine:
    """A processor on which time passes only by work, and whose speed may change.

    Attributes:
        now: [s].
        slowness: by what factor work takes longer.
    """

    def __init__(self):
        self.now, self.slowness = 0.0, 1.0

    def workload(self, cost):
        """Give a round: pieces of work of so many seconds each, for 10 s."""

        def piece():
            self.now += cost * self.slowness
            return 1

        return lambda: rate_of_work(piece, 10.0, now=lambda: self.now)


def test_the_ratio_is_that_of_the_costs():
    machine = Machine()
    measured = alternate(machine.workload(0.25), {"twice": machine.workload(0.5)}, 9)["twice"]
    assert measured.ratios == [0.5] * 9
    figures = measured.figures()
    assert (figures["ratio"]["median"], figures["pairs"]) == (0.5, 9)
    assert (figures["reference"]["median"], figures["variant"]["median"]) == (4.0, 2.0)
    assert figures["against_reference"] == "lower"


def test_a_machine_that_slows_down_for_both_leaves_the_ratio():
    machine = Machine()
    variant = machine.workload(0.5)

    def slower_every_pair():
        rate = variant()
        machine.slowness *= 2.0
        return rate

    measured = alternate(machine.workload(0.25), {"twice": slower_every_pair}, 5)["twice"]
    assert measured.ratios == [0.5] * 5
    assert measured.reference[0].value == 16 * measured.reference[4].value


def test_equal_workloads_on_a_restless_machine_do_not_differ():
    """Others take half of the processor in every third round, so in a round of either side."""
    machine, rounds = Machine(), []

    def restless(one_round):
        def measure():
            rounds.append(one_round)
            machine.slowness = 2.0 if len(rounds) % 3 == 0 else 1.0
            return one_round()

        return measure

    same = machine.workload(0.25)
    measured = alternate(restless(same), {"same": restless(same)}, 9)["same"]
    assert sorted(set(measured.ratios)) == [0.5, 1.0, 2.0]
    assert measured.figures()["against_reference"] == WITHIN


def test_each_variant_follows_a_reference_of_its_own():
    order = []

    def one_round(name, value):
        def measure():
            order.append(name)
            return Round(value, {"name": name, "number": len(order)})

        return measure

    measured = alternate(
        one_round("A", 1.0), {"b": one_round("B", 2.0), "c": one_round("C", 3.0)}, 2
    )
    assert "".join(order) == "ABACABAC"
    assert measured["b"].ratios == [2.0, 2.0] and measured["c"].ratios == [3.0, 3.0]
    assert [item.details["number"] for item in measured["c"].reference] == [3, 7]
    assert [item.details["number"] for item in measured["c"].variant] == [4, 8]


def test_a_watch_tells_what_each_turn_spent():
    """The machine is busy 0.75 of the variant's time and 0.5 of the reference's, all by others."""
    clock = {"now": 0.0, "busy": 0.0}

    class OwnMonitor:
        def read(self):
            return Reading(clock["now"], Processors(clock["busy"], 0.0), {}, {})

    def one_round(share, value):
        def measure():
            clock["now"] += 2.0
            clock["busy"] += 2.0 * share
            return Round(value, {"kept": True})

        return measure

    measured = alternate(one_round(0.5, 2.0), {"v": one_round(0.75, 1.0)}, 3, OwnMonitor())["v"]
    figures = measured.figures()
    assert (figures["spent"]["others"], figures["reference_spent"]["others"]) == (0.75, 0.5)
    assert figures["ratio"]["median"] == 0.5
    assert all(one_round.details["kept"] for one_round in measured.variant)
    assert (
        "spent" not in alternate(one_round(0.5, 2.0), {"v": one_round(0.5, 2.0)}, 1)["v"].figures()
    )


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_a_turn_without_a_rate_is_no_figure(value):
    with pytest.raises(BenchError, match="'stalled' measured"):
        alternate(lambda: 1.0, {"stalled": lambda: value}, 3)
    with pytest.raises(BenchError, match="the reference measured"):
        alternate(lambda: value, {"good": lambda: 1.0}, 3)


def test_there_is_at_least_one_pair():
    with pytest.raises(ValueError, match="pairs is 0"):
        alternate(lambda: 1.0, {}, 0)


def test_figures_to_quote_have_nine_pairs():
    assert (pairs_of(False), pairs_of(True)) == (PAIRS, QUICK_PAIRS)
    assert PAIRS >= 9 and QUICK_PAIRS >= 5


def test_work_goes_on_until_the_time_has_passed():
    machine = Machine()
    assert machine.workload(4.0)() == 0.25
    assert machine.now == 12.0  # three pieces: the first that ends at 10 s or later is the last
