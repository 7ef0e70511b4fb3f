"""A small parent process that restores the terminal after its teleop has exited.

A teleop that is killed with SIGKILL cannot clean up. So the process that the shell starts becomes
this supervisor. It starts the teleop, waits for it, restores the terminal and, if the teleop was
killed, publishes the zero. If the supervisor is killed, the teleop gets a SIGTERM.
"""

import json
import os
import signal
import subprocess
import sys
import termios
import time

from paddock_common.process import signal_at_exit_of

COMMAND = "CYBERTRUCK_TELEOP_COMMAND"  # environment: the teleop's command line, as JSON
SUPERVISOR_PID = "CYBERTRUCK_TELEOP_SUPERVISOR"  # environment: the supervisor's process id
# leave the alternate screen, normal cursor keys and keypad, plain characters, visible cursor
SANE = b"\x1b[?1049l\x1b[?1l\x1b>\x1b[0m\x1b[?25h\r\n"
LONGEST = 2.0  # wait for a subscriber before the zero is published [s]
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)  # stop a teleop cleanly


def enter():
    """Becomes the supervisor or, in the teleop, requests a SIGTERM for when the supervisor exits.

    Without a terminal it does nothing.
    """
    supervisor = os.environ.pop(SUPERVISOR_PID, None)
    if supervisor is not None:
        if not signal_at_exit_of(int(supervisor)):
            sys.exit(1)
        return
    if not sys.stdin.isatty():
        return
    os.environ[COMMAND] = json.dumps([sys.executable, *sys.argv])
    os.execv(sys.executable, [sys.executable, "-m", __name__])


def send_zero(arguments):
    """Publishes one zero Twist instead of the killed teleop.

    Args:
        arguments: Its command line, for remappings.
    """
    import rosgraph

    if not rosgraph.is_master_online():
        return
    import rospy
    from geometry_msgs.msg import Twist
    from paddock_common.waiting import flush

    from paddock_common import nodes

    remappings = [item for item in arguments if ":=" in item and not item.startswith("__name")]
    nodes.init_node(
        "teleop_guard", argv=["supervisor", *remappings], anonymous=True, disable_signals=True
    )
    publisher = rospy.Publisher("cmd_vel", Twist, queue_size=1)
    deadline = time.monotonic() + LONGEST
    while publisher.get_num_connections() == 0 and time.monotonic() < deadline:
        time.sleep(0.01)
    publisher.publish(Twist())
    flush(publisher)
    rospy.signal_shutdown("zero sent")


def restore(terminal, settings):
    """Restores the terminal.

    Args:
        settings: Result of termios.tcgetattr.
    """
    previous = signal.signal(signal.SIGTTOU, signal.SIG_IGN)  # also from the background
    try:
        termios.tcsetattr(terminal, termios.TCSADRAIN, settings)
        os.write(terminal, SANE)
    except (OSError, termios.error):  # the terminal was closed
        pass
    signal.signal(signal.SIGTTOU, previous)


def main():
    """Starts the command of the environment, waits, cleans up.

    Returns:
        Exit status; 128 + number of the signal that killed the command.
    """
    command = json.loads(os.environ.pop(COMMAND))
    terminal = os.dup(sys.stdin.fileno())
    settings = termios.tcgetattr(terminal)
    child = None
    early = []  # signals received before the child was started

    def forward(signal_number, _frame):
        if child is None:
            early.append(signal_number)
        elif child.returncode is None:
            child.send_signal(signal_number)

    for signal_number in SIGNALS:
        signal.signal(signal_number, forward)
    signal.signal(signal.SIGTSTP, signal.SIG_IGN)
    child = subprocess.Popen(command, env=dict(os.environ, **{SUPERVISOR_PID: str(os.getpid())}))
    for signal_number in early:
        child.send_signal(signal_number)
    status = child.wait()
    if status in (0, 1) or status >= 128:
        return status
    restore(terminal, settings)
    if status < 0 and -status not in SIGNALS:
        print(f"the teleop was killed by {signal.Signals(-status).name}", file=sys.stderr)
        send_zero(command)
    return 128 - status if status < 0 else status


if __name__ == "__main__":
    sys.exit(main())
