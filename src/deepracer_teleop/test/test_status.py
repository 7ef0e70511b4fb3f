"""The lines at the bottom, position and size, scale and palette."""

import os
import re
from types import SimpleNamespace

import pytest
import rospy
from deepracer_teleop.recording import Recording, excluded
from deepracer_teleop.window import layout
from deepracer_teleop.window.settings import WindowGeometry
from deepracer_teleop.window.status import RealTimeFactor, Status, lap_texts, simulation_text
from PyQt5.QtCore import QRect
from PyQt5.QtGui import QColor, QPalette
from PyQt5.QtWidgets import QApplication

from track_model.msg import LapStatus


def real_time_factor(*samples):
    monitor = RealTimeFactor()
    for wall, ros in samples:
        monitor.sample(wall, ros)
    return monitor.factor


@pytest.mark.parametrize(
    "samples, factor",
    [
        ([(0.0, 5.0)], None),
        ([(0.0, 5.0), (0.25, 5.0)], None),
        ([(0.0, 5.0), (0.25, 5.0), (0.5, 5.0)], 0.0),
        ([(0.25 * k, 10.0 + 0.75 * k) for k in range(20)], 3.0),
        ([(0.25 * k, 0.05 * k) for k in range(4)], 0.2),
        ([(0.0, 9.0), (0.25, 0.0), (0.5, 0.25)], 1.0),  # a reset
        ([(0.0, 1.0), (0.25, 1.25), (0.5, 1.25), (1.0, 1.25)], 0.0),
        ([(float(k), 2.0 * k) for k in range(9)] + [(8.0 + k, 16.0 + k) for k in (1, 2, 3)], 1.0),
    ],
)
def test_real_time_factor(samples, factor):
    assert real_time_factor(*samples) == (None if factor is None else pytest.approx(factor))


@pytest.mark.parametrize(
    "factor, now, text",
    [
        (None, 0.0, "waiting for /clock"),
        (None, 3.0, "simulation runs"),
        (0.0, 12.34, "paused at 12.3 s"),
        (0.998, 3.0, "1.00 × real time"),
    ],
)
def test_simulation_text(factor, now, text):
    assert simulation_text(factor, now) == text


def test_lap_texts():
    assert lap_texts("", LapStatus()) == ["lap not started"]
    status = LapStatus(running=True, laps=2, lap_time=3.21, best_lap_time=31.234, off_track=True)
    assert lap_texts("/home/me/my_track.yaml", status) == [
        "track my_track",
        "lap 3, 3.2 s",
        "best 31.23 s",
        "off the track",
    ]


def test_the_line_of_a_simulation_with_a_referee(monkeypatch):
    status = Status(clock=lambda: wall[0])
    wall = [0.0]
    monkeypatch.setattr(rospy, "get_time", lambda: 100.0 + 0.5 * wall[0])
    monkeypatch.setattr(rospy, "get_param", {"/referee/track": "hard"}.get)
    assert status.text() == "no simulation"
    monkeypatch.setattr(rospy.rostime, "is_wallclock", lambda: False)
    wall[0] = 1.0
    message = LapStatus(running=True, lap_time=7.0)
    message._connection_header = {"callerid": "/referee"}
    monkeypatch.setattr(rospy, "get_param", lambda name, default: {"/referee/track": "hard"}[name])
    status.callback(message)
    assert status.text() == "0.50 × real time · track hard · lap 1, 7.0 s"


def test_the_window_shows_the_line_below_the_image(teleop):
    window = teleop.build()
    assert window.statusLabel.text() == "no simulation"
    assert window.statusLabel.geometry().top() > window.cameraLabel.geometry().bottom()
    assert not window.recordLabel.isVisible() and window.recordButton.text() == "Record"
    assert window.grid.getItemPosition(window.grid.indexOf(window.recordButton))[:2] == (0, 3)


def test_position_and_size_are_restored(teleop, tmp_path):
    geometry = WindowGeometry(tmp_path / "teleop.ini")
    window = teleop.build()
    assert not geometry.restore(window)
    window.setGeometry(40, 60, 733, 611)
    QApplication.processEvents()
    geometry.save(window)
    window.setGeometry(0, 0, 600, 500)
    assert WindowGeometry(tmp_path / "teleop.ini").restore(window)
    QApplication.processEvents()
    assert window.geometry() == QRect(40, 60, 733, 611)


def test_an_invalid_stored_geometry_is_ignored(teleop, tmp_path):
    path = tmp_path / "teleop.ini"
    path.write_text("[window]\ngeometry=nonsense\n")
    window = teleop.build()
    size = window.size()
    assert not WindowGeometry(path).restore(window) and window.size() == size


def test_closing_stores_position_and_size(teleop):
    stored = []
    window = teleop.build()
    window._geometry = SimpleNamespace(save=lambda window: stored.append(window.size()))
    window.close()
    assert stored == [window.size()]


def contrast(first, second):
    """Contrast of two QColors as WCAG 2.1 defines it, 1..21."""

    def luminance(color):
        parts = [value / 255 for value in color.getRgb()[:3]]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


@pytest.fixture(params=["#efefef", "#353535"])
def palette(request):
    before = QApplication.palette()
    ground = QColor(request.param)
    yield QPalette(ground, ground)
    QApplication.setPalette(before)


def test_text_is_readable_on_light_and_dark(teleop, palette):
    window = teleop.build()
    QApplication.setPalette(palette)
    QApplication.processEvents()
    name = layout.shade(window.palette())
    assert name == ("dark" if palette.color(QPalette.Window).lightness() < 128 else "light")
    assert layout.RED[name] in window.buttons["Stop"].styleSheet()
    button, ground = palette.color(QPalette.Button), palette.color(QPalette.Window)
    assert contrast(QColor(layout.RED[name]), button) > 4.5
    assert contrast(QColor(layout.RECORDING[name]), ground) > 4.5
    shot = window.grab().toImage()
    box = window.buttons["Stop"].geometry()
    reds = [
        contrast(QColor(shot.pixel(x, y)), button)
        for x in range(box.left() + 8, box.right() - 8)
        for y in range(box.top() + 6, box.bottom() - 6)
    ]
    assert max(reds) > 4.0  # there is text, with contrast


def test_topics_excluded_from_the_bag():
    pattern = excluded([("/camera/image", "sensor_msgs/Image"), ("/scan", "sensor_msgs/LaserScan")])
    for name, is_excluded in (
        ("/camera/image", True),
        ("/camera/image/compressed", True),
        ("/clock", True),
        ("/gazebo/model_states", True),
        ("/scan", False),
        ("/cmd_vel", False),
        ("/camera/camera_info", False),
    ):
        assert bool(re.fullmatch(pattern, name)) == is_excluded, name


def test_a_bag_that_is_renamed_meanwhile_has_no_size(tmp_path, monkeypatch):
    recording = Recording(tmp_path)
    recording._bag = SimpleNamespace(poll=lambda: None)
    monkeypatch.setattr(os.path, "exists", lambda path: True)  # it was there a moment ago
    assert "(0 kB)" in recording.text()
