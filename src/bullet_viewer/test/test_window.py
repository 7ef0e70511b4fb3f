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


def pixel_of(viewer, point):
    """Where a point of the world is in the view [px]."""
    view = viewer.window.view
    pixels, _ = project(
        [point], view.camera.pose, view.camera.horizontal_fov, view.width(), view.height()
    )
    return QPoint(*(round(value) for value in pixels[0]))


def is_red(image, position):
    color = QColor(image.pixel(position))
    return color.red() > 60 and color.green() < 25 and color.blue() < 25


def drag(view, button, right, down, steps=5):
    """Presses a button at the centre, moves and releases it, as Qt gets it from a mouse."""
    start = QPointF(view.width() / 2.0, view.height() / 2.0)
    QTest.mousePress(view, button, pos=start.toPoint())
    for step in range(1, steps + 1):
        position = QPointF(start.x() + right * step / steps, start.y() + down * step / steps)
        QApplication.sendEvent(
            view, QMouseEvent(QEvent.MouseMove, position, Qt.NoButton, button, Qt.NoModifier)
        )
    QTest.mouseRelease(view, button, pos=position.toPoint())


def wheel(view, notches):
    centre = QPointF(view.width() / 2.0, view.height() / 2.0)
    QApplication.sendEvent(
        view,
        QWheelEvent(
            centre,
            QPointF(view.mapToGlobal(centre.toPoint())),
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


def test_the_first_movable_model_is_at_the_centre_in_its_color(viewer):
    viewer.box("red", (3.0, -2.0, 0.5))
    image = viewer.image()
    assert is_red(image, QPoint(image.width() // 2, image.height() // 2))
    assert pixel_of(viewer, (3.0, -2.0, 0.5)) == QPoint(image.width() // 2, image.height() // 2)


def test_left_drag_orbits_and_the_image_follows(viewer):
    viewer.box("red", (0.0, 0.0, 0.5))
    viewer.box("second", (0.0, 1.0, 0.5))
    viewer.image()
    camera = viewer.window.view.camera
    yaw, pitch = camera.yaw, camera.pitch
    before = pixel_of(viewer, (0.0, 1.0, 0.5))
    drag(viewer.window.view, Qt.LeftButton, 120.0, 40.0)
    assert camera.yaw < yaw and camera.pitch > pitch
    image, position = viewer.image(), pixel_of(viewer, (0.0, 1.0, 0.5))
    assert is_red(image, QPoint(image.width() // 2, image.height() // 2)), "orbits the first"
    assert is_red(image, position), "the second is visible at its new position"
    assert (position - before).manhattanLength() > 30 and not is_red(image, before)


@pytest.mark.parametrize("button", [Qt.RightButton, Qt.MiddleButton])
def test_right_or_middle_drag_shifts(viewer, button):
    viewer.box("red", (0.0, 0.0, 0.5))
    viewer.image()
    drag(viewer.window.view, button, -90.0, 60.0)
    image, view = viewer.image(), viewer.window.view
    assert pixel_of(viewer, (0.0, 0.0, 0.5)) == QPoint(
        view.width() // 2 - 90, view.height() // 2 + 60
    )
    assert is_red(image, pixel_of(viewer, (0.0, 0.0, 0.5)))
    assert not is_red(image, QPoint(view.width() // 2 + 60, view.height() // 2 - 60))


def test_wheel_moves_closer(viewer):
    viewer.box("red", (0.0, 0.0, 0.5))
    small = red_pixels(viewer.image())
    wheel(viewer.window.view, 2)
    assert red_pixels(viewer.image()) > 1.2 * small


def test_following_a_model_keeps_it_at_the_centre(viewer):
    viewer.box("first", (0.0, 0.0, 0.5), rgba="0 0 1 1")
    runner = viewer.box("runner", (1.0, 0.0, 0.5))
    viewer.image()
    box = viewer.window.follow
    assert [box.itemText(i) for i in range(box.count())] == [
        "free camera",
        "ground_plane",
        "first",
        "runner",
    ]
    box.setCurrentText("runner")
    box.activated.emit(box.currentIndex())
    viewer.image()
    runner.set_state(runner.pose.__class__((30.0, 5.0, 0.5)))
    image = viewer.image()
    assert viewer.window.view.camera.target == pytest.approx([30.0, 5.0, 0.5])
    assert is_red(image, QPoint(image.width() // 2, image.height() // 2))
    viewer.world.delete("runner")
    viewer.image()
    assert box.currentText() == "free camera", "a deleted model cannot be followed"


def test_lidar_rays_are_drawn_and_can_be_hidden(viewer):
    viewer.box("car", (0.0, 0.0, 0.5), rgba="0.5 0.5 0.5 1", more=LIDAR)
    with_rays = viewer.image()
    viewer.window.rays_box.setChecked(False)
    without = viewer.image()
    angle = 3.1 / 35.0  # of the ray next to straight ahead
    end = pixel_of(viewer, (math.cos(angle), math.sin(angle), 0.5))

    def blueness(image):
        return max(
            QColor(image.pixel(end + QPoint(dx, dy))).blue()
            - QColor(image.pixel(end + QPoint(dx, dy))).red()
            for dx in (-1, 0, 1)
            for dy in (-1, 0, 1)
        )

    assert blueness(with_rays) > blueness(without) + 20


def click(viewer, point):
    """A click on the pixel of a point of the world, and the image after it."""
    QTest.mouseClick(viewer.window.view, Qt.LeftButton, pos=pixel_of(viewer, point))
    assert viewer.window._clicked is not None
    viewer.until(lambda: viewer.window._clicked is None, "the image with labels")
    return viewer.image()


def is_painted(image, position, color):
    """Whether a color is at the position, or next to it as of thin lines."""
    colors = (QColor(image.pixel(position + QPoint(x, y))) for x in (-1, 0, 1) for y in (-1, 0, 1))
    return any(
        abs(pixel.red() - color[0]) + abs(pixel.green() - color[1]) + abs(pixel.blue() - color[2])
        < 90
        for pixel in colors
    )


def test_a_click_selects_the_model_and_shows_its_frames(viewer):
    viewer.box("near", (0.0, 0.0, 0.5), rgba="0.5 0.5 0.5 1")
    viewer.box("far", (0.0, 1.0, 0.5), rgba="0.5 0.5 0.5 1")
    viewer.image()
    image = click(viewer, (0.0, 1.0, 0.5))
    window = viewer.window
    assert window.selected == "far"
    assert window.selected_label.text().startswith("far: x 0.000  y 1.000  z 0.500 m")
    camera = window.view.camera
    length = 0.06 * math.dist(camera.position, (0.0, 1.0, 0.5))
    for axis, color in enumerate(((230, 40, 40), (40, 190, 40), (50, 90, 255))):
        tip = [0.0, 1.0, 0.5]
        tip[axis] += 0.8 * length
        assert is_painted(image, pixel_of(viewer, tip), color), f"axis {axis}"
    drag(window.view, Qt.LeftButton, 60.0, 0.0)
    viewer.image()
    assert window.selected == "far", "a drag selects nothing"
    click(viewer, (0.0, 0.0, 0.5))
    assert window.selected == "near"
    viewer.world.delete("near")
    viewer.image()
    viewer.image()
    assert window.selected == "" and window.selected_label.text() == ""


def test_contact_points_are_painted_where_they_are(viewer):
    viewer.world.engine.set_gravity((0.0, 0.0, -9.81))
    viewer.window.resize(900, 480)  # the full toolbar is visible
    viewer.box("box", (0.0, 0.0, 0.2), rgba="0.5 0.5 0.5 1")
    viewer.world.step(200)
    without = viewer.image()
    QTest.mouseClick(viewer.window.contacts_box, Qt.LeftButton)
    viewer.image()
    image = viewer.image()
    assert viewer.window.contacts_box.isChecked()
    contacts = viewer.observer.view(False).contacts.places  # the solver may load two corners alone
    assert len(contacts) >= 2 and abs(contacts[:, :2]) == pytest.approx(0.2, abs=1e-3)
    pixels = [pixel_of(viewer, position) for position in contacts]
    painted = [is_painted(image, position, (255, 170, 0)) for position in pixels]
    assert all(painted) and not any(
        is_painted(without, position, (255, 170, 0)) for position in pixels
    )


def test_buttons_send_what_the_bridge_does(viewer):
    viewer.image()
    window = viewer.window
    QTest.mouseClick(window.pause_button, Qt.LeftButton)
    viewer.paused = True
    viewer.until(lambda: window.pause_button.text() == "Resume", "the button to change")
    assert "paused" in window.clock_label.text()
    window.steps.setValue(25)
    QTest.mouseClick(window.step_button, Qt.LeftButton)
    QTest.mouseClick(window.pause_button, Qt.LeftButton)
    QTest.mouseClick(window.reset_button, Qt.LeftButton)
    viewer.until(lambda: len(viewer.requests) == 4, "four messages")
    assert viewer.requests == [("pause",), ("step", 25), ("unpause",), ("reset",)]


def test_clock_shows_simulated_time(viewer):
    viewer.world.step(1500)
    viewer.until(lambda: "1.5" in viewer.window.clock_label.text(), "the time")


def test_no_view_is_requested_while_minimized_and_nothing_rendered_without_a_change(viewer):
    viewer.paused = True
    viewer.until(lambda: viewer.frames, "the first image")
    viewer.until(lambda: viewer.views > 5, "more views")
    count, views = len(viewer.frames), viewer.views
    viewer.until(lambda: viewer.views > views + 5, "more views")
    assert len(viewer.frames) == count, "the same world from the same pose is rendered once"
    viewer.window.showMinimized()
    viewer.pump()
    views = viewer.views
    end = time.monotonic() + 0.5
    while time.monotonic() < end:
        viewer.pump()
    assert viewer.views <= views + 1
    viewer.window.showNormal()
    viewer.until(lambda: viewer.views > views + 1, "a view again")


def test_the_rate_of_views_is_limited(viewer):
    viewer.until(lambda: viewer.frames, "the first image")
    start, views = time.monotonic(), viewer.views
    while time.monotonic() < start + 1.0:
        viewer.world.step()
        viewer.pump()
    assert viewer.views - views <= (time.monotonic() - start) * 1000.0 / module.PERIOD + 2


def test_a_body_that_cannot_be_rendered_is_named_and_the_rest_is_rendered(viewer):
    viewer.image()
    red, broken = viewer.box("red", (0.0, 0.0, 0.5)), viewer.box("broken", (5.0, 0.0, 0.5))
    with open(broken.source.path, "w", encoding="utf-8") as file:
        file.write("<robot")
    image = viewer.image()
    assert is_red(image, pixel_of(viewer, red.pose.position))
    assert broken.source.path in viewer.window.statusBar().currentMessage()


def test_a_missing_image_is_requested_again(viewer, monkeypatch):
    viewer.image()
    monkeypatch.setattr(module, "RENDER_TIMEOUT", 0.2)
    render, jobs = viewer.renderer.render, []
    monkeypatch.setattr(viewer.renderer, "render", lambda *job, **_: jobs.append(job))
    viewer.until(lambda: len(jobs) >= 1 or viewer.world.step(), "a render job")
    viewer.until(lambda: "trying again" in viewer.window.view.message, "the message")
    monkeypatch.setattr(viewer.renderer, "render", render)
    viewer.image()
    assert viewer.window.view.message == ""


def test_an_error_of_the_bridge_is_shown_and_the_viewer_continues(viewer):
    viewer.image()
    viewer.connection.send(("error", "the simulation did not respond"))
    viewer.until(
        lambda: "did not respond" in viewer.window.statusBar().currentMessage(), "the message"
    )
    viewer.image()


def test_the_exit_of_the_bridge_closes_the_feed(viewer):
    disconnected = []
    viewer.window._feed.disconnected.connect(lambda: disconnected.append(True))
    viewer.connection.close()
    viewer.until(lambda: disconnected, "the end")


def test_real_time_factor_is_simulated_time_over_wall_time():
    now = [0.0]
    factor = module.RealTimeFactor(clock=lambda: now[0])
    factors = []
    for step in range(60):
        now[0] = 0.05 * step
        factors.append(factor.update(0.2 * step))
    assert factors[0] is None
    assert factors[-1] == pytest.approx(4.0)
    assert factor.update(0.0) is None, "a reset restarts it"
