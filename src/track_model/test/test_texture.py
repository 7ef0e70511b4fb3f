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
