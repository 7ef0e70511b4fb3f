"""The desk in headless Chromium: page, picture, clicks, latency, token, two browsers, password."""

import json
import signal
import statistics
import time

import numpy as np
import pytest
import rospy
from desk_rig import SHOTS, Desk
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from paddock_common.process import free_port
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait
from vnc_client import ROW, stop_button
from web_rig import LIMIT, join, wait

CLICKS = 50
LOSSY = 24  # how far JPEG may bend a colour
# Tells when the browser has got the release of the mouse [ms since 1970].
LISTEN = "window.addEventListener('mouseup', event => { window.released = performance.timeOrigin"
LISTEN += " + event.timeStamp }, true)"
WINDOW = "from PyQt5.QtWidgets import *; app = QApplication([]); label = QLabel('here');"
WINDOW += " label.setStyleSheet('background: #b3261e'); label.show(); app.exec_()"


def stop_in(browser):
    """Finds the window's Stop button in a browser's picture."""
    picture = browser.picture()
    return None if picture is None else stop_button(picture, LOSSY)


@pytest.fixture(scope="module")
def node(desk):
    """This test as a node of the desk's ROS master: its lists of commands and of odometry."""
    join("browser_test")
    commands, odometry = [], []
    rospy.Subscriber("/cmd_vel", Twist, lambda message: commands.append((time.time(), message)))
    rospy.Subscriber("/racecar/odom", Odometry, odometry.append)
    wait(lambda: odometry, "odometry")
    return commands, odometry


def test_a_click_on_forward_moves_the_car(desk, browsers, node):
    commands, odometry = node
    browser = browsers()
    browser.driver.get(desk.url)
    assert "noVNC" in browser.driver.title
    x, y = wait(lambda: stop_in(browser), "the window in the browser")
    middle = np.s_[420:800, 600:1000]  # road and its middle line, or a dark ground with no line
    wait(lambda: browser.picture()[middle].std() > 25.0, "the camera's picture")
    browser.shoot("window")
    begin = odometry[-1].pose.pose.position.x
    x, y = stop_in(browser)
    browser.click(x, y - ROW)
    command = wait(lambda: commands, "a command")[0][1]
    assert (command.linear.x, command.angular.z) == (10.0, 0.0)
    wait(lambda: odometry[-1].pose.pose.position.x > begin + 0.1, "the car's move")


def test_latency_from_click_to_command(desk, browsers, node):
    commands, _ = node
    browser = browsers()
    browser.driver.get(desk.url)
    x, y = wait(lambda: stop_in(browser), "the window in the browser")
    browser.driver.execute_script(LISTEN)
    latencies = []
    while len(latencies) < CLICKS:
        del commands[:]
        browser.click(x, y)
        arrived = wait(lambda: commands, "a command")[0][0]
        released = browser.driver.execute_script("return window.released") / 1000.0
        latencies.append(arrived - released)
        time.sleep(0.1)
    figures = {
        "median_ms": round(1000.0 * statistics.median(latencies), 1),
        "longest_ms": round(1000.0 * max(latencies), 1),
        "clicks": len(latencies),
    }
    print("latency from click to /cmd_vel:", figures)
    SHOTS.mkdir(parents=True, exist_ok=True)
    (SHOTS / "latency.json").write_text(json.dumps(figures))
    assert min(latencies) > 0.0


def test_a_second_browser_sees_the_same(desk, browsers, node):
    commands, _ = node
    pictures, (first, second) = [], (browsers(), browsers())
    for browser in (first, second):
        browser.driver.get(desk.url)
        wait(lambda: stop_in(browser), "the window in the browser")
    x, y = map(int, stop_in(first))
    assert np.abs(np.subtract((x, y), stop_in(second))).max() <= 2.0  # [px]
    del commands[:]
    first.click(x - 100, y)  # Left: the command's read-out changes for a while
    wait(lambda: commands, "a command")
    around = np.s_[y - 2 * ROW : y + 3 * ROW, max(0, x - 180) : x + 180]

    def same():
        pictures[:] = [browser.picture()[around].astype(int) for browser in (first, second)]
        return abs(pictures[0] - pictures[1]).mean() < 2.0

    wait(same, "the same picture in both")
    assert pictures[0].std() > 10.0
    second.shoot("second_browser")


def test_a_shared_desk_asks_for_the_password(browsers):
    desk = Desk(
        *("--share", "exec", "python3", "-c", WINDOW),
        master=free_port(),
        DESK_PASSWORD="parking",
    )
    try:
        for password, let_in in (("parkinG", False), ("parking", True)):
            browser = browsers()
            browser.driver.get(desk.url)
            field = browser.driver.find_element(By.ID, "noVNC_password_input")
            WebDriverWait(browser.driver, LIMIT).until(lambda _: field.is_displayed())
            assert browser.picture() is None
            field.send_keys(password)
            browser.driver.find_element(By.ID, "noVNC_credentials_button").click()
            if let_in:
                wait(lambda: stop_in(browser), "the window in the browser")
            else:
                words = (By.ID, "noVNC_status")
                status = browser.driver.find_element(*words)
                wait(lambda: "rejected" in status.get_attribute("textContent"), "the refusal")
                assert browser.picture() is None
    finally:
        desk.end()


def colours(picture):
    """Counts the colours of a picture; rviz brings hundreds."""
    return len(np.unique(picture[::4, ::4].reshape(-1, 3), axis=0))


def test_window_and_rviz_stand_side_by_side(browsers):
    desk = Desk("rviz:=true", master=free_port())
    try:
        browser = browsers()
        browser.driver.get(desk.url)
        wait(lambda: browser.picture() is not None, "a picture")

        def tiled():
            halves = np.array_split(browser.picture(), 2, axis=1)
            found = [stop_button(half, LOSSY) is not None for half in halves]
            return sum(found) == 1 and colours(halves[found.index(False)]) > 100

        wait(tiled, "window and rviz")
        time.sleep(5.0)  # for people: rviz has its picture
        browser.shoot("window_and_rviz")
    finally:
        desk.end()


def test_the_truck_brings_rviz(browsers):
    desk = Desk("truck", master=free_port())
    try:
        browser = browsers()
        browser.driver.get(desk.url)
        wait(lambda: browser.picture() is not None, "a picture")
        wait(lambda: colours(browser.picture()) > 200, "rviz")
        time.sleep(5.0)  # for people: rviz has its picture
        browser.shoot("truck")
    finally:
        assert desk.end() == 128 + signal.SIGINT


@pytest.mark.parametrize("program, status", [("true", 0), ("false", 1)])
def test_a_desk_ends_with_its_command(master, program, status):
    desk = Desk("exec", program, master=master)
    desk.said += desk.process.communicate(timeout=LIMIT)[0]
    assert desk.process.returncode == status
    assert "has lost" not in desk.said
