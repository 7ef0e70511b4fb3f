"""A master, the desk, browsers."""

import os

import pytest
from desk_rig import Browser, Desk
from paddock_common.process import free_port


@pytest.fixture(scope="session")
def master():
    """Port of the ROS master of this test and of its desks, before rospy asks for it."""
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    return port


@pytest.fixture(scope="session")
def desk(master):
    """The window, with a small camera."""
    running = Desk("camera_width:=160", "camera_height:=120", "camera_rate:=5", master=master)
    yield running
    running.end()


@pytest.fixture
def browsers():
    """Makes browsers, and ends them."""
    made = []

    def make():
        made.append(Browser())
        return made[-1]

    yield make
    for browser in made:
        browser.close()
