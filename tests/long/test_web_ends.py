"""The page's node ends well while it makes a scene of a real world."""

import signal
import time
import unittest

from paddock_common.process import free_port
from page_client import PageClient, WebNode
from shared_worlds import SEEING_CAR as LAUNCH  # noqa: F401
from sim_client import wait_until


class WebEnds(unittest.TestCase):
    """Nodes and pages of their own."""

    def test_a_node_that_ends_while_it_makes_a_scene_ends_well(self):
        for number in range(4):
            web = WebNode(f"_port:={free_port()}", f"__name:=short_web_{number}")
            self.addCleanup(web.end)
            page = PageClient(web.url)
            self.addCleanup(page.close)
            wait_until(lambda page=page: page.status, "the first message")
            time.sleep(0.1 * number)
            self.assertEqual(web.end(signal.SIGTERM), 0)
