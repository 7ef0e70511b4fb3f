"""The window manager of the desk: i3 gives windows the screen side by side; dialogs float."""

import os

from commands.desk.screen import spawn

# Not one key or button is bound: keys belong to the windows, and nothing here starts a program.
CONFIG = """\
# i3 config file (v4)
font pango:DejaVu Sans 9
ipc-socket {folder}/windows
default_orientation horizontal
default_border normal
focus_follows_mouse no
focus_on_window_activation focus
"""


def start(folder, environ):
    """Starts it.

    Args:
        folder: Private folder for its files.
        environ: With the screen's DISPLAY and XAUTHORITY.

    Returns:
        subprocess.Popen.
    """
    config = os.path.join(folder, "windows.conf")
    with open(config, "w", encoding="utf-8") as stream:
        stream.write(CONFIG.format(folder=folder))
    with open(os.path.join(folder, "windows.log"), "wb") as log:
        return spawn(["i3", "-c", config], env=environ, stdout=log, stderr=log)
