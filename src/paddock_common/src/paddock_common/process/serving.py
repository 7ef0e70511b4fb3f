"""The thread that answers a node's XML-RPC calls ends with the node.

rospy closes that thread's socket while it polls it. From then on poll() returns at once, and the
thread takes a whole processor until the process is gone: 0.2 to 0.5 s where others start or end
beside it, as they do when a launch file starts or ends.
"""

import _thread
import functools

from rosgraph.xmlrpc import XmlRpcNode

_upstream = XmlRpcNode.shutdown


@functools.wraps(_upstream)
def _shutdown(self, reason):
    server = self.server
    if server:
        _thread.start_new_thread(server.shutdown, ())  # it waits for the thread's end
    _upstream(self, reason)


def end_with_node():
    """Has the thread end when the node does, of all nodes of this process."""
    XmlRpcNode.shutdown = _shutdown
