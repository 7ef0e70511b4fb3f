"""Wild messages, pages and browsers that stop reading; tests/long/ has more of each."""

import safety_rig
from shared_worlds import SEEING_CAR as LAUNCH  # noqa: F401


class Safety(safety_rig.Safety):
    """One node for all tests."""

    WILD, PAGES, CYCLES, STALLED = 1000, 10, 1, 2

    def test_mutated_messages_end_and_stall_nothing(self):
        self.check_mutated_messages()

    def test_pages_come_and_go_without_leaving_memory(self):
        self.check_pages_come_and_go()

    def test_browsers_that_stop_reading_slow_nothing(self):
        self.check_browsers_that_stop_reading()
