"""The test process as a node, once the file's launch has set its parameters."""

import pytest
import rospy
import shared_worlds
from selection import world_of

from paddock_common import nodes


@pytest.fixture(scope="module", autouse=True)
def node(request):
    """Registers a node for a file with a LAUNCH: NODE, by default named as the file.

    If other files share the launch, its world is reset. The node leaves the graph with the last
    test of the file.
    """
    if getattr(request.module, "LAUNCH", None) is None:
        yield
        return
    name = getattr(request.module, "NODE", request.path.stem)
    nodes.init_node(name, disable_signals=True)
    if world := world_of(request.path):
        shared_worlds.RESETS[world]()
    yield
    rospy.signal_shutdown("the tests of this file are over")
