"""A world with its page, and browsers."""

import os

import pytest
from paddock_common.process import free_port
from web_rig import Browser, Web


@pytest.fixture(scope="session")
def master():
    """Port of the ROS master of this test and of its worlds, before rospy asks for it."""
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    return port


@pytest.fixture(scope="module")
def web(master):
    """The track with the car and its page."""
    camera = ("camera_width:=320", "camera_height:=240", "camera_rate:=10")
    running = Web("web", "--port", str(free_port()), *camera, master=master)
    yield running
    running.end()


@pytest.fixture
def browsers():
    """Makes browsers of a size [px], and ends them."""
    made = []

    def make(width=1920, height=1080, touch=False):
        made.append(Browser(width, height, touch))
        return made[-1]

    yield make
    for browser in made:
        browser.close()
