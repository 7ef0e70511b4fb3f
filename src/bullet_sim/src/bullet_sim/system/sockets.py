"""Sockets to processes of our own."""

import socket


def blocking_pair():
    """A connected pair of Unix stream sockets that block, whatever Python's default time-out is:
    rospy sets one, which would make them non-blocking underneath."""
    pair = socket.socketpair()
    for end in pair:
        end.setblocking(True)
    return pair
