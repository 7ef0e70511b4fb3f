"""The window offscreen: a real world, a real renderer, real mouse events."""

import math
import time

import pytest
from bullet_viewer.view import project
from PyQt5.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt5.QtGui import QColor, QMouseEvent, QWheelEvent
from PyQt5.QtTest import QTest
from PyQt5.QtWidgets import QApplication

from bullet_viewer import window as module

LIDAR = """<gazebo reference="box"><sensor type="ray" name="lidar">
  <visualize>true</visualize><update_rate>1000</update_rate>
  <ray><scan><horizontal><samples>36</samples>
    <min_angle>-3.1</min_angle><max_angle>3.1</max_angle></horizontal></scan>
    <range><min>0.3</min><max>3</max></range></ray>
  <plugin name="p" filename="libgazebo_ros_laser.so"><topicName>scan</topicName></plugin>
</sensor></gazebo>"""


def place_of(rig, point):
    """Where a point of the world is in the view [px]."""
    view = rig.window.view
    places, _ = project(
        [point], view.camera.pose, view.camera.horizontal_fov, view.width(), view.height()
    )
    return QPoint(*(round(value) for value in places[0]))


def is_red(image, place):
    colour = QColor(image.pixel(place))
    return colour.red() > 60 and colour.green() < 25 and colour.blue() < 25


def drag(view, button, right, down, steps=5):
    """Presses a button in the middle, moves and lets go, as Qt gets it from a mouse."""
    start = QPointF(view.width() / 2.0, view.height() / 2.0)
    QTest.mousePress(view, button, pos=start.toPoint())
    for step in range(1, steps + 1):
        place = QPointF(start.x() + right * step / steps, start.y() + down * step / steps)
        QApplication.sendEvent(
            view, QMouseEvent(QEvent.MouseMove, place, Qt.NoButton, button, Qt.NoModifier)
        )
    QTest.mouseRelease(view, button, pos=place.toPoint())


def wheel(view, notches):
    middle = QPointF(view.width() / 2.0, view.height() / 2.0)
    QApplication.sendEvent(
        view,
        QWheelEvent(
            middle,
            QPointF(view.mapToGlobal(middle.toPoint())),
            QPoint(),
            QPoint(0, 120 * notches),
            Qt.NoButton,
            Qt.NoModifier,
            Qt.NoScrollPhase,
            False,
        ),
    )


def red_pixels(image):
    return sum(
        is_red(image, QPoint(x, y))
        for x in range(0, image.width(), 4)
        for y in range(0, image.height(), 4)
    )


def test_the_first_moving_model_is_in_the_middle_in_its_colour(rig):
    rig.box("red", (3.0, -2.0, 0.5))
    image = rig.picture()
    assert is_red(image, QPoint(image.width() // 2, image.height() // 2))
    assert place_of(rig, (3.0, -2.0, 0.5)) == QPoint(image.width() // 2, image.height() // 2)


def test_left_drag_circles_and_the_picture_follows(rig):
    rig.box("red", (0.0, 0.0, 0.5))
    rig.box("second", (0.0, 1.0, 0.5))
    rig.picture()
    camera = rig.window.view.camera
    yaw, pitch = camera.yaw, camera.pitch
    before = place_of(rig, (0.0, 1.0, 0.5))
    drag(rig.window.view, Qt.LeftButton, 120.0, 40.0)
    assert camera.yaw < yaw and camera.pitch > pitch
    image, place = rig.picture(), place_of(rig, (0.0, 1.0, 0.5))
    assert is_red(image, QPoint(image.width() // 2, image.height() // 2)), "turns about the first"
    assert is_red(image, place), "the second is seen at its new place"
    assert (place - before).manhattanLength() > 30 and not is_red(image, before)


@pytest.mark.parametrize("button", [Qt.RightButton, Qt.MiddleButton])
def test_right_or_middle_drag_shifts(rig, button):
    rig.box("red", (0.0, 0.0, 0.5))
    rig.picture()
    drag(rig.window.view, button, -90.0, 60.0)
    image, view = rig.picture(), rig.window.view
    assert place_of(rig, (0.0, 0.0, 0.5)) == QPoint(view.width() // 2 - 90, view.height() // 2 + 60)
    assert is_red(image, place_of(rig, (0.0, 0.0, 0.5)))
    assert not is_red(image, QPoint(view.width() // 2 + 60, view.height() // 2 - 60))


def test_wheel_comes_nearer(rig):
    rig.box("red", (0.0, 0.0, 0.5))
    small = red_pixels(rig.picture())
    wheel(rig.window.view, 2)
    assert red_pixels(rig.picture()) > 1.2 * small


def test_following_a_model_keeps_it_in_the_middle(rig):
    rig.box("first", (0.0, 0.0, 0.5), rgba="0 0 1 1")
    runner = rig.box("runner", (1.0, 0.0, 0.5))
    rig.picture()
    box = rig.window.follow
    assert [box.itemText(i) for i in range(box.count())] == [
        "free camera",
        "ground_plane",
        "first",
        "runner",
    ]
    box.setCurrentText("runner")
    box.activated.emit(box.currentIndex())
    rig.picture()
    runner.set_state(runner.pose.__class__((30.0, 5.0, 0.5)))
    image = rig.picture()
    assert rig.window.view.camera.target == pytest.approx([30.0, 5.0, 0.5])
    assert is_red(image, QPoint(image.width() // 2, image.height() // 2))
    rig.world.delete("runner")
    rig.picture()
    assert box.currentText() == "free camera", "what is gone cannot be followed"


def test_lidar_rays_are_drawn_and_can_be_hidden(rig):
    rig.box("car", (0.0, 0.0, 0.5), rgba="0.5 0.5 0.5 1", more=LIDAR)
    with_rays = rig.picture()
    rig.window.rays_box.setChecked(False)
    without = rig.picture()
    angle = 3.1 / 35.0  # of the ray next to straight ahead
    end = place_of(rig, (math.cos(angle), math.sin(angle), 0.5))

    def blueness(image):
        return max(
            QColor(image.pixel(end + QPoint(dx, dy))).blue()
            - QColor(image.pixel(end + QPoint(dx, dy))).red()
            for dx in (-1, 0, 1)
            for dy in (-1, 0, 1)
        )

    assert blueness(with_rays) > blueness(without) + 20


def click(rig, point):
    """A click on what is seen of a point of the world, and the picture after it."""
    QTest.mouseClick(rig.window.view, Qt.LeftButton, pos=place_of(rig, point))
    assert rig.window._clicked is not None
    rig.until(lambda: rig.window._clicked is None, "the picture that tells what is there")
    return rig.picture()


def is_painted(image, place, color):
    """Whether a colour is there, as thin lines have it at some pixel beside the place."""
    found = (QColor(image.pixel(place + QPoint(x, y))) for x in (-1, 0, 1) for y in (-1, 0, 1))
    return any(
        abs(pixel.red() - color[0]) + abs(pixel.green() - color[1]) + abs(pixel.blue() - color[2])
        < 90
        for pixel in found
    )


def test_a_click_selects_the_model_and_shows_its_frames(rig):
    rig.box("near", (0.0, 0.0, 0.5), rgba="0.5 0.5 0.5 1")
    rig.box("far", (0.0, 1.0, 0.5), rgba="0.5 0.5 0.5 1")
    rig.picture()
    image = click(rig, (0.0, 1.0, 0.5))
    window = rig.window
    assert window.selected == "far"
    assert window.selected_label.text().startswith("far: x 0.000  y 1.000  z 0.500 m")
    camera = window.view.camera
    length = 0.06 * math.dist(camera.position, (0.0, 1.0, 0.5))
    for axis, color in enumerate(((230, 40, 40), (40, 190, 40), (50, 90, 255))):
        tip = [0.0, 1.0, 0.5]
        tip[axis] += 0.8 * length
        assert is_painted(image, place_of(rig, tip), color), f"axis {axis}"
    drag(window.view, Qt.LeftButton, 60.0, 0.0)
    rig.picture()
    assert window.selected == "far", "a drag selects nothing"
    click(rig, (0.0, 0.0, 0.5))
    assert window.selected == "near"
    rig.world.delete("near")
    rig.picture()
    rig.picture()
    assert window.selected == "" and window.selected_label.text() == ""


def test_contact_points_are_painted_where_they_are(rig):
    rig.world.engine.set_gravity((0.0, 0.0, -9.81))
    rig.window.resize(900, 480)  # the whole toolbar is seen
    rig.box("box", (0.0, 0.0, 0.2), rgba="0.5 0.5 0.5 1")
    rig.world.step(200)
    without = rig.picture()
    QTest.mouseClick(rig.window.contacts_box, Qt.LeftButton)
    rig.picture()
    image = rig.picture()
    assert rig.window.contacts_box.isChecked()
    contacts = rig.observer.view(False).contacts.places  # the solver may load two corners alone
    assert len(contacts) >= 2 and abs(contacts[:, :2]) == pytest.approx(0.2, abs=1e-3)
    places = [place_of(rig, place) for place in contacts]
    found = [is_painted(image, place, (255, 170, 0)) for place in places]
    assert all(found) and not any(is_painted(without, place, (255, 170, 0)) for place in places)


def test_buttons_send_what_the_bridge_does(rig):
    rig.picture()
    window = rig.window
    QTest.mouseClick(window.pause_button, Qt.LeftButton)
    rig.paused = True
    rig.until(lambda: window.pause_button.text() == "Resume", "the button to change")
    assert "paused" in window.clock_label.text()
    window.steps.setValue(25)
    QTest.mouseClick(window.step_button, Qt.LeftButton)
    QTest.mouseClick(window.pause_button, Qt.LeftButton)
    QTest.mouseClick(window.reset_button, Qt.LeftButton)
    rig.until(lambda: len(rig.requests) == 4, "four messages")
    assert rig.requests == [("pause",), ("step", 25), ("unpause",), ("reset",)]


def test_clock_shows_simulated_time(rig):
    rig.world.step(1500)
    rig.until(lambda: "1.5" in rig.window.clock_label.text(), "the time")


def test_no_view_is_requested_while_minimised_and_nothing_drawn_without_a_change(rig):
    rig.paused = True
    rig.until(lambda: rig.frames, "the first picture")
    rig.until(lambda: rig.views > 5, "more views")
    count, views = len(rig.frames), rig.views
    rig.until(lambda: rig.views > views + 5, "more views")
    assert len(rig.frames) == count, "the same world from the same place is drawn once"
    rig.window.showMinimized()
    rig.pump()
    views = rig.views
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        rig.pump()
    assert rig.views <= views + 1
    rig.window.showNormal()
    rig.until(lambda: rig.views > views + 1, "a view again")


def test_the_rate_of_views_is_limited(rig):
    rig.until(lambda: rig.frames, "the first picture")
    begin, views = time.monotonic(), rig.views
    while time.monotonic() < begin + 1.0:
        rig.world.step()
        rig.pump()
    assert rig.views - views <= (time.monotonic() - begin) * 1000.0 / module.PERIOD + 2


def test_a_body_that_cannot_be_drawn_is_named_and_the_rest_is_drawn(rig):
    rig.picture()
    red, lost = rig.box("red", (0.0, 0.0, 0.5)), rig.box("lost", (5.0, 0.0, 0.5))
    with open(lost.source.path, "w", encoding="utf-8") as file:
        file.write("<robot")
    image = rig.picture()
    assert is_red(image, place_of(rig, red.pose.position))
    assert lost.source.path in rig.window.statusBar().currentMessage()


def test_a_missing_picture_is_requested_again(rig, monkeypatch):
    rig.picture()
    monkeypatch.setattr(module, "DRAWING_LIMIT", 0.2)
    draw, lost = rig.painter.draw, []
    monkeypatch.setattr(rig.painter, "draw", lambda *order, **_: lost.append(order))
    rig.until(lambda: len(lost) >= 1 or rig.world.step(), "an order")
    rig.until(lambda: "trying again" in rig.window.view.message, "the words")
    monkeypatch.setattr(rig.painter, "draw", draw)
    rig.picture()
    assert rig.window.view.message == ""


def test_an_error_of_the_bridge_is_shown_and_the_viewer_goes_on(rig):
    rig.picture()
    rig.connection.send(("error", "the simulation did not answer"))
    rig.until(lambda: "did not answer" in rig.window.statusBar().currentMessage(), "the words")
    rig.picture()


def test_the_end_of_the_bridge_ends_the_feed(rig):
    ended = []
    rig.window._feed.ended.connect(lambda: ended.append(True))
    rig.connection.close()
    rig.until(lambda: ended, "the end")


def test_pace_is_simulated_time_over_wall_time():
    now = [0.0]
    pace = module.Pace(clock=lambda: now[0])
    factors = []
    for step in range(60):
        now[0] = 0.05 * step
        factors.append(pace.update(0.2 * step))
    assert factors[0] is None
    assert factors[-1] == pytest.approx(4.0)
    assert pace.update(0.0) is None, "a reset starts it anew"
