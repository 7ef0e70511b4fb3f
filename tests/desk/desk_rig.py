"""A desk as ./run desk starts it, and headless Chromium in front of it."""

import base64
import socket
import sys

import cv2
import numpy as np
from paddock_common.process import free_port
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from web_rig import LIMIT, ROOT, Run

SHOTS = ROOT / "test-results" / "desk"  # pictures for people
OPTIONS = (
    "--headless=new",
    "--no-sandbox",  # which root cannot have
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--window-size=1600,1000",
)
CANVAS = "document.querySelector('#noVNC_container canvas')"

sys.path.append(str(ROOT / "tests" / "ros"))  # for vnc_client


class Desk(Run):
    """./run desk.

    Attributes:
        url: The address that it has printed.
    """

    def __init__(self, *arguments, master, **environ):
        """Starts it and reads the address."""
        super().__init__("desk", "--port", str(free_port()), *arguments, master=master, **environ)
        self.url = self.read(r"http://\S+/")[0].replace(socket.gethostname(), "127.0.0.1")


class Browser:
    """A headless Chromium."""

    def __init__(self):
        options = webdriver.ChromeOptions()
        for option in OPTIONS:
            options.add_argument(option)
        self.driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
        self.driver.set_script_timeout(LIMIT)

    def picture(self):
        """Gives the screen that the page shows, (H, W, 3) uint8 RGB; None while there is none."""
        url = self.driver.execute_script(
            f"const canvas = {CANVAS}; return canvas && canvas.width && canvas.toDataURL()"
        )
        if not url:
            return None
        data = np.frombuffer(base64.b64decode(url.split(",")[1]), np.uint8)
        return cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)

    def click(self, x, y):
        """Clicks a place of the screen [px], wherever the page shows it."""
        left, top, scale = self.driver.execute_script(
            f"const box = {CANVAS}.getBoundingClientRect();"
            f"return [box.left, box.top, box.width / {CANVAS}.width]"
        )
        event = {"x": left + scale * x, "y": top + scale * y}
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            button = {} if kind == "mouseMoved" else {"button": "left", "clickCount": 1}
            self.driver.execute_cdp_cmd(
                "Input.dispatchMouseEvent", {"type": kind, **event, **button}
            )

    def shoot(self, name):
        """Keeps a picture of the page for people."""
        SHOTS.mkdir(parents=True, exist_ok=True)
        self.driver.save_screenshot(str(SHOTS / f"{name}.png"))

    def close(self):
        """Ends it."""
        self.driver.quit()
