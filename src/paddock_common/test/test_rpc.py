"""Calls with a time-out, and what is no answer."""

import socket

import pytest
from paddock_common.testing import web_page

from paddock_common import rpc


def test_a_web_server_is_no_master():
    with web_page() as address, pytest.raises(rpc.ERRORS), rpc.proxy(address, 10.0) as master:
        master.getPid("/test")


def test_silence_and_nobody():
    with socket.create_server(("127.0.0.1", 0)) as silent:  # accepts and never answers
        address = f"http://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(TimeoutError), rpc.proxy(address, 0.1) as master:
            master.getPid("/test")
    with pytest.raises(ConnectionRefusedError), rpc.proxy(address, 10.0) as master:
        master.getPid("/test")
