"""The track as markers for rviz: its ground image and its walls, from its SDF."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import rospy
from paddock_common.geometry import pose_of
from paddock_common.nodes import run
from visualization_msgs.msg import Marker, MarkerArray

MESH, BOX = "geometry/mesh/uri", "geometry/box/size"


def track_markers(description: str, frame: str) -> MarkerArray:
    """Converts the visuals of a track's SDF.

    Args:
        description: SDF of a model whose origin is that of `frame`; visuals are meshes with
            embedded materials, or boxes with a pose in links without one.

    Raises:
        ValueError: The description is not XML, or has nothing visible.
    """
    try:
        visuals = ElementTree.fromstring(description).findall(".//visual")
    except ElementTree.ParseError as error:
        raise ValueError(f"track_description is not the SDF of a track: {error}") from None
    markers = MarkerArray()
    for visual in visuals:
        if (marker := _marker(visual)) is not None:
            marker.header.frame_id, marker.id = frame, len(markers.markers)
            markers.markers.append(marker)
    if not markers.markers:
        raise ValueError(
            f"track_description has {len(visuals)} visuals and no mesh or box among them"
        )
    return markers


def _marker(visual: ElementTree.Element) -> Marker | None:
    """Returns the Marker of a visual without header, or None if it is neither mesh nor box."""
    marker = Marker(action=Marker.ADD, ns="track", frame_locked=True)
    x, y, z, _roll, _pitch, yaw = _numbers(visual.findtext("pose"), (0.0,) * 6)
    marker.pose = pose_of(x, y, yaw, z)
    size: tuple[float, ...]
    color: tuple[float, ...]
    if uri := (visual.findtext(MESH) or "").strip():
        marker.type, marker.mesh_resource = Marker.MESH_RESOURCE, uri
        marker.mesh_use_embedded_materials = True
        size, color = (1.0,) * 3, (0.0,) * 4  # all 0: the mesh's colors
    elif box := visual.findtext(BOX):
        marker.type, size = Marker.CUBE, _numbers(box)
        color = _numbers(visual.findtext("material/diffuse"), (0.6, 0.6, 0.6, 1.0))
    else:
        return None
    marker.scale.x, marker.scale.y, marker.scale.z = size
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = color
    return marker


def _numbers(text: str | None, default: tuple[float, ...] = ()) -> tuple[float, ...]:
    """Returns the numbers of an element's text; `default` if there is no such element."""
    return default if text is None else tuple(map(float, text.split()))


class TrackMarkers:
    """Node: publishes the track of `track_description`, latched, as `~markers`.

    Raises:
        ValueError: `track_description` is missing or has no track.
    """

    def __init__(self) -> None:
        description = rospy.get_param("track_description", "")
        if not description:
            raise ValueError("track_description is not set; spawn_track.launch sets it")
        frame = rospy.get_param("~frame", "odom")
        self._publisher = rospy.Publisher("~markers", MarkerArray, queue_size=1, latch=True)
        self._publisher.publish(track_markers(description, frame))


def main() -> None:
    """Runs the node until ROS shuts down."""
    run("track_markers", TrackMarkers)
