"""Publishers are withdrawn when what they were made for fails."""

import threading

import pytest
from bullet_bridge.transport import publishing
from bullet_bridge.transport.publishing import all_or_none, publisher


class Wire:
    """Stands in for rospy.Publisher."""

    def __init__(self, topic, _kind, **_):
        self.topic, self.closed = topic, 0

    def unregister(self):
        """Withdraw."""
        self.closed += 1


@pytest.fixture(autouse=True)
def _wires(monkeypatch):
    monkeypatch.setattr(publishing.rospy, "Publisher", Wire)
    monkeypatch.setattr(publishing, "send_directly", lambda *_: None)


def test_all_stay_when_nothing_fails():
    with all_or_none():
        wire = publisher("/a", str)
    with pytest.raises(ZeroDivisionError), all_or_none():
        raise ZeroDivisionError
    assert wire.closed == 0


def test_a_failure_withdraws_those_made_within():
    before, wires = publisher("/before", str), []
    with pytest.raises(OverflowError), all_or_none():
        wires.append(publisher("/a", str))
        with all_or_none():
            wires.append(publisher("/b", str))
        raise OverflowError("too large")
    assert [wire.closed for wire in wires] == [1, 1]
    assert before.closed == 0 and publisher("/after", str).closed == 0


def test_other_threads_are_left_alone():
    wires = []
    with pytest.raises(ValueError), all_or_none():
        other = threading.Thread(target=lambda: wires.append(publisher("/a", str)))
        other.start()
        other.join()
        raise ValueError
    assert wires[0].closed == 0
