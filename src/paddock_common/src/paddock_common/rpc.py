"""Calls of a ROS master by XML-RPC, each with a time-out."""

import http.client
import xml.parsers.expat
import xmlrpc.client

# What a call raises when there is no answer, or none that is XML-RPC.
ERRORS = (OSError, http.client.HTTPException, xmlrpc.client.Error, xml.parsers.expat.ExpatError)


def proxy(uri, timeout):
    """Returns a proxy of an XML-RPC server, to be used in a with statement.

    Args:
        uri: The server's address, http://host:port.
        timeout: Longest wait for an answer [s].
    """
    return xmlrpc.client.ServerProxy(uri, transport=_Transport(timeout))


class _Transport(xmlrpc.client.Transport):
    """A transport with a time-out."""

    def __init__(self, timeout):
        super().__init__()
        self._timeout = timeout

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = self._timeout
        return connection
