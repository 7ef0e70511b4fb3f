"""Properties of the ground texture that renderers depend on."""

import numpy as np
import pytest
from track_model.files import writer


@pytest.mark.parametrize("width", [3.0, 7.003, 9.861, 10.2, 25.0])
def test_columns_come_in_fours(width):
    """PyBullet's EGL renderer draws rows that are not aligned to four bytes as stripes."""
    area, (rows, columns) = writer.whole_pixels((0.0, width, -1.0, 1.111))
    assert columns % 4 == 0
    assert max(rows, columns) <= (writer.MAX_PIXELS if width < 16 else writer.LARGE_PIXELS)
    pixel = (area[1] - area[0]) / columns
    assert pixel == pytest.approx((area[3] - area[2]) / rows, rel=1e-9)
    assert pixel == pytest.approx(writer.resolution(area), rel=1e-9)
    assert area[1] >= width - 1e-9
    assert np.isfinite(area).all()


@pytest.mark.parametrize("slope", [0.0, 0.01, 0.03, -0.2, 1.0, 7.0])
def test_edges_have_no_steps(slope):
    """What is white of each column is what the edge leaves of it, of each row if it is steep."""
    area = (0.0, 2.0, 0.0, 1.0)
    image = np.zeros((200, 400, 3), np.uint8)
    steep = abs(slope) > 1.0
    along = np.array([-1.0, 3.0])
    across = 0.5 + (along - 0.5) / slope if steep else 0.5 + slope * (along - 1.0)
    edge = np.stack([across, along] if steep else [along, across], axis=1)
    behind = [[-9.0, 3.0], [-9.0, -1.0]] if steep else [[3.0, -9.0], [-1.0, -9.0]]
    writer._fill(image, [np.vstack([edge, behind])], area, (255, 255, 255))
    white = image[..., 0].sum(axis=1 if steep else 0) / 255.0
    at = (np.arange(len(white)) + 0.5) * 0.005
    at = 1.0 - at if steep else at
    wanted = np.interp(at, along, across) / 0.005
    inside = (wanted > 1) & (wanted < (399 if steep else 199))
    assert np.abs(white - wanted)[inside].max() < 1.5 / writer.FINE
