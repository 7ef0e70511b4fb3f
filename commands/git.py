"""git, as ./run add runs it: nobody is asked, and its children hold the locks."""

import os
import subprocess

from commands.bootstrap import step
from commands.paths import ROOT

# In this clone, whoever owns it.
OURS = ("git", "--no-optional-locks", "-c", f"safe.directory={ROOT}", "-C", ROOT)


def git(folder, *words):
    """Runs git; GitHub's addresses for those who have a key become those for everybody.

    Returns:
        subprocess.CompletedProcess.
    """
    instead = [
        word
        for address in ("git@github.com:", "ssh://git@github.com/", "git://github.com/")
        for word in ("-c", f"url.https://github.com/.insteadOf={address}")
    ]
    return subprocess.run(
        ["git", *instead, *words],
        cwd=folder,
        env={**os.environ, "GIT_TERMINAL_PROMPT": "0", "LC_ALL": "C"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        pass_fds=step.held_locks(),
    )
