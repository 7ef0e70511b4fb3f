"""Opens the page in a browser window of this machine. No ROS.

The address is a key to the simulation, and command lines are there for every user of a machine to
see. So the browser gets a file that only this user can read, and that leads to the address.
"""

from __future__ import annotations

import contextlib
import html
import os
import tempfile
import webbrowser
from collections.abc import Mapping

NAMES = ("DISPLAY", "WAYLAND_DISPLAY")
TEXT = (webbrowser.GenericBrowser, webbrowser.Elinks)  # Python's classes of lynx, w3m, links ...
REDIRECT = """<!doctype html><meta charset="utf-8"><meta name="referrer" content="no-referrer">
<title>Paddock</title><meta http-equiv="refresh" content="0; url={address}">
<a href="{address}">Open the page</a>
"""


class NoWindow(Exception):
    """No window can be opened; the text says why."""


def find_browser(environment: Mapping[str, str] = os.environ) -> webbrowser.BaseBrowser:
    """The browser of this machine: that of $BROWSER, or the desktop's.

    Raises:
        NoWindow: there is no display, or no browser that has a window.
    """
    if not any(environment.get(name) for name in NAMES):
        raise NoWindow(f"there is no display (neither {' nor '.join(NAMES)} is set)")
    try:
        browser = webbrowser.get()
    except webbrowser.Error:
        raise NoWindow("there is no browser") from None
    if type(browser) in TEXT and not environment.get("BROWSER"):
        raise NoWindow(f"{browser.name} has no window")
    return browser


class Redirect:
    """A file that leads a browser to an address, for this user alone.

    Args:
        folder: where it is made; it is made, too, if it is not there.
    """

    def __init__(self, address: str, folder: str) -> None:
        os.makedirs(folder, exist_ok=True)
        descriptor, self.path = tempfile.mkstemp(".html", "page-", folder)  # mode 0600
        with open(descriptor, "w", encoding="utf-8") as stream:
            stream.write(REDIRECT.format(address=html.escape(address)))

    def remove(self) -> None:
        """Remove the file."""
        with contextlib.suppress(FileNotFoundError):
            os.remove(self.path)


def show(path: str) -> None:
    """Open a file in a browser window; may last as long as the window.

    Raises:
        NoWindow: there is no display, no browser, or it fails.
    """
    browser = find_browser()
    if not browser.open(f"file://{os.path.abspath(path)}"):
        raise NoWindow(f"{getattr(browser, 'name', 'the browser')} cannot open it")
