"""What nodes import first that start beside the simulator, as their other imports take long.

Until rospy has handlers of its own a Ctrl-C ends the process: imports swallow KeyboardInterrupt.
The simulator, which starts at the same time, goes first. What is imported is not garbage, until
done() is called.
"""

import gc
import signal

signal.signal(signal.SIGINT, signal.SIG_DFL)
gc.disable()

from paddock_common import process  # noqa: E402

process.lower_priority()
done = gc.enable
