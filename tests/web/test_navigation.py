"""Navigation on the page in Chromium: map, costmap, plan and particles; goals for move_base."""

import math

import numpy as np
import pytest
import rospy
from actionlib_msgs.msg import GoalID
from bullet_web.navigation import inverse, placed
from geometry_msgs.msg import Pose, PoseArray, PoseStamped, TransformStamped
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import OccupancyGrid, Path
from tf2_msgs.msg import TFMessage
from web_rig import wait

pytestmark = pytest.mark.isolated  # it is a ROS node

ODOM = (2.0, 1.0, 0.3)  # pose of the odometry's frame, which is the world's, in the map
CELL = 0.1  # [m]
BLOCK = (1.0, 0.5)  # x, y [m] of an obstacle's middle
SIZE = 60  # cells of a side
CORNER = (-1.0, -2.0)  # x, y [m] of the map's origin
MAP, COSTMAP = "/map", "/move_base/global_costmap/costmap"
PLAN, PARTICLES = "/move_base/NavfnROS/plan", "/particlecloud"
PLACE = (1.5, 1.0)  # [m] in the world


class Stack:
    """Publishes what a navigation stack does, and takes goals."""

    def __init__(self):
        """Publishes everything once, latched."""
        rospy.init_node("navigation_test", disable_signals=True)
        self.goals, self.cancelled = [], []
        self.node = rospy.get_name()
        rospy.Subscriber("/move_base_simple/goal", PoseStamped, self.goals.append)
        rospy.Subscriber(f"{self.node}/cancel", GoalID, self.cancelled.append)
        self.goal = rospy.Publisher(f"{self.node}/current_goal", PoseStamped, queue_size=1)
        self._publishers = [self.latched("/tf_static", self.transform())]
        self.grids = {name: self.latched(name, self.grid()) for name in (MAP, COSTMAP)}
        self.updates = rospy.Publisher(f"{COSTMAP}_updates", OccupancyGridUpdate, queue_size=1)
        path, cloud = Path(), PoseArray()
        path.header.frame_id = cloud.header.frame_id = "map"
        for number in range(20):
            pose = PoseStamped(pose=Pose())
            pose.pose.position.x = 0.1 * number
            path.poses.append(pose)
            pose = Pose()
            pose.position.x, pose.position.y = ODOM[0] + 0.02 * number, ODOM[1] + 0.01 * number
            pose.orientation.w = 1.0
            cloud.poses.append(pose)
        self._publishers += [self.latched(PLAN, path), self.latched(PARTICLES, cloud)]

    @staticmethod
    def latched(topic, message):
        """Publishes a message; whoever comes later gets it, too."""
        publisher = rospy.Publisher(topic, type(message), queue_size=1, latch=True)
        publisher.publish(message)
        return publisher

    @staticmethod
    def transform():
        """The frame odom in the frame map."""
        found = TransformStamped(child_frame_id="odom")
        found.header.frame_id = "map"
        found.transform.translation.x, found.transform.translation.y = ODOM[:2]
        found.transform.rotation.z = math.sin(ODOM[2] / 2)
        found.transform.rotation.w = math.cos(ODOM[2] / 2)
        return TFMessage([found])

    @staticmethod
    def grid():
        """A free map with one block of 5 by 5 cells."""
        message = OccupancyGrid()
        message.header.frame_id = "map"
        info = message.info
        info.resolution, info.width, info.height = CELL, SIZE, SIZE
        info.origin.position.x, info.origin.position.y = CORNER
        info.origin.orientation.w = 1.0
        cells = np.zeros((SIZE, SIZE), np.int8)
        column, row = (round((BLOCK[axis] - CORNER[axis]) / CELL) for axis in (0, 1))
        cells[row - 2 : row + 3, column - 2 : column + 3] = 100
        message.data = cells.ravel().tolist()
        return message


@pytest.fixture(scope="module")
def stack(web):
    """A navigation stack beside the track with the car."""
    return Stack()


@pytest.fixture
def page(web, stack, browsers):
    """An open page that looks from above and knows of the topics."""
    browser = browsers(width=1000, height=700)
    browser.open(web.url)
    browser.run("page.panels.look('above')")
    listed = "return [...byId('layers').querySelectorAll('input')].map((box) => box.value)"
    wait(lambda: {MAP, COSTMAP, PLAN, PARTICLES} <= set(browser.run(listed)), "the topics")
    wait(lambda: not browser.run("return byId('goal').hidden"), "the tool")
    return browser


def tick(browser, topic):
    """Ticks a topic's box, or clears it."""
    browser.run(
        "[...byId('layers').querySelectorAll('input')]"
        ".find((box) => box.value === arguments[0]).click()",
        topic,
    )


def has(browser, topic):
    """Whether the page shows a topic."""
    return browser.run("return page.world.layers.has(arguments[0])", topic)


def pixels(browser, picture, place):
    """The middle of what the picture has at a place of the map [m], (3, 3, 3) uint8."""
    x, y = placed(inverse(ODOM), (*place, 0.0))[:2]
    at = browser.run("return page.world.toPage(new THREE.Vector3(...arguments))", x, y, 0.012)
    column, row = round(at["x"]), round(at["y"])
    return picture[row - 1 : row + 2, column - 1 : column + 2].astype(int)


def test_maps_plans_and_particles_are_in_their_places(page, stack):
    before = page.picture()
    for topic in (MAP, PLAN, PARTICLES):
        tick(page, topic)
    for topic in (MAP, PLAN, PARTICLES):
        wait(lambda each=topic: has(page, each), topic)
    found = wait(
        lambda: page.run(
            "const f = page.world.frames.get('map');"
            "return f && f.visible && [f.position.x, f.position.y, f.rotation.z]"
        ),
        "the map's frame",
    )
    assert found == pytest.approx(inverse(ODOM), abs=0.02)
    picture = page.shoot("navigation")
    block, beside = BLOCK, (BLOCK[0] + 0.6, BLOCK[1])
    assert pixels(page, picture, block).max() < 60
    assert pixels(page, picture, beside).mean() > pixels(page, before, beside).mean() + 10
    plan = pixels(page, picture, (0.6, 0.0)).reshape(-1, 3)
    assert (plan[:, 1] - plan[:, 0]).max() > 60, "green"
    for topic in (MAP, PLAN, PARTICLES):
        tick(page, topic)
    wait(lambda: not any(has(page, each) for each in (MAP, PLAN, PARTICLES)), "nothing")
    assert not page.errors()


def test_a_costmap_follows_its_updates(page, stack):
    tick(page, COSTMAP)
    wait(lambda: has(page, COSTMAP), "the costmap")
    size = "const l = page.world.layers.get(arguments[0]); return l && l.children[0].geometry"
    size += ".parameters.width"
    assert page.run(size, COSTMAP) == pytest.approx(5 * CELL)
    update = OccupancyGridUpdate(x=SIZE - 4, y=0, width=4, height=2, data=[100] * 8)
    wait(lambda: stack.updates.get_num_connections() > 0, "a subscriber of the updates")
    stack.updates.publish(update)
    wait(lambda: (page.run(size, COSTMAP) or 0.0) > 20 * CELL, "the update")


def test_a_click_sends_a_goal_in_the_frame_of_the_map(page, stack):
    page.run("document.querySelector('[data-panel=do]').click()")
    page.click(*page.box("goal")[:2])
    page.run("document.querySelector('[data-panel=do]').click()")
    at = page.run("return page.world.toPage(new THREE.Vector3(...arguments))", *PLACE, 0)
    page.click(at["x"], at["y"])
    goal = wait(lambda: stack.goals and stack.goals[-1], "the goal")
    assert goal.header.frame_id == "map"
    position = goal.pose.position
    assert (position.x, position.y) == pytest.approx(placed(ODOM, (*PLACE, 0.0))[:2], abs=0.05)
    stack.goal.publish(goal)  # as move_base does
    ring = "const r = page.world.ring; return r && r.visible && [r.position.x, r.position.y]"
    shown = wait(lambda: page.run(ring), "the ring")
    assert shown == pytest.approx(PLACE, abs=0.05)
    page.run("page.act('cancel', {})")
    wait(lambda: stack.cancelled, "the cancelling")
    wait(lambda: page.run(ring) is False, "no ring")
