"""A ./run bench that is stopped or killed leaves nothing of the worlds that it has started."""

import signal

import pytest
from bench_rig import check_end


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_its_world_ends_with_it(number):
    check_end(number)
