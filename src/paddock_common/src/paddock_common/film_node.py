"""The node `film`: writes the images of a topic to a video file until it stops."""

from dataclasses import dataclass

import rospy
from cv_bridge import CvBridge, CvBridgeError
from sensor_msgs.msg import Image

from paddock_common.films import FilmWriter, FrameTimes
from paddock_common.nodes import run
from paddock_common.settings import Checked, number, read, text


@dataclass(frozen=True)
class FilmSettings(Checked):
    """Private parameters.

    Attributes:
        rate: Frames per second of the film; images that arrive faster in ROS time are skipped.
    """

    path: str = text("film.mp4")
    rate: float = number(15.0, above=0.0, unit="Hz")


class FilmNode:
    """Records the topic `image`."""

    def __init__(self) -> None:
        settings = read(FilmSettings, rospy.get_param)
        self._film = FilmWriter(settings.path, settings.rate)
        self._times = FrameTimes(settings.rate)
        self._bridge = CvBridge()
        rospy.on_shutdown(self._film.close)
        self._subscriber = rospy.Subscriber("image", Image, self.add)

    def add(self, message: Image) -> None:
        """Adds an image if it is due."""
        if not self._times.due(message.header.stamp.to_sec()):
            return
        try:
            self._film.add(self._bridge.imgmsg_to_cv2(message, "bgr8"))
        except (CvBridgeError, OSError) as error:
            rospy.logerr_throttle(10.0, f"film: {error}")


def main() -> None:
    run("film", FilmNode)
