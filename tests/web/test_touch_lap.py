"""A lap on a phone by two thumbs, in headless Chromium; docs/images/touch.webp is its film."""

import io
import math
import re
import time

from deepracer_control.ackermann import Geometry
from deepracer_control.drivers.pursuit import Path, Pursuit
from PIL import Image
from track_model.referee.referee import Car
from track_model.track import load_track
from web_rig import SHOTS, wait

LIMIT = 500.0  # wall time of the lap [s]
PACE = 0.25  # simulated seconds per second: software renders few frames
SPEED = 0.7  # [m/s] on straights
CAR, REAR_AXLE = Geometry(), Car().rear  # x of the rear axle in the car's frame [m]
LARGEST = math.radians(60.0)  # hinge angle of a full thumb
TRAVEL = 0.4  # of a pad's size: a full thumb
BETWEEN = 0.8  # wall time between two frames of the film [s]
FILM_SIZE = (195, 422)  # [px]
FILM_TIME = 120  # of a frame of the film [ms]


class Thumbs:
    """The thumbs on the pads, the right one for the speed and the left one for steering."""

    def __init__(self, browser):
        self._browser = browser
        self._speed, self._steering = browser.box("speedpad"), browser.box("steerpad")
        browser.touch("touchStart", self._speed[:2], self._steering[:2])

    def move(self, speed, steering):
        """Moves them; both -1 to 1, steering to the right is positive."""
        x, y, _, height = self._speed
        left, middle, width, _ = self._steering
        self._browser.touch(
            "touchMove",
            (x, y - TRAVEL * height * speed),
            (left + TRAVEL * width * steering, middle),
        )

    def lift(self):
        """Lifts both."""
        self._browser.touch("touchEnd")


def test_a_lap_by_two_thumbs(web, browsers):
    browser = browsers(width=390, height=844, touch=True)
    browser.open(web.url)
    wait(lambda: browser.run("return page.topSpeed && page.topSpeed.speed"), "a topic to drive")
    browser.run("page.act('pace', {factor: arguments[0]})", PACE)
    browser.run("document.getElementById('path').click()")
    # The lap's time comes with the plots, which would cover the world on a phone.
    browser.run("byId('plots').hidden = false; page.want(); byId('plots').hidden = true;")
    track = load_track("default")
    pursuit = Pursuit(Path(track.centreline, closed=track.closed), lookahead=0.5, max_speed=SPEED)
    # A full thumb is the top speed of the slider: 1 of the topic's largest.
    browser.run("byId('top').value = 1; byId('top').dispatchEvent(new Event('input'))")
    largest = browser.run("return page.topSpeed.speed") * CAR.wheel_radius  # [m/s]
    thumbs = Thumbs(browser)
    frames, shot, end = [], 0.0, time.monotonic() + LIMIT
    try:
        while not (found := re.search(r"last ([\d.]+) s", lap_text(browser))):
            assert time.monotonic() < end, f"no lap within {LIMIT:g} s: {lap_text(browser)}"
            x, y, yaw = browser.run(
                "const b = page.world.body('racecar');"
                "return [b.state[1], b.state[2], page.world.yaw(b)]"
            )
            speed, curvature = pursuit.command(
                x + REAR_AXLE * math.cos(yaw), y + REAR_AXLE * math.sin(yaw), yaw
            )
            angle = -math.atan(CAR.wheelbase * curvature)
            thumbs.move(min(1.0, speed / largest), max(-1.0, min(1.0, angle / LARGEST)))
            if time.monotonic() - shot > BETWEEN:
                shot = time.monotonic()
                frames.append(Image.fromarray(browser.picture()).resize(FILM_SIZE, Image.LANCZOS))
    finally:
        thumbs.lift()
        browser.run("page.act('pace', {factor: 1})")
    seconds = float(found[1])
    assert track_length(track) / 1.5 < seconds < track_length(track) / 0.3
    wait(lambda: browser.run("return page.hands.last[0] === 0"), "the zero")
    film(frames)
    browser.shoot("touch_lap")
    assert browser.errors() == []


def lap_text(browser):
    """What the page says of laps."""
    return browser.run("return byId('lap').textContent")


def track_length(track):
    """Length of the center line [m]."""
    points = [*track.centreline, track.centreline[0]]
    return sum(math.dist(a, b) for a, b in zip(points, points[1:]))


def film(frames):
    """Writes the film of the frames."""
    SHOTS.mkdir(parents=True, exist_ok=True)
    first, *others = frames
    stream = io.BytesIO()
    first.save(
        stream,
        "WEBP",
        save_all=True,
        append_images=others,
        duration=FILM_TIME,
        loop=0,
        quality=45,
        method=4,
    )
    (SHOTS / "touch.webp").write_bytes(stream.getvalue())
