"""Films, as decoded by a player."""

import threading

import av
import numpy as np
import pytest
import rospy
from paddock_common.film_node import FilmNode
from paddock_common.films import FilmWriter, FrameTimes
from sensor_msgs.msg import Image

from paddock_common import films


def image_of(level, height=48, width=64):
    return np.full((height, width, 3), level, np.uint8)


def test_a_film_is_h264_with_every_frame_at_its_time(tmp_path):
    path = tmp_path / "film.mp4"
    film = FilmWriter(path, 12.5)
    for level in range(0, 250, 10):
        assert film.add(image_of(level))
    film.close()
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert (stream.codec_context.name, stream.codec_context.pix_fmt) == ("h264", "yuv420p")
        frames = list(container.decode(stream))
    assert len(frames) == film.frames == 25
    assert [frame.time for frame in frames] == pytest.approx([0.08 * k for k in range(25)])
    levels = [frame.to_ndarray(format="bgr24").mean() for frame in frames]
    assert levels == pytest.approx(list(range(0, 250, 10)), abs=4.0)
    head = path.read_bytes()
    assert head.index(b"moov") < head.index(b"mdat")  # plays before it is downloaded completely


@pytest.mark.parametrize("height, width", [(47, 63), (48, 63), (1, 1)])
def test_odd_sizes_grow_by_one(tmp_path, height, width):
    film = FilmWriter(tmp_path / "film.mp4", 10)
    film.add(image_of(90, height, width))
    film.close()
    with av.open(film.path) as container:
        shape = next(container.decode(video=0)).to_ndarray(format="bgr24").shape
    assert shape == (height + height % 2, width + width % 2, 3)


def test_another_size_is_skipped(tmp_path):
    film = FilmWriter(tmp_path / "film.mp4", 10)
    assert film.add(image_of(1)) and not film.add(image_of(1, 20, 20)) and film.add(image_of(2))
    film.close()
    film.close()
    assert film.frames == 2


def test_write_errors_are_reported(tmp_path):
    with pytest.raises(ValueError, match="film rate is 0"):
        FilmWriter(tmp_path / "film.mp4", 0)
    with pytest.raises(OSError, match="missing/film.mp4 cannot be written: No such file"):
        FilmWriter(tmp_path / "missing" / "film.mp4", 10).add(image_of(1))
    with pytest.raises(OSError, match=r"film.mp4 cannot be written: .* \(70000 x 2 pixels\)"):
        FilmWriter(tmp_path / "film.mp4", 10).add(image_of(1, 2, 70000))


def test_a_closed_film_accepts_no_image(tmp_path):
    film = FilmWriter(tmp_path / "film.mp4", 10)
    film.add(image_of(1))
    film.close()
    assert not film.add(image_of(1)) and film.frames == 1
    early = FilmWriter(tmp_path / "none.mp4", 10)
    early.close()
    assert not early.add(image_of(1)) and not (tmp_path / "none.mp4").exists()


def test_closing_waits_for_the_image_of_another_thread(tmp_path, monkeypatch):
    film = FilmWriter(tmp_path / "film.mp4", 10)
    film.add(image_of(1))
    entered, proceed, even = threading.Event(), threading.Event(), films.even
    added = []

    def slow(image):
        entered.set()
        proceed.wait()
        return even(image)

    monkeypatch.setattr(films, "even", slow)
    adding = threading.Thread(target=lambda: added.append(film.add(image_of(2))))
    adding.start()
    entered.wait()
    closing = threading.Thread(target=film.close)
    closing.start()
    closing.join(0.2)
    proceed.set()
    adding.join()
    closing.join()
    assert added == [True]
    with av.open(film.path) as container:
        assert len(list(container.decode(video=0))) == 2


@pytest.mark.parametrize(
    "times, due",
    [
        ([k / 30.0 for k in range(7)], [0, 3, 6]),
        ([5.0 + 0.05 * k for k in range(7)], [0, 2, 4, 6]),
        ([0.0, 0.2, 0.4], [0, 1, 2]),  # slower than the film
        ([0.0, 0.85, 0.88, 0.91, 0.94, 0.97], [0, 1, 5]),  # after a gap no frames are made up
        ([100.0, 100.03, 0.0, 0.03, 0.1], [0, 2, 4]),  # the clock was reset
        ([100.0, 99.95, 100.1], [0, 2]),  # an old frame
    ],
)
def test_frames_come_at_the_films_rate(times, due):
    frames = FrameTimes(10.0)
    assert [index for index, time in enumerate(times) if frames.due(time)] == due


def test_the_node_logs_images_that_it_cannot_decode(tmp_path, monkeypatch):
    logged, hooks = [], []
    given = {"~path": str(tmp_path / "film.mp4"), "~rate": 10.0}
    monkeypatch.setattr(rospy, "get_param", lambda name, default: given.get(name, default))
    monkeypatch.setattr(rospy, "on_shutdown", hooks.append)
    monkeypatch.setattr(rospy, "Subscriber", lambda *arguments: None)
    monkeypatch.setattr(rospy, "logerr_throttle", lambda _, text: logged.append(text))
    node = FilmNode()
    for second, encoding in enumerate(("bgr8", "nonsense", "bgr8")):
        stamp, data = rospy.Time(second + 1), bytes(48 * 64 * 3)
        message = Image(height=48, width=64, encoding=encoding, step=192, data=data)
        message.header.stamp = stamp
        node.add(message)
    hooks[0]()
    assert len(logged) == 1 and "nonsense" in logged[0]
    with av.open(given["~path"]) as container:
        assert len(list(container.decode(video=0))) == 2
