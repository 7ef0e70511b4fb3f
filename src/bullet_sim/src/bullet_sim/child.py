"""Sockets to child processes."""

import socket


def blocking_pair():
    """A connected pair of blocking Unix stream sockets.

    With the default time-out that rospy sets they would be non-blocking file descriptors.
    """
    pair = socket.socketpair()
    for end in pair:
        end.setblocking(True)
    return pair
