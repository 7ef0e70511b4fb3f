"""A ./run bench that is stopped or killed leaves nothing of the worlds that it has started."""

import os
import pathlib
import signal
import subprocess
import time
import uuid

import pytest

from commands import procfs

ROOT = pathlib.Path(__file__).resolve().parents[2]
START_LIMIT, END_LIMIT = 120.0, 60.0  # wall time [s]
VARIABLE = "PADDOCK_BENCH_ENDS"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_its_world_ends_with_it(number):
    mark = uuid.uuid4().hex

    def programs():
        return {procfs.program(procfs.arguments(pid)) for pid in procfs.marked(VARIABLE, mark)}

    with subprocess.Popen(
        [str(ROOT / "run"), "bench", "--quick", "--only", "driving"],
        env={**os.environ, VARIABLE: mark},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as bench:
        end = time.monotonic() + START_LIMIT
        while "gazebo" not in programs():
            assert bench.poll() is None and time.monotonic() < end
            time.sleep(0.1)
        bench.send_signal(number)
        status = bench.wait(END_LIMIT)
    assert status == (-number if number == signal.SIGKILL else 128 + number)
    end = time.monotonic() + END_LIMIT
    while left := programs():
        assert time.monotonic() < end, left
        time.sleep(0.1)
