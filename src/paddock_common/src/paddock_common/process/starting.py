"""The start of a node without what delays it, and with what mends rospy for its life."""

import ctypes
import time
from types import SimpleNamespace

import rospy
import rospy.impl.init

from paddock_common.process import closing, serving, subscriptions

LOOK = 0.003  # [s] between two looks whether the master has registered the node
LARGEST_KEPT = 32 << 20  # [bytes] the most that glibc takes
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of malloc.h


def init_node(name, **options):
    """Calls rospy.init_node, which looks for its registration every 0.1 s: here it does so sooner.

    Every node of Paddock starts here: its subscriptions keep their publishers, and it ends without
    a word and without taking a processor.

    Args:
        name: Of the node.
        options: rospy.init_node's.
    """
    serving.end_with_node()
    closing.end_silently()
    subscriptions.keep()
    keep_freed_memory()
    clock = rospy.impl.init.time
    rospy.impl.init.time = SimpleNamespace(sleep=lambda seconds: time.sleep(min(seconds, LOOK)))
    try:
        rospy.init_node(name, **options)
    finally:
        rospy.impl.init.time = clock


def keep_freed_memory():
    """Has glibc keep what is freed for later, instead of giving each large block back.

    rospy receives every message into a block of 4 MB, and pictures are as large: each would be
    mapped and unmapped by the kernel, which doubles the processor time of a subscriber.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:  # glibc
        mallopt(M_MMAP_THRESHOLD, LARGEST_KEPT)
        mallopt(M_TRIM_THRESHOLD, 2 * LARGEST_KEPT)
