"""The truck on the page in Chromium: a click sets its goal, a button cancels it."""

import math
import time

import pytest
from web_rig import Run, Web, wait

TRUCK = "page.world.body('cybertruck')"
NEAR = 0.3  # [m] of a goal: the controller stops at 0.15 m from it
GOALS = ((3.0, 1.0), (10.0, 4.5))  # in the world [m]
AWAY = (8.0, 6.0, 1.2)  # where the truck is put: x, y [m], yaw [rad]


@pytest.fixture(scope="module")
def truck(master):
    """A truck without its trailer, its page, and the node that drives it to goals."""
    world = ("truck", "web:=true", "headless:=true", "trailer:=false", "lidar:=false")
    running = Web(*world, master=master)
    goal = Run("exec", "roslaunch", "cybertruck", "goal.launch", "trailer:=false", master=master)
    yield running
    goal.end()
    running.end()


@pytest.fixture
def page(truck, browsers):
    """An open page that knows of the goals' service and looks from above."""
    browser = browsers(width=1000, height=700)
    browser.open(truck.url)
    wait(lambda: not browser.run("return document.getElementById('goal').hidden"), "the tool")
    browser.run("page.panels.look('above')")
    return browser


def press(browser, element):
    """Presses a button of the panel Do, which is open just meanwhile."""
    toggle = "document.querySelector('[data-panel=do]').click()"
    browser.run(toggle)
    browser.click(*browser.box(element)[:2])
    browser.run(toggle)


def notices(browser):
    """What the page has said lately."""
    return browser.run("return byId('notices').textContent")


def place(browser):
    """The truck's x, y [m] and yaw [rad]."""
    return browser.run(f"const b = {TRUCK}; return [b.state[1], b.state[2], page.world.yaw(b)]")


def click_goal(browser, x, y):
    """Chooses the tool by its button and clicks a place of the world [m]."""
    press(browser, "goal")
    assert browser.run("return page.tool") == "goal"
    at = browser.run("return page.world.toPage(new THREE.Vector3(...arguments))", x, y, 0)
    browser.click(at["x"], at["y"])


def ring(browser):
    """x, y [m] of the goal that the page shows; None: it shows none."""
    return browser.run(
        "const r = page.world.ring; return r && r.visible ? [r.position.x, r.position.y] : null"
    )


def arrive(browser, goal):
    """Waits until the page shows a goal and the truck is there."""
    wait(lambda: (ring(browser) or None) and math.dist(ring(browser), goal) < 0.1, "the ring")
    wait(lambda: math.dist(place(browser)[:2], goal) < NEAR, "the truck at its goal")


def test_a_click_sends_the_truck_there_also_after_it_was_put_elsewhere(page):
    browser = page
    click_goal(browser, *GOALS[0])
    arrive(browser, GOALS[0])
    wait(
        lambda: browser.run("return (page.extra['to the goal'] || [9])[0]") < NEAR,
        "the plotted distance",
    )
    browser.shoot("goal")
    # The wheels' odometry does not know that the truck is put elsewhere; a click still counts
    # where it is in the world.
    x, y, yaw = AWAY
    browser.run(
        "page.act('place', {model: 'cybertruck', x: arguments[0], y: arguments[1], z: 0,"
        " yaw: arguments[2]})",
        x,
        y,
        yaw,
    )
    wait(lambda: math.dist(place(browser)[:2], (x, y)) < 0.2, "the truck there")
    browser.run("page.panels.look('above')")
    click_goal(browser, *GOALS[1])
    arrive(browser, GOALS[1])
    assert browser.errors() == []


def test_a_goal_is_cancelled_by_the_button_and_the_truck_stops(page):
    browser = page
    start = place(browser)
    away = (start[0] + 2.0 * math.cos(start[2]), start[1] + 2.0 * math.sin(start[2]))
    click_goal(browser, *away)
    wait(lambda: math.dist(place(browser)[:2], start[:2]) > 0.3, "the truck on its way")
    # A slow browser may need longer for the button than the truck for its way.
    browser.run("page.act('pause')")
    press(browser, "cancel")
    wait(lambda: "the goal is cancelled" in notices(browser), "the answer")
    browser.run("page.act('resume')")
    wait(lambda: ring(browser) is None, "the ring's end")
    time.sleep(2.0)
    before = place(browser)
    time.sleep(2.0)
    assert math.dist(place(browser)[:2], before[:2]) < 0.05
    assert math.dist(before[:2], away) > 0.5


def test_a_goal_that_is_refused_is_said(page):
    browser = page
    browser.run("page.act('goal', {x: 9000, y: 0, z: 0})")
    wait(lambda: "/goal has refused" in notices(browser), "the refusal")
