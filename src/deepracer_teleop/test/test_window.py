"""The window offscreen: where widgets are and what real clicks and drags put on /cmd_vel."""

import threading
import time

import numpy as np
import pytest
from cv_bridge import CvBridge
from deepracer_teleop.camera import FrameRate, draw_frame_rate, frame_rate_text
from deepracer_teleop.window import window as module
from paddock_common.master import MasterMonitor
from PyQt5.QtCore import Qt
from PyQt5.QtGui import QColor
from PyQt5.QtWidgets import QApplication, QCheckBox, QLabel, QPushButton, QSlider


def position(window, widget):
    return window.grid.getItemPosition(window.grid.indexOf(widget))


def frame(color=(40, 120, 200), stamp=None, encoding="bgr8"):
    message = CvBridge().cv2_to_imgmsg(np.full((480, 640, 3), color, np.uint8), encoding)
    if stamp is not None:
        message.header.stamp.secs = int(stamp)
        message.header.stamp.nsecs = round((stamp % 1) * 1e9)
    return message


def test_layout(teleop):
    window = teleop.build()
    assert window.windowTitle() == "Teleop Interface"
    cells = {
        "Forward": (0, 1),
        "Left": (1, 0),
        "Stop": (1, 1),
        "Right": (1, 2),
        "Backwards": (2, 1),
    }
    for name, cell in cells.items():
        assert isinstance(window.buttons[name], QPushButton)
        assert window.buttons[name].text() == name
        assert position(window, window.buttons[name])[:2] == cell
    assert isinstance(window.cruise, QCheckBox) and window.cruise.text() == "Cruise Control"
    assert position(window, window.cruise)[:2] == (1, 3)
    assert position(window, window.slider)[:2] == (2, 3)
    assert position(window, window.cameraLabel)[:2] == (3, 1)
    assert isinstance(window.cameraLabel, QLabel)


def test_a_long_problem_does_not_widen_the_window(teleop):
    window = teleop.build()
    narrow = window.minimumSizeHint().width()
    window.troubleLabel.setText("x" * 500)
    window.troubleLabel.show()
    assert window.minimumSizeHint().width() == narrow


def test_slider_is_as_specified(teleop):
    slider = teleop.build().slider
    assert slider is module.directionalSlider and isinstance(slider, QSlider)
    assert (slider.minimum(), slider.maximum(), slider.value()) == (-50, 50, 0)
    assert slider.orientation() == Qt.Horizontal
    assert slider.tickPosition() == QSlider.TicksBelow and slider.tickInterval() == 1


@pytest.mark.parametrize(
    "name, command, seconds",
    [
        ("Forward", (10, 0), 1.0),
        ("Backwards", (-10, 0), 1.0),
        ("Left", (10, -5), 0.8),
        ("Right", (10, 5), 0.8),
    ],
)
def test_timed_buttons(teleop, name, command, seconds):
    teleop.build()
    teleop.click(name)
    assert teleop.take() == [command]
    teleop.advance(seconds - 0.01)
    assert set(teleop.take()) == {command}
    teleop.advance(0.01)
    assert teleop.take() == [(0, 0)]
    teleop.advance(1.0)
    assert teleop.take() == []


def test_stop_during_a_timed_move(teleop):
    teleop.build()
    teleop.click("Left")
    teleop.advance(0.3)
    teleop.take()
    teleop.click("Stop")
    assert teleop.take() == [(0, 0)]
    teleop.advance(2.0)
    assert teleop.take() == []


def test_drag_without_cruise_steers_at_rest(teleop):
    window = teleop.build()
    teleop.drag(window.slider, 60)
    sent = teleop.take()
    assert window.slider.value() > 0 and len(sent) > 1
    assert sent[-1] == (0, window.slider.value() / 10)
    assert [angular for _, angular in sent] == sorted(angular for _, angular in sent)


def test_cruise_and_drag(teleop):
    window = teleop.build()
    teleop.toggle_cruise()
    assert window.cruise.isChecked() and module.sliderControl is True
    assert teleop.take() == [(10, 0)]
    teleop.drag(window.slider, -60)
    sent = teleop.take()
    assert window.slider.value() < 0 and sent[-1] == (10, window.slider.value() / 10)
    assert all(linear == 10 for linear, _ in sent)
    teleop.advance(0.5)
    assert teleop.take() == [sent[-1]] * 5
    teleop.toggle_cruise()
    assert teleop.take() == [(0, window.slider.value() / 10)]
    assert module.sliderControl is False


def test_parameters_adapt_the_window_to_ackermann(teleop):
    window = teleop.build(
        default_speed=0.3,
        default_angular_speed=1.0,
        angular_sign=-1,
        slider_scale=50,
        linear_wait=0.5,
    )
    teleop.click("Left")
    assert teleop.take() == [(0.3, 1.0)]
    window.slider.setValue(25)
    assert teleop.take() == [(0, -0.5)]
    teleop.click("Forward")
    teleop.advance(0.5)
    assert teleop.take()[-1] == (0, 0)


def test_closing_sends_one_zero(teleop):
    window = teleop.build()
    teleop.click("Forward")
    teleop.take()
    window.close()
    window.finish()
    assert teleop.take() == [(0, 0)]


def test_module_functions(teleop):
    window = teleop.build()
    for function, command in (
        (module.fwdFunct, (10, 0)),
        (module.bwdFunct, (-10, 0)),
        (module.leftFunct, (10, -5)),
        (module.rightFunct, (10, 5)),
        (module.stopFunct, (0, 0)),
    ):
        function()
        assert teleop.take() == [command]
    window.treatValue(30)
    assert teleop.take() == [(0, 3)]


def test_convert_keeps_aspect_and_color(teleop):
    window = teleop.build()
    window.cameraLabel.resize(400, 240)
    pixmap = module.convertCVtoQT(window, np.full((480, 640, 3), (200, 120, 40), np.uint8))
    assert (pixmap.width(), pixmap.height()) == (320, 240)
    assert QColor(pixmap.toImage().pixel(160, 120)).getRgb()[:3] == (40, 120, 200)


def send_from_thread(window, *messages):
    """Passes frames as rospy does; returns when Qt's thread has processed them."""
    for message in messages:
        thread = threading.Thread(target=window.imageCb, args=(message,))
        thread.start()
        thread.join()
        QApplication.processEvents()


def test_camera_image_is_inside_with_the_frame_rate(teleop):
    window = teleop.build()
    send_from_thread(window, frame(stamp=10.0), frame(stamp=10.0 + 1 / 30))
    shot = window.grab().toImage()
    box = window.cameraLabel.geometry()
    center = QColor(shot.pixel(box.center()))
    assert center.getRgb()[:3] == (200, 120, 40)
    pixmap = window.cameraLabel.pixmap()
    assert pixmap.width() * 3 == pytest.approx(pixmap.height() * 4, abs=4)
    image = pixmap.toImage()
    corner = {
        image.pixel(x, y)
        for x in range(5, image.width() // 2, 2)
        for y in range(3, image.height() // 10)
    }
    rest = {
        image.pixel(x, y)
        for x in range(0, image.width(), 7)
        for y in range(image.height() // 2, image.height(), 7)
    }
    assert len(corner) > 5 and len(rest) == 1


def test_the_image_grows_with_the_window(teleop):
    window = teleop.build()
    send_from_thread(window, frame(stamp=1.0))
    before = window.cameraLabel.pixmap().width()
    window.resize(1100, 900)
    QApplication.processEvents()
    assert window.cameraLabel.pixmap().width() > before
    assert window.cameraLabel.pixmap().width() <= window.cameraLabel.width()


def test_frames_that_pile_up_are_dropped(teleop):
    window = teleop.build()
    for index in range(100):
        window.imageCb(frame(color=(0, 0, index), stamp=1.0 + index))
    shown = []
    window.cameraLabel.show_image = shown.append
    QApplication.processEvents()
    assert len(shown) == 1 and QColor(shown[0].toImage().pixel(100, 100)).red() == 99


def test_a_missing_and_a_stopped_camera_are_shown(teleop):
    window = teleop.build(camera_timeout=0.05)
    window._health.stop()  # a slow machine takes longer than that to show an image
    time.sleep(0.1)
    window._check_health()
    assert "No camera" in window.cameraLabel.text()
    assert "/camera/image" in window.cameraLabel.text()
    send_from_thread(window, frame(stamp=1.0))
    assert window.cameraLabel.message == "" and not window.cameraLabel.text()
    bright = QColor(window.cameraLabel.pixmap().toImage().pixel(2, 200)).lightness()
    time.sleep(0.1)
    teleop.now += 5.0
    window._check_health()
    assert "has stopped" in window.cameraLabel.message and "100.0 s" in window.cameraLabel.message
    assert QColor(window.cameraLabel.pixmap().toImage().pixel(2, 200)).lightness() < bright
    send_from_thread(window, frame(stamp=2.0))
    assert window.cameraLabel.message == ""


def test_an_undecodable_image_is_reported(teleop):
    window = teleop.build()
    message = frame(stamp=1.0)
    message.encoding = "nonsense"
    send_from_thread(window, message)
    assert "nonsense" in window.cameraLabel.text()


def test_an_unavailable_master_is_shown_and_sets_the_exit_code(teleop):
    window, now = teleop.build(), [0.0]
    window._monitor = MasterMonitor("http://x:1", lambda _: "a", now=lambda: now[0])
    window._check_health()
    assert not window.troubleLabel.isVisible() and window.exitCode == 0
    now[0] = 5.0
    window._check_health()
    assert window.troubleLabel.isVisible() and window.exitCode == 1
    assert "http://x:1 has not responded for 5 s" in window.troubleLabel.text()


@pytest.mark.parametrize(
    "stamps, rates",
    [
        ([1.0, 1.5, 2.0], [None, 2.0, 2.0]),
        ([1.0, 1.0], [None, None]),
        ([5.0, 1.0, 1.1], [None, None, 10.0]),
    ],
)
def test_frame_rate_from_stamps(stamps, rates):
    counter = FrameRate()
    assert [counter.update(stamp) for stamp in stamps] == [
        None if rate is None else pytest.approx(rate) for rate in rates
    ]


@pytest.mark.parametrize(
    "rate, text",
    [(29.97, "Image Framerate: 30"), (7.52, "Image Framerate: 7.5"), (None, "Image Framerate: --")],
)
def test_frame_rate_text(rate, text):
    assert frame_rate_text(rate) == text
    image = draw_frame_rate(np.zeros((480, 640, 3), np.uint8), rate)
    assert image[:60].any() and not image[60:].any()
