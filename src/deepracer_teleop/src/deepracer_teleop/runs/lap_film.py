"""The film of a lap: the camera's frames while it is driven, with the referee's figures."""

import rospy
from cv_bridge import CvBridge, CvBridgeError

MOST_PROGRESS = 55.0  # [%] of the lap, up to which a frame may be the picture of the lap


class LapFilm:
    """Adds camera frames to a Film, in the subscriber's thread.

    Args:
        film: Film.
        judge: Judge.
        driver: its name.

    Attributes:
        film: as above.
        seeing: whether a frame has come.
        filming: whether frames are added; False at first.
        frame: (H, W, 3) uint8 BGR, the picture of the lap, or None.
    """

    def __init__(self, film, judge, driver):
        self.film, self._judge, self._driver = film, judge, driver
        self._bridge, self.frame = CvBridge(), None
        self.seeing = self.filming = False

    def callback(self, message):
        """Adds a camera frame."""
        self.seeing = True
        status = self._judge.status
        if not self.filming or status is None:
            return
        words = (
            f"{self._driver}  lap {status.laps + 1}  {status.progress:3.0f} %  "
            f"{status.lap_time:5.1f} s  {status.speed:.2f} m/s"
        )
        try:
            picture = self._bridge.imgmsg_to_cv2(message, "bgr8")
            frame = self.film.add(message.header.stamp.to_sec(), picture, words)
        except (CvBridgeError, OSError) as error:
            rospy.logerr_throttle(10.0, f"film: {error}")
            return
        if frame is not None and (self.frame is None or status.progress < MOST_PROGRESS):
            self.frame = frame
