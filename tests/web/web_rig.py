"""A world as ./run web starts it, and headless Chromium in front of its page."""

import base64
import contextlib
import io
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import rospy
from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

ROOT = Path(__file__).resolve().parents[2]
LIMIT = 180.0  # longest wait for anything [s]
SHOTS = ROOT / "test-results" / "web"  # pictures for people
OPTIONS = (
    "--headless=new",
    "--no-sandbox",  # which root cannot have
    "--use-angle=swiftshader",  # WebGL without a GPU
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-dev-shm-usage",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--touch-events=disabled",  # but on phones
)


def wait(condition, what):
    """Waits for a true value and returns it."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError(f"{what}: not within {LIMIT:g} s")


def join(name):
    """Makes this process a node, once there is a ROS master."""

    def there():
        try:
            return rospy.get_master().getPid()[0] == 1
        except OSError:
            return False

    wait(there, "the ROS master")
    rospy.init_node(name, disable_signals=True)


class Run:
    """A command of ./run in a session of its own, on a ROS master of the test.

    Attributes:
        said: What it has printed and was read.
    """

    def __init__(self, *words, master, **environ):
        """Starts it."""
        self.said = ""
        self.process = subprocess.Popen(
            [str(ROOT / "run"), *words],
            env={**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{master}", **environ},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def read(self, pattern):
        """Reads up to a line with a pattern; gives its match."""
        for line in self.process.stdout:
            self.said += line
            if found := re.search(pattern, line):
                return found
        raise AssertionError(f"no {pattern!r} in: {self.said}")

    def end(self):
        """Ends it as Ctrl-C does; gives its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.said += self.process.communicate(timeout=LIMIT)[0]
        return self.process.returncode


class Web(Run):
    """A world with its page.

    Attributes:
        url: The address that it has printed.
    """

    def __init__(self, *words, master, **environ):
        """Starts it and reads the address; words: a command of ./run and its arguments."""
        super().__init__(*words, master=master, **environ)
        self.url = self.read(r"the page, in a browser: (http://\S+/)")[1]


class Browser:
    """A headless Chromium.

    Args:
        width, height: Of the page [px].
        touch: Whether it is a phone: touch events, no mouse.
    """

    def __init__(self, width=1920, height=1080, touch=False):
        self._folder = tempfile.mkdtemp(prefix="paddock-chromium-")
        options = webdriver.ChromeOptions()
        for option in (*OPTIONS, f"--user-data-dir={self._folder}"):
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
        self.driver.set_script_timeout(LIMIT)
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=touch,
        )
        if touch:
            self.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=5)

    def call(self, name, **arguments):
        """Executes a command of Chromium's debugging protocol."""
        return self.driver.execute_cdp_cmd(name, arguments)

    def run(self, script, *arguments):
        """Runs JavaScript; gives what it returns."""
        return self.driver.execute_script(script, *arguments)

    def open(self, url):
        """Opens a page and waits until it shows the world."""
        self.driver.get(url)
        wait(
            lambda: self.run(
                "return document.getElementById('cover').hidden && page.world.bodies.size"
            ),
            "the world on the page",
        )

    def box(self, element):
        """Center, width and height of an element [px], by its id."""
        return self.run(
            "const b = document.getElementById(arguments[0]).getBoundingClientRect();"
            "return [b.left + b.width / 2, b.top + b.height / 2, b.width, b.height]",
            element,
        )

    def click(self, x, y):
        """Clicks a place [px]."""
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            button = {} if kind == "mouseMoved" else {"button": "left", "clickCount": 1}
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **button)

    def key(self, code, down):
        """Presses or releases a key, such as KeyW or ArrowUp."""
        key = code[len("Key") :].lower() if code.startswith("Key") else code
        self.call("Input.dispatchKeyEvent", type="keyDown" if down else "keyUp", code=code, key=key)

    def touch(self, kind, *points):
        """Moves fingers: touchStart, touchMove or touchEnd with their places [px]."""
        touches = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        self.call("Input.dispatchTouchEvent", type=kind, touchPoints=touches)

    def picture(self):
        """The page, (H, W, 3) uint8 RGB.

        The world is drawn once and not anew meanwhile: on a busy machine, software that draws one
        frame after the other leaves no time for the picture.
        """
        self.run("page.panels.frame(); page.world.render = () => {}")
        try:
            self.settle()
            # get_screenshot_as_png gives up after 10 s.
            data = base64.b64decode(self.call("Page.captureScreenshot")["data"])
        finally:
            self.run("delete page.world.render")
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))

    def settle(self):
        """Waits until the browser has shown what was drawn so far."""
        self.driver.execute_async_script(
            "const done = arguments[0];"
            "requestAnimationFrame(() => requestAnimationFrame(() => done()))"
        )

    def shoot(self, name):
        """Keeps a picture of the page for people; gives it."""
        SHOTS.mkdir(parents=True, exist_ok=True)
        picture = self.picture()
        Image.fromarray(picture).save(SHOTS / f"{name}.png")
        return picture

    def errors(self):
        """What the page's console has complained about."""
        return [
            entry["message"]
            for entry in self.driver.get_log("browser")
            if entry["level"] == "SEVERE" or "Error" in entry["message"]
        ]

    def close(self):
        """Ends it."""
        with contextlib.suppress(Exception):
            self.driver.quit()
        shutil.rmtree(self._folder, ignore_errors=True)
