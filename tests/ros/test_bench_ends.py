"""A ./run bench that is stopped leaves nothing of the worlds that it has started."""

import signal

from bench_rig import check_end


def test_its_world_ends_with_it():
    check_end(signal.SIGTERM)
