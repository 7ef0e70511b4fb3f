#!/usr/bin/env python3
"""Save one image of each camera of features.world, which runs in Gazebo or in Paddock.

    python3 record.py FILE.npz        needs rospy and numpy alone

The file has NAME (H, W, 3) uint8 for each camera, NAME_depth (H, W) float32 [m], NAME_points
(H, W, 3) float32 [m], NAME_colors (H, W, 3) uint8, the first three bytes of the points' color.
"""

import sys
import threading

import numpy as np
import rospy
from sensor_msgs.msg import Image, PointCloud2

SKIPPED = 3  # images before the one that is kept: shaders and textures are loaded with the first
TIMEOUT = 120.0  # [s]


class Recorder:
    """Subscribes to all images and point clouds there are."""

    def __init__(self):
        self.arrays, self._counts = {}, {}
        self._missing, self._done = set(), threading.Event()
        self._subscribers = []

    def run(self, topics):
        """Wait until each of them has sent.

        Args:
            topics: name -> type.

        Returns:
            Names of those that have not.
        """
        self._missing = set(topics)
        for name, message in topics.items():
            self._subscribers.append(
                rospy.Subscriber(name, message, self._on_message, name, queue_size=1)
            )
        self._done.wait(TIMEOUT)
        return sorted(self._missing)

    def _on_message(self, message, name):
        self._counts[name] = self._counts.get(name, 0) + 1
        if self._counts[name] <= SKIPPED or name not in self._missing:
            return
        place = name.split("/")[1]
        if isinstance(message, PointCloud2):
            shape = message.height, message.width, message.point_step
            data = np.frombuffer(message.data, np.uint8).reshape(shape)
            points = np.ascontiguousarray(data[:, :, :12]).view(np.float32)
            self.arrays[f"{place}_points"] = points
            self.arrays[f"{place}_colors"] = data[:, :, 16:19].copy()
        elif message.encoding == "32FC1":
            values = np.frombuffer(message.data, np.float32)
            self.arrays[f"{place}_depth"] = values.reshape(message.height, message.width)
        else:
            pixels = np.frombuffer(message.data, np.uint8)
            self.arrays[place] = pixels.reshape(message.height, message.width, 3)
        self._missing.discard(name)
        if not self._missing:
            self._done.set()


def main(path):
    """Record; returns the exit code."""
    rospy.init_node("record_images", anonymous=True, disable_signals=True)
    kinds = {"sensor_msgs/Image": Image, "sensor_msgs/PointCloud2": PointCloud2}
    topics = {}
    for _ in range(120):
        threading.Event().wait(0.5)
        before, found = set(topics), dict(rospy.get_published_topics())
        topics = {
            name: kinds[kind]
            for name, kind in found.items()
            if kind in kinds and not name.endswith(("/normals", "/reflectance"))
        }
        if topics and set(topics) == before:
            break
    recorder = Recorder()
    missing = recorder.run(topics)
    np.savez_compressed(path, **recorder.arrays)
    print(f"{path}: {len(recorder.arrays)} arrays; nothing came of: {', '.join(missing) or '-'}")
    return 1 if missing or not topics else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
