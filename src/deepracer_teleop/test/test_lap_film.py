"""The film of a lap."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import rospy
from deepracer_teleop.recording import Film
from deepracer_teleop.runs.lap import LapFilm
from sensor_msgs.msg import Image

from track_model.msg import LapStatus


def test_film_has_the_frames_that_were_due(tmp_path):
    path = str(tmp_path / "lap.mp4")
    film = Film(path, rate=10.0)
    written = 0
    for k in range(90):  # 3 s at 30 Hz
        image = np.full((120, 160, 3), (40, 90, 200), np.uint8)
        written += film.add(5.0 + k / 30.0, image, "line  lap 1") is not None
        assert (image == (40, 90, 200)).all()  # the overlay goes onto a copy
    film.close()
    assert written == film.frames == 30
    video = cv2.VideoCapture(path)
    assert (video.get(3), video.get(4)) == (160, 120) and video.get(5) == pytest.approx(10.0)
    success, frame = video.read()
    assert success and video.get(cv2.CAP_PROP_FRAME_COUNT) == 30
    assert np.abs(frame[60].astype(int) - (40, 90, 200)).max() < 25
    assert frame[:40].max() > 200 and frame[100:].max() > 200  # text above and below


def test_a_clock_that_jumps_back_does_not_stop_the_film(tmp_path):
    film = Film(str(tmp_path / "lap.mp4"), rate=10.0)
    image = np.zeros((48, 64, 3), np.uint8)
    for time in (100.0, 100.1, 0.0, 0.1):
        assert film.add(time, image, "") is not None
    film.close()


def test_invalid_folder_and_rate(tmp_path):
    with pytest.raises(ValueError, match="film rate"):
        Film(str(tmp_path / "lap.mp4"), rate=0.0)
    with pytest.raises(OSError, match="cannot be written"):
        Film(str(tmp_path / "missing" / "lap.mp4")).add(0.0, np.zeros((48, 64, 3), np.uint8), "")


def test_a_late_frame_does_not_change_a_closed_film(tmp_path):
    path = tmp_path / "lap.mp4"
    film = Film(str(path), rate=10.0)
    image = np.zeros((48, 64, 3), np.uint8)
    for k in range(20):
        film.add(k / 10.0, image, "")
    film.close()
    size = path.stat().st_size
    assert film.add(5.0, image, "") is None
    film.close()
    assert path.stat().st_size == size > 200


def test_a_film_that_cannot_be_written_is_logged_and_the_lap_continues(tmp_path, monkeypatch):
    logged = []
    monkeypatch.setattr(rospy, "logerr_throttle", lambda _, text: logged.append(text))
    film = Film(str(tmp_path / "missing" / "lap.mp4"))
    camera = LapFilm(film, SimpleNamespace(status=LapStatus()), driver="")
    camera.recording = True
    camera.callback(Image(height=48, width=64, encoding="bgr8", step=192, data=bytes(9216)))
    assert len(logged) == 1 and "cannot be written" in logged[0]
