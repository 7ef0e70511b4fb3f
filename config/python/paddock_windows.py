"""cv2's windows: from any thread where there is a screen, as topics where there is none.

Debian's cv2 makes windows by Qt, which blocks for ever where one thread makes a window and another
shows a picture in it, as nodes do with a trackbar and a callback. Here all calls are made in one
thread. Without a screen windows are kept as data: trackbars keep their values, keys never come, and
a window's picture is the image topic ~windows/NAME of the node, sent while somebody subscribes.
"""

import functools
import queue
import re
import sys
import threading
import time

CALLS = (
    *("namedWindow", "imshow", "pollKey", "destroyWindow", "destroyAllWindows", "createTrackbar"),
    *("getTrackbarPos", "setTrackbarPos", "setTrackbarMin", "setTrackbarMax", "setMouseCallback"),
    *("moveWindow", "resizeWindow", "setWindowTitle", "setWindowProperty", "getWindowProperty"),
    *("getWindowImageRect", "startWindowThread", "displayOverlay", "displayStatusBar"),
    *("createButton", "selectROI", "selectROIs"),
)
SLICE = 0.01  # for which waitKey keeps the windows to itself [s]


def install(cv2, has_screen):
    """Replaces the functions of windows.

    Args:
        cv2: The module.
        has_screen: Whether windows can be shown.
    """
    windows = InOneThread(cv2) if has_screen else Kept(cv2)
    for name in (*CALLS, "waitKey", "waitKeyEx"):
        if hasattr(cv2, name):
            setattr(cv2, name, getattr(windows, name))


class InOneThread:
    """Makes all calls in a thread of its own; in the caller's where the program has a Qt window."""

    def __init__(self, cv2):
        self._calls, self._thread, self._lock = queue.Queue(), None, threading.Lock()
        for name in CALLS:
            if hasattr(cv2, name):
                real = getattr(cv2, name)
                setattr(self, name, functools.wraps(real)(functools.partial(self._call, real)))
        self._wait = {name: getattr(cv2, name) for name in ("waitKey", "waitKeyEx")}

    def waitKey(self, delay=0):
        """As cv2's; other threads show their pictures meanwhile."""
        return self._wait_key(self._wait["waitKey"], delay)

    def waitKeyEx(self, delay=0):
        """As cv2's; other threads show their pictures meanwhile."""
        return self._wait_key(self._wait["waitKeyEx"], delay)

    def _wait_key(self, real, delay):
        end = time.monotonic() + 1e-3 * delay if delay > 0 else float("inf")
        while True:
            left = end - time.monotonic()
            key = self._call(real, max(1, round(1e3 * min(left, SLICE))))
            if key != -1 or left <= SLICE or is_over():
                return key

    def _call(self, real, *arguments, **named):
        if threading.current_thread() is self._thread or has_qt():
            return real(*arguments, **named)
        with self._lock:
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="cv2", daemon=True)
                self._thread.start()
        done, answer = threading.Event(), []
        self._calls.put((functools.partial(real, *arguments, **named), answer, done))
        done.wait()
        result, error = answer
        if error is not None:
            raise error
        return result

    def _run(self):
        while True:
            call, answer, done = self._calls.get()
            try:
                answer += [call(), None]
            except Exception as error:  # the caller's
                answer += [None, error]
            del call
            done.set()


def has_qt():
    """Whether the program has made windows of its own by Qt, in whose thread cv2's are then."""
    for name in ("PyQt5.QtWidgets", "PySide2.QtWidgets"):
        if name in sys.modules and sys.modules[name].QApplication.instance() is not None:
            return True
    return False


def node():
    """Rospy, where this process is a node that runs; else None."""
    rospy = sys.modules.get("rospy")
    core = getattr(rospy, "core", None)
    return rospy if core and core.is_initialized() and not core.is_shutdown() else None


def is_over():
    """Whether this process was a node and has been told to end."""
    rospy = sys.modules.get("rospy")
    return bool(rospy and hasattr(rospy, "core") and rospy.core.is_shutdown())


class Kept:
    """Windows without a screen; methods have the names and arguments of cv2's functions."""

    def __init__(self, cv2):
        self._cv2, self._windows, self._lock = cv2, {}, threading.RLock()

    def namedWindow(self, winname, flags=None):
        """Makes a window if there is none of the name."""
        self._window(winname)

    def imshow(self, winname, mat):
        """Shows a picture in a window, which is made if there is none."""
        mat = getattr(mat, "get", lambda: mat)()  # of a UMat
        if getattr(mat, "size", 0) == 0:
            raise self._cv2.error(f"imshow: window {winname!r} gets no picture, {mat!r}")
        self._window(winname).show(mat)

    def waitKey(self, delay=0):
        """Waits [ms], 0: until the node ends; no key comes."""
        end = time.monotonic() + 1e-3 * delay if delay > 0 else float("inf")
        while time.monotonic() < end and not is_over():
            time.sleep(max(0.0, min(end - time.monotonic(), 0.1)))
        return -1

    waitKeyEx = waitKey

    def pollKey(self):
        """No key comes."""
        return -1

    def destroyWindow(self, winname):
        """Forgets a window."""
        with self._lock:
            window = self._windows.pop(winname, None)
        if window is not None:
            window.close()

    def destroyAllWindows(self):
        """Forgets all windows."""
        for name in list(self._windows):
            self.destroyWindow(name)

    def createTrackbar(self, trackbarName, windowName, value, count, onChange=None):
        """Gives a window a value from 0 to `count`."""
        self._window(windowName).bars[trackbarName] = [int(value or 0), 0, count, onChange]

    def getTrackbarPos(self, trackbarname, winname):
        """The value; -1: there is no such trackbar."""
        return self._bar(trackbarname, winname)[0]

    def setTrackbarPos(self, trackbarname, winname, pos):
        """Sets the value, within its bounds."""
        bar = self._bar(trackbarname, winname)
        bar[0] = max(bar[1], min(bar[2], pos))
        if bar[3] is not None:
            bar[3](bar[0])

    def setTrackbarMin(self, trackbarname, winname, minval):
        """Sets the least value."""
        self._bar(trackbarname, winname)[1] = minval

    def setTrackbarMax(self, trackbarname, winname, maxval):
        """Sets the greatest value."""
        self._bar(trackbarname, winname)[2] = maxval

    def getWindowProperty(self, winname, prop_id):
        """Whether a window is there, of WND_PROP_VISIBLE; of others -1."""
        visible = prop_id == self._cv2.WND_PROP_VISIBLE
        return float(winname in self._windows) if visible else -1.0

    def getWindowImageRect(self, winname):
        """(0, 0, width, height) of what a window shows."""
        picture = self._window(winname).picture
        height, width = (0, 0) if picture is None else picture.shape[:2]
        return 0, 0, width, height

    def selectROI(self, *arguments, **named):
        """Nobody selects anything."""
        return 0, 0, 0, 0

    def selectROIs(self, *arguments, **named):
        """Nobody selects anything."""
        return ()

    def _nothing(self, *arguments, **named):
        """There is nothing to move, title or press."""

    moveWindow = resizeWindow = setWindowTitle = setWindowProperty = startWindowThread = _nothing
    setMouseCallback = displayOverlay = displayStatusBar = createButton = _nothing

    def _window(self, name):
        with self._lock:
            if name not in self._windows:
                self._windows[name] = Window(name)
            return self._windows[name]

    def _bar(self, name, window):
        found = self._windows.get(window)
        return found.bars.get(name, [-1, -1, -1, None]) if found else [-1, -1, -1, None]


class Window:
    """A window without a screen.

    Attributes:
        picture: What it shows, as imshow() got it, or None.
        bars: Name of a trackbar -> [value, least, greatest, callback].
    """

    def __init__(self, name):
        self.picture, self.bars = None, {}
        self._topic = "~windows/" + (re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_") or "window")
        self._name, self._publisher, self._lock = name, None, threading.Lock()

    def show(self, picture):
        """Shows (H, W) or (H, W, 1, 3 or 4): to those who have subscribed to its topic."""
        self.picture = picture
        rospy = node()
        if rospy is None:
            return
        with self._lock:
            if self._publisher is None:
                from sensor_msgs.msg import Image

                self._publisher = rospy.Publisher(
                    self._topic, Image, subscriber_listener=_Last(self), queue_size=1
                )
        if self._publisher.get_num_connections():
            self._publisher.publish(self.message())

    def message(self):
        """The picture as sensor_msgs/Image, in the colors in which cv2 would show it."""
        import numpy
        import rospy
        from sensor_msgs.msg import Image

        pixels = numpy.asarray(self.picture)
        if pixels.dtype.kind == "f":
            pixels = numpy.clip(numpy.nan_to_num(pixels) * 255.0, 0.0, 255.0)
        elif pixels.dtype in (numpy.uint16, numpy.int16):
            pixels = pixels // 256 + (128 if pixels.dtype == numpy.int16 else 0)
        elif pixels.dtype == numpy.int8:
            pixels = pixels.astype(int) + 128
        pixels = numpy.ascontiguousarray(pixels, numpy.uint8)
        channels = pixels.shape[2] if pixels.ndim == 3 else 1
        message = Image(height=pixels.shape[0], width=pixels.shape[1])
        message.header.stamp, message.header.frame_id = rospy.Time.now(), self._name
        message.encoding = {1: "mono8", 3: "bgr8", 4: "bgra8"}[channels]
        message.step, message.data = pixels.shape[1] * channels, pixels.tobytes()
        return message

    def close(self):
        """Withdraws its topic."""
        with self._lock:
            if self._publisher is not None:
                self._publisher.unregister()


class _Last:
    """Sends a new subscriber what the window shows: it may be the last picture."""

    def __init__(self, window):
        self._window = window

    def peer_subscribe(self, _topic, _publish, publish_to_it):
        publish_to_it(self._window.message())

    def peer_unsubscribe(self, _topic, _subscribers):
        pass
