"""Priorities, timeouts and locks with a clock of the test's own; the parameters' lists."""

import pytest
from velocity_mux.mux import Entry, Mux, read

NAVIGATION, KEYBOARD, JOYSTICK = 0, 1, 2
TOPICS = [
    Entry("navigation", "nav_vel", 0.5, 10),
    Entry("keyboard", "key_vel", 0.5, 90),
    Entry("joystick", "joy_vel", 0.25, 100),
]
PAUSE = Entry("pause", "pause_navigation", 0.0, 50)
WATCHED = Entry("watched", "alive", 1.0, 100)


@pytest.fixture(name="mux")
def _mux():
    return Mux(TOPICS, [PAUSE])


def test_the_higher_priority_passes_until_it_is_silent(mux):
    assert mux.command(NAVIGATION, 10.0)
    assert mux.command(JOYSTICK, 10.125)
    assert not mux.command(NAVIGATION, 10.25)
    assert not mux.command(KEYBOARD, 10.375)  # exactly at the joystick's timeout: it still counts
    assert mux.command(KEYBOARD, 10.376)
    assert not mux.command(NAVIGATION, 10.5)
    assert mux.command(NAVIGATION, 11.0)


def test_nobody_drives_before_the_first_command(mux):
    assert mux.active_source(0.1) is None  # simulated time starts at 0, too


def test_of_equal_priorities_the_first_passes():
    mux = Mux([Entry("a", "a", 0.5, 7), Entry("b", "b", 0.5, 7)], [])
    assert mux.command(1, 1.0)
    assert mux.command(0, 1.1)
    assert not mux.command(1, 1.2)
    assert mux.command(1, 1.7)


def test_priority_0_never_passes():
    assert not Mux([Entry("a", "a", 0.5, 0)], []).command(0, 1.0)


def test_without_a_timeout_a_source_holds_the_lower_ones_for_good():
    mux = Mux([Entry("low", "a", 0.5, 1), Entry("high", "b", 0.0, 2)], [])
    assert not mux.command(0, 1.0)
    assert mux.command(1, 2.0)


def test_a_lock_stops_what_is_below_it(mux):
    mux.lock(0, True, 1.0)
    assert not mux.command(NAVIGATION, 2.0)
    assert mux.command(KEYBOARD, 2.0)
    mux.lock(0, False, 3.0)
    assert mux.command(NAVIGATION, 3.0)


def test_a_lock_lets_its_own_priority_pass():
    mux = Mux([Entry("a", "a", 0.5, 100)], [Entry("l", "l", 0.0, 100)])
    mux.lock(0, True, 1.0)
    assert mux.command(0, 1.0)


def test_the_highest_of_the_locks_counts():
    mux = Mux(TOPICS, [PAUSE, Entry("stop", "stop", 0.0, 255)])
    mux.lock(1, True, 1.0)
    mux.lock(0, True, 1.0)
    assert mux.lock_priority(1.0) == 255
    mux.lock(1, False, 2.0)
    assert mux.lock_priority(2.0) == 50


def test_a_watched_lock_is_locked_when_it_falls_silent():
    mux = Mux(TOPICS, [WATCHED])
    assert not mux.command(KEYBOARD, 1.0)  # it was never heard
    mux.lock(0, False, 2.0)
    assert mux.command(KEYBOARD, 3.0)
    assert not mux.command(KEYBOARD, 3.1)


def test_a_clock_set_back_counts_as_silence():
    mux = Mux(TOPICS, [])
    assert mux.command(JOYSTICK, 100.0)
    assert mux.command(NAVIGATION, 1.0)


def test_masked_is_silent_or_locked(mux):
    mux.command(NAVIGATION, 1.0)
    assert [mux.masked(n, 1.0) for n in range(3)] == [False, True, True]
    mux.lock(0, True, 1.0)
    assert mux.masked(NAVIGATION, 1.0)


def test_entries_as_upstream_writes_them():
    entries, problems = read(
        "topics",
        [
            {"name": "a", "topic": "a_vel", "timeout": 0.5, "priority": 10},
            {"name": 2, "topic": " b_vel ", "timeout": "1", "priority": "7"},
        ],
    )
    assert entries == [Entry("a", "a_vel", 0.5, 10), Entry("2", "b_vel", 1.0, 7)]
    assert problems == []


@pytest.mark.parametrize(
    "item, words",
    [
        ({"name": "a", "topic": "a", "timeout": 0.5}, "it has no priority"),
        ({"name": "a", "topic": "", "timeout": 0.5, "priority": 1}, "topic is ''"),
        ({"name": "a", "topic": "a", "timeout": -1, "priority": 1}, "timeout is -1"),
        ({"name": "a", "topic": "a", "timeout": "soon", "priority": 1}, "timeout is 'soon'"),
        ({"name": "a", "topic": "a", "timeout": 1, "priority": float("nan")}, "priority is nan"),
        ({"name": "a", "topic": "a", "timeout": 1, "priority": True}, "priority is True"),
        ({"name": "a", "topic": "a", "timeout": 10**400, "priority": 1}, "timeout is 1000"),
        ("a_vel", "it is 'a_vel'"),
    ],
)
def test_a_wrong_entry_costs_itself_alone(item, words):
    good = {"name": "g", "topic": "g", "timeout": 0, "priority": 3}
    entries, problems = read("topics", [item, good])
    assert entries == [Entry("g", "g", 0.0, 3)]
    assert len(problems) == 1 and "topics[0]" in problems[0] and words in problems[0]


@pytest.mark.parametrize("given, used", [(300, 255), (-4, 0)])
def test_priorities_are_kept_within_their_range(given, used):
    entries, problems = read(
        "locks", [{"name": "a", "topic": "a", "timeout": 0, "priority": given}]
    )
    assert entries[0].priority == used and str(given) in problems[0]


def test_what_is_no_list_is_named():
    entries, problems = read("topics", {"name": "a"})
    assert entries == [] and "must be a list" in problems[0]
