"""The referee's CSV file on a disk that is full."""

import csv

from track_model.referee.node import Log
from track_model.referee.referee import Status


def status():
    values = dict.fromkeys(Status.__dataclass_fields__, 0.0)
    return Status(**{**values, "wheels_off": (False,) * 4})


def test_a_full_disk_is_reported_once_and_ends_the_log():
    reported = []
    log = Log("/dev/full", reported.append)
    for _ in range(2000):
        log.add((0.0, 0.0, 0.0), status(), [])
    log.close()
    assert reported == ["/dev/full cannot be written: No space left on device; it stops here"]


def test_what_does_not_fill_the_buffer_is_missed_at_the_end():
    reported = []
    log = Log("/dev/full", reported.append)
    log.add((0.0, 0.0, 0.0), status(), [])
    log.close()
    assert len(reported) == 1


def test_rows_are_written(tmp_path):
    log = Log(str(tmp_path / "new" / "log.csv"))
    log.add((1.0, 2.0, 0.5), status(), ["lap"])
    log.close()
    with open(tmp_path / "new" / "log.csv", newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["x"], row["y"], row["events"]) == ("1.000000", "2.000000", "lap")
