"""The first process of a bare machine: mounts what a Debian needs, runs one program, waits.

Usage: python3 -I -S inside.py FD, where FD is the end of a pipe to read from: first comes a line of
JSON that says what to do, then nothing; its end is the end of ./run, and of this.
"""

import json
import os
import signal
import subprocess
import sys
import threading

NODES = ("full", "null", "random", "tty", "urandom", "zero")
STANDARD = ("stdin", "stdout", "stderr")
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # ./run starts this with them blocked
CANNOT = 125  # exit status, as chroot(1) has it

ending = threading.Lock()  # held by who ends this process


def main(lifeline):
    """Runs the program.

    Args:
        lifeline: File descriptor of the pipe.

    Returns:
        The program's exit status, as a shell gives it.
    """
    task = json.loads(_line(lifeline))
    ready, start = os.pipe()
    child = os.fork()  # before there are threads
    if child == 0:
        os.close(start)
        if not os.read(ready, 1):
            os._exit(CANNOT)  # this process has ended
        _become(task)
    os.close(ready)
    threading.Thread(target=_end_with, args=(lifeline, task), daemon=True).start()
    if task["root"] is not None:
        furnish(task["root"], task["binds"])
    if signal.sigpending():
        return 128 + min(signal.sigpending())
    os.write(start, b"\n")
    for number in signal.sigpending():  # came before there was a child to get it
        os.kill(child, number)
    status = None
    while status is None:
        ended, how = os.wait()  # orphans come here, too
        if ended == child:
            status = os.WEXITSTATUS(how) if os.WIFEXITED(how) else -os.WTERMSIG(how)
    ending.acquire()
    return status if status >= 0 else 128 - status


def furnish(root, binds):
    """Mounts /proc, /sys, a /dev of its own, and folders of this machine.

    Args:
        binds: List of (folder here, path there, whether it can be written to).
    """
    _mount("--bind", root, root)  # unshare(1) wants / to be a mount, should it be called there
    _mount("-t", "proc", "proc", f"{root}/proc")
    _mount("-t", "sysfs", "-o", "ro", "sysfs", f"{root}/sys")
    if os.path.isdir("/sys/fs/cgroup") and os.listdir("/sys/fs/cgroup"):
        # limits of processors and memory count there, too
        _mount("--bind", "-o", "ro", "/sys/fs/cgroup", f"{root}/sys/fs/cgroup")
    _mount("-t", "tmpfs", "-o", "mode=755", "tmpfs", f"{root}/dev")
    for name in NODES:
        if os.path.exists(f"/dev/{name}"):
            with open(f"{root}/dev/{name}", "w"):
                pass
            _mount("--bind", f"/dev/{name}", f"{root}/dev/{name}")
    for name, kind, options in (
        ("pts", "devpts", "newinstance,ptmxmode=0666,mode=620"),
        ("shm", "tmpfs", "mode=1777"),
    ):
        os.mkdir(f"{root}/dev/{name}")
        _mount("-t", kind, "-o", options, kind, f"{root}/dev/{name}")
    os.symlink("pts/ptmx", f"{root}/dev/ptmx")
    os.symlink("/proc/self/fd", f"{root}/dev/fd")
    for number, name in enumerate(STANDARD):
        os.symlink(f"/proc/self/fd/{number}", f"{root}/dev/{name}")
    for here, there, writable in binds:
        os.makedirs(root + there, exist_ok=True)
        _mount("--bind", *([] if writable else ["-o", "ro"]), here, root + there)


def _mount(*words):
    subprocess.run(["mount", *words], check=True)


def _line(lifeline):
    text = b""
    while not text.endswith(b"\n"):
        some = os.read(lifeline, 65536)
        if not some:
            os._exit(CANNOT)  # ./run has ended already
        text += some
    return text


def _end_with(lifeline, task):
    """Waits for the end of ./run, and ends everything."""
    while os.read(lifeline, 1):
        pass
    ending.acquire()
    if not task["isolated"]:
        sys.path.insert(0, task["clone"])
        from commands.bare.removal import remove

        remove(task["folder"])
    os._exit(CANNOT)  # in a PID namespace the kernel kills all the others


def _become(task):
    """Turns the child into the program; does not come back."""
    try:
        os.closerange(3, 256)
        for number in (*SIGNALS, signal.SIGPIPE):
            signal.signal(number, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
        if task["root"] is not None:
            os.chroot(task["root"])
        os.chdir(task["directory"])
        os.umask(0o022)
        os.execvpe(task["argv"][0], task["argv"], task["environ"])
    except OSError as error:
        print(f"run: cannot run {task['argv'][0]!r}: {error.strerror}", file=sys.stderr, flush=True)
        os._exit(127 if isinstance(error, FileNotFoundError) else 126)


if __name__ == "__main__":
    try:
        ended = main(int(sys.argv[1]))
    except (OSError, subprocess.CalledProcessError) as problem:
        print(f"run: the bare machine cannot be started: {problem}", file=sys.stderr, flush=True)
        ended = CANNOT
    os._exit(ended)
