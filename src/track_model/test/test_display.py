"""The lane's marker for rviz."""

import numpy as np
import pytest
from shapely.geometry import Polygon
from test_referee import circle
from track_model.referee.node import lane_marker

from track_model import geometry, track_file


def area(marker):
    """Area of a marker's triangles [m^2]; all have the same orientation."""
    corners = np.array([(p.x, p.y) for p in marker.points]).reshape(-1, 3, 2)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2.0
    assert (areas > 0).all()
    return areas.sum()


@pytest.mark.parametrize(
    "text, closed",
    [
        (circle(), True),
        (
            track_file.parse(
                "points: [[0, 0], [1, 0], [2, 1], [3, 1]]\nclosed: false\n", "open.yaml"
            ),
            False,
        ),
    ],
)
def test_the_lane_marker_covers_the_lane(text, closed):
    lane = geometry.lane(text)
    assert lane.closed == closed
    marker = lane_marker(lane, "odom")
    left, right = lane.edge(1), lane.edge(-1)
    expected = (
        Polygon(right).area - Polygon(left).area
        if closed
        else Polygon(np.vstack([left, right[::-1]])).area
    )
    assert area(marker) == pytest.approx(expected, rel=1e-6)
    assert marker.header.frame_id == "odom" and marker.color.a == 1.0
