"""The page's node beside a real world: wild messages, fifty pages, browsers that stop reading."""

import safety_rig
from safety_rig import LAUNCH  # noqa: F401


class Safety(safety_rig.Safety):
    """One node for all tests."""

    WILD, PAGES, CYCLES, STALLED = 10000, 50, 5, 10

    def test_ten_thousand_mutated_messages_end_and_stall_nothing(self):
        self.check_mutated_messages()

    def test_fifty_pages_come_and_go_without_leaving_memory(self):
        self.check_pages_come_and_go()

    def test_ten_browsers_that_stop_reading_slow_nothing(self):
        self.check_browsers_that_stop_reading()
