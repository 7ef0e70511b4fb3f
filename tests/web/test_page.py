"""The page in headless Chromium: the world, keys, thumbs, two pages, sizes, camera, replay."""

import math
import subprocess
import time

import cv2
import numpy as np
import pytest
import rospy
from cv_bridge import CvBridge
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image
from web_rig import LIMIT, ROOT, SHOTS, join, wait

pytestmark = pytest.mark.isolated  # it is a ROS node

CAR = "page.world.body('racecar')"
SIZES = [
    ("desktop", 1920, 1080, False),
    ("laptop", 1280, 720, False),
    ("broad", 1180, 820, True),
    ("tablet", 820, 1180, True),
    ("phone", 390, 844, True),
    ("flat", 844, 390, True),
    ("long", 932, 430, True),
]
# What is outside the page or covers something else.
BOXES = """
const boxes = [...document.querySelectorAll('header, #driver, .pad, .panel')].map((e) => {
  const b = e.getBoundingClientRect(), above = e.className === 'pad' ? 16 : 0;  // its name
  return {name: e.id || e.tagName, x: b.left, y: b.top - above, right: b.right, bottom: b.bottom,
          shown: b.width > 0};
}).filter((b) => b.shown);
const found = boxes.filter(
  (b) => b.x < 0 || b.y < 0 || b.right > innerWidth || b.bottom > innerHeight).map((b) => b.name);
boxes.forEach((a, i) => boxes.slice(i + 1).forEach((b) => {
  if (a.x < b.right - 1 && b.x < a.right - 1 && a.y < b.bottom - 1 && b.y < a.bottom - 1)
    found.push(a.name + ' on ' + b.name);
}));
return found;
"""
# The car's camera in the page's world: position and orientation, x forwards.
CAMERA = """
const body = page.world.body('racecar');
const [row, x, y, z, ...turn] = body.frames[arguments[0]];
body.root.updateMatrixWorld(true);
const matrix = new THREE.Matrix4().compose(
  new THREE.Vector3(x, y, z), new THREE.Quaternion(...turn), new THREE.Vector3(1, 1, 1));
matrix.premultiply(body.links[row].matrixWorld);
const place = new THREE.Vector3(), way = new THREE.Quaternion(), size = new THREE.Vector3();
matrix.decompose(place, way, size);
page.world.setCamera(place.toArray(), way.toArray(), arguments[1]);
"""
ALONE = (
    "for (const e of document.querySelectorAll('header, footer, aside, #notices'))"
    " e.style.display = 'none';"
)


class Node:
    """This test as a node of the world's ROS master."""

    def __init__(self):
        join("page_test")
        self.commands, self.odometry = [], []
        rospy.Subscriber("/cmd_vel", Twist, self.commands.append)
        rospy.Subscriber("/racecar/odom", Odometry, self.odometry.append)
        wait(lambda: self.odometry, "odometry")

    @property
    def place(self):
        position = self.odometry[-1].pose.pose.position
        return position.x, position.y

    def moved(self, start, distance):
        return math.dist(self.place, start) > distance

    def last_is_zero(self):
        return self.commands and (self.commands[-1].linear.x, self.commands[-1].angular.z) == (0, 0)

    def ends_once(self):
        """Whether the last command is a zero, and no zero follows another one.

        There may be more of them: a busy browser's pauses of 0.5 s are ends, too.
        """
        zeros = [(m.linear.x, m.angular.z) == (0.0, 0.0) for m in self.commands]
        return zeros[-1] and not any(a and b for a, b in zip(zeros, zeros[1:]))


@pytest.fixture(scope="module")
def node(web):
    return Node()


@pytest.fixture
def page(web, node, browsers):
    """An open page that may drive; the car is at its start."""

    def make(**options):
        browser = browsers(**options)
        browser.open(web.url)
        wait(lambda: browser.run("return page.status.topic"), "a topic to drive")
        browser.run("page.act('place', {model: 'racecar', x: 0, y: 0, z: 0, yaw: 0})")
        wait(lambda: not node.moved((0.0, 0.0), 0.05), "the car at its start")
        time.sleep(0.5)  # for the publisher's connection
        del node.commands[:]
        return browser

    return make


def test_keys_drive_the_car_and_their_release_stops_it(page, node):
    browser = page()
    start = node.place
    browser.key("KeyW", True)
    wait(lambda: node.moved(start, 0.2), "the car's move")
    browser.shoot("keys")
    browser.key("KeyW", False)
    wait(node.last_is_zero, "the zero")
    assert node.commands[0].linear.x > 0.0
    time.sleep(0.5)
    assert node.ends_once()
    assert browser.errors() == []


def test_steering_keys_turn_the_wheels(page, node):
    browser = page()
    browser.key("ArrowUp", True)
    browser.key("ArrowLeft", True)
    wait(lambda: node.commands and node.commands[-1].angular.z < 0.0, "a command to the left")
    hinge = "return page.world.joints(page.world.body('racecar')).left_steering_hinge_joint"
    names = browser.run("return Object.keys(page.world.joints(page.world.body('racecar')))")
    hinge = next(name for name in names if "left_steering" in name)
    angle = f"return page.world.joints({CAR})['{hinge}']"
    wait(lambda: browser.run(angle) > 0.1, "the wheels turned on the page")
    browser.key("Space", True)
    wait(node.last_is_zero, "the zero")
    for code in ("ArrowUp", "ArrowLeft", "Space"):
        browser.key(code, False)
    time.sleep(0.5)
    assert node.ends_once()


def test_thumbs_drive_the_car_on_a_phone(page, node):
    browser = page(width=390, height=844, touch=True)
    speed_x, speed_y, size, _ = browser.box("speedpad")
    steer_x, steer_y, _, _ = browser.box("steerpad")
    start = node.place
    browser.touch("touchStart", (speed_x, speed_y), (steer_x, steer_y))
    browser.touch("touchMove", (speed_x, speed_y - 0.4 * size), (steer_x + 0.3 * size, steer_y))
    wait(lambda: node.moved(start, 0.2), "the car's move")
    assert node.commands[-1].linear.x > 0.0 and node.commands[-1].angular.z > 0.0  # to the right
    browser.shoot("thumbs")
    browser.touch("touchEnd")
    wait(node.last_is_zero, "the zero")
    time.sleep(0.5)
    assert node.ends_once()
    assert browser.errors() == []


def test_cruise_and_slider(page, node):
    browser = page()
    browser.run("document.getElementById('cruise').click()")
    wait(lambda: node.commands and node.commands[-1].linear.x > 0.0, "cruising")
    browser.run(
        "const s = document.getElementById('steer'); s.value = -0.5;"
        "s.dispatchEvent(new Event('input'))"
    )
    wait(lambda: node.commands[-1].angular.z < 0.0, "steering to the left")
    browser.run("document.getElementById('cruise').click()")
    wait(node.last_is_zero, "the zero")


def test_one_page_drives_and_the_other_takes_over(page, node, web, browsers):
    first = page()
    second = browsers(width=800, height=600)
    second.open(web.url)
    first.run("document.getElementById('take').click()")
    wait(lambda: second.run("return document.body.dataset.driver") == "other", "who drives")
    text = "return document.getElementById('take').textContent"
    assert (first.run(text), second.run(text)) == ("Let go", "Take over")
    second.key("KeyW", True)
    time.sleep(1.0)
    second.key("KeyW", False)
    assert node.commands == []
    second.run("document.getElementById('take').click()")
    wait(lambda: first.run("return document.body.dataset.driver") == "other", "the other driver")
    second.key("KeyS", True)
    wait(lambda: node.commands and node.commands[-1].linear.x < 0.0, "backwards")
    second.key("KeyS", False)
    wait(node.last_is_zero, "the zero")


def misplaced(browser):
    """Names of what is outside the page or covers something else."""
    return browser.run(BOXES)


@pytest.mark.parametrize("name, width, height, touch", SIZES)
def test_everything_is_on_the_page_at_each_size(page, name, width, height, touch):
    browser = page(width=width, height=height, touch=touch)
    browser.shoot(name)
    assert misplaced(browser) == []
    for panel in ("look", "plots", "do"):
        browser.run(f"document.querySelector('[data-panel={panel}]').click()")
        if panel == "look":  # with the image, which makes it taller
            wait(lambda: browser.run("return byId('camera').options.length > 1"), "the camera")
            browser.run("byId('camera').selectedIndex = 1; byId('camera').onchange()")
            wait(lambda: browser.run("return byId('picture').naturalWidth"), "its image")
        browser.shoot(f"{name}_{panel}")
        assert misplaced(browser) == []
    shown = browser.run("return document.querySelectorAll('.panel:not([hidden])').length")
    assert shown == (3 if name in ("desktop", "laptop", "broad") else 1)
    assert browser.errors() == []


def test_the_page_shows_what_the_car_s_camera_sees(page, web):
    browser = page(width=320, height=240)
    info = rospy.wait_for_message("/camera/camera_info", CameraInfo, LIMIT)
    fov = 2.0 * math.atan(info.width / (2.0 * info.K[0]))
    browser.run(ALONE)
    browser.run("page.panels.choose(null)")
    browser.run(CAMERA, "camera_link", fov)
    time.sleep(2.0)
    seen = cv2.cvtColor(browser.shoot("camera_page"), cv2.COLOR_RGB2BGR)
    message = rospy.wait_for_message("/camera/image", Image, LIMIT)
    real = CvBridge().imgmsg_to_cv2(message, "bgr8")
    cv2.imwrite(str(SHOTS / "camera_simulator.png"), real)
    coarse = [cv2.resize(each, (32, 24), interpolation=cv2.INTER_AREA).astype(float)
              for each in (seen, real)]  # fmt: skip
    difference = np.abs(coarse[0] - coarse[1]).mean()
    print(f"mean difference of page and camera: {difference:.1f} of 255")
    assert difference < 8.0
    assert np.corrcoef(coarse[0].ravel(), coarse[1].ravel())[0, 1] > 0.97


def test_a_click_names_a_model_and_its_speed(page):
    browser = page()
    x, y = browser.run(f"const p = page.world.toPage({CAR}.root.position); return [p.x, p.y]")
    wait(lambda: (browser.click(x, y), browser.run("return page.panels.chosen"))[1], "a choice")
    assert browser.run("return page.panels.chosen") == "racecar"
    label = browser.run("return document.getElementById('label').textContent")
    assert label.startswith("racecar\nx ") and label.endswith(" m/s")
    browser.shoot("chosen")


def test_the_car_is_put_where_one_clicks_and_things_come_and_go(page, node):
    browser = page()
    browser.run("page.panels.look('above')")
    target = browser.run("return page.world.toPage(new THREE.Vector3(1.0, 0.2, 0)) || null")
    browser.run("page.setTool('place')")
    time.sleep(0.5)
    browser.click(target["x"], target["y"])
    wait(lambda: math.dist(node.place, (1.0, 0.2)) < 0.1, "the car there")
    browser.run("page.setTool('cone')")
    cone = browser.run("return page.world.toPage(new THREE.Vector3(0.3, 0.3, 0))")
    browser.click(cone["x"], cone["y"])
    wait(lambda: browser.run("return Boolean(page.world.body('cone_1'))"), "the cone")
    browser.shoot("placed")
    browser.run("page.panels.choose(page.world.body('cone_1')); page.act('remove')")
    wait(lambda: browser.run("return page.world.body('cone_1') === null"), "the cone gone")


def test_camera_lidar_and_plots_are_shown(page):
    browser = page()
    for panel in ("look", "plots"):
        browser.run(f"document.querySelector('[data-panel={panel}]').click()")
    for element, script in (
        ("camera", "return [...document.getElementById('camera').options].length > 1"),
        ("lidar", "return [...document.getElementById('lidar').options].length > 1"),
    ):
        wait(lambda script=script: browser.run(script), f"the topics of {element}")
        browser.run(
            f"const s = document.getElementById('{element}'); s.selectedIndex = 1; s.onchange()"
        )
    browser.run("document.getElementById('path').click()")
    browser.run("document.getElementById('frames').click()")
    browser.key("KeyW", True)
    wait(lambda: browser.run("return document.getElementById('picture').naturalWidth"), "an image")
    wait(
        lambda: browser.run("return page.world.cloud && page.world.cloud.children.length"), "points"
    )
    wait(lambda: browser.run("return page.panels.plots.curves.size >= 3"), "curves")
    wait(lambda: browser.run("return page.world.path.geometry.drawRange.count > 5"), "a path")
    time.sleep(2.0)
    browser.key("KeyW", False)
    browser.shoot("look")
    assert browser.errors() == []


def test_rays_contacts_and_names_of_frames_are_drawn_on_demand(page):
    browser = page()
    browser.run("document.querySelector('[data-panel=look]').click()")
    wait(lambda: browser.run("return byId('lidar').options.length > 1"), "the lidar's topic")
    for box in ("rays", "contacts", "frames"):
        browser.run(f"byId('{box}').click()")
    browser.run("byId('lidar').selectedIndex = 1; byId('lidar').onchange()")
    browser.run(f"page.panels.choose({CAR})")
    # Nothing on the track gives an echo but what is put there.
    browser.run("page.act('spawn', {kind: 'box', x: 0.8, y: 0, z: 0})")
    points, lines = wait(
        lambda: browser.run(
            "const c = page.world.cloud;"
            "const n = c ? c.children.map(e => e.geometry.attributes.position.count) : [];"
            "return n.length === 2 && n[0] > 0 && n"
        ),
        "points and rays",
    )
    assert lines > 2 * points > 0  # the box is on a few rays alone
    # All rays begin in the lidar, and reach no further than it measures.
    lengths = browser.run(
        "const p = page.world.cloud.children[1].geometry.attributes.position.array;"
        "const all = []; for (let k = 0; k < p.length; k += 6) {"
        " if (p[k] || p[k + 1] || p[k + 2]) throw new Error('a ray begins elsewhere');"
        " all.push(Math.hypot(p[k + 3], p[k + 4], p[k + 5])); } return all"
    )
    assert 0.0 < min(lengths) and max(lengths) < 200.0
    contacts = wait(
        lambda: browser.run(
            "const c = page.world.contacts;"
            "return c && Array.from(c.children[0].geometry.attributes.position.array)"
        ),
        "contact points",
    )
    place = np.reshape(contacts, (-1, 3))
    car = browser.run(f"return {CAR}.state.slice(1, 3)")
    of_car, of_box = (np.hypot(*(place[:, :2] - at).T) < 0.3 for at in (car, (0.8, 0.0)))
    assert of_car.sum() >= 4  # of four wheels
    assert (of_car | of_box).all()
    assert np.abs(place[of_car, 2]).max() < 0.02
    sprites = "return page.world.axes.filter(a => a.children.length).length"
    frames = browser.run(f"return Object.keys({CAR}.frames).length")
    assert browser.run(sprites) == frames
    browser.run("page.panels.look('free')")
    time.sleep(1.0)
    browser.shoot("marks")
    browser.run("page.panels.choose(null)")
    assert browser.run(sprites) == 0
    for box in ("rays", "contacts", "frames"):
        browser.run(f"byId('{box}').click()")
    wait(lambda: browser.run("return page.world.contacts === null"), "no contacts any more")
    wait(lambda: browser.run("return page.world.cloud.children.length === 1"), "no rays any more")
    assert browser.run("return page.world.axes.length") == 0
    x, y = browser.run(f"const p = page.world.toPage({CAR}.root.position); return [p.x, p.y]")
    browser.click(x, y)  # a click meets points and lines, too
    browser.run("page.panels.choose(page.world.body('box_1')); page.act('remove')")
    wait(lambda: browser.run("return page.world.body('box_1') === null"), "the box gone")
    assert browser.errors() == []


def recorded(topics):
    """Whether a node that records subscribes to all of these topics."""
    _, subscribers, _ = rospy.get_master().getSystemState()[2]
    found = {topic for topic, nodes in subscribers if any("record" in name for name in nodes)}
    return found.issuperset(topics)


def test_a_bag_becomes_a_replay_that_opens_from_a_file(page, node, browsers, tmp_path):
    browser = page()
    bag = tmp_path / "drive.bag"
    topics = ("/racecar/odom", "/racecar/joint_states")
    recorder = subprocess.Popen(["rosbag", "record", "-O", str(bag), *topics])
    wait(lambda: recorded(topics), "the recorder's subscriptions")
    time.sleep(1.0)  # for its connections
    browser.key("KeyW", True)
    start = node.place
    wait(lambda: node.moved(start, 0.6), "the car's move")
    browser.key("KeyW", False)
    wait(node.last_is_zero, "the zero")
    recorder.terminate()
    recorder.wait(LIMIT)
    wait(bag.exists, "the bag")
    subprocess.run([str(ROOT / "run"), "replay", str(bag)], check=True)
    replay = tmp_path / "drive.html"
    assert replay.stat().st_size < 10e6
    viewer = browsers(width=1280, height=720)
    viewer.call("Network.enable")
    viewer.call("Network.emulateNetworkConditions", offline=True, latency=0,
                downloadThroughput=0, uploadThroughput=0)  # fmt: skip
    viewer.open(replay.as_uri())
    length = viewer.run("return page.length")
    assert length > 1.0
    x = f"return {CAR}.state[1]"
    viewer.run("page.play(false); page.at = 0; page.show()")
    before = viewer.run(x)
    viewer.run("page.at = page.length; page.show()")
    assert abs(viewer.run(x) - before) > 0.4
    viewer.run("page.play(true)")
    wait(lambda: viewer.run("return page.at > 0.5"), "the replay going on")
    viewer.shoot("replay")
    assert viewer.errors() == []
