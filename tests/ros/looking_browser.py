#!/usr/bin/env python3
"""A browser for tests: follows the file that it is given to the page, and looks at it.

    looking_browser.py ADDRESS_OF_THE_FILE

$ROS_HOME/looking_browser.json then tells where it was led and what it saw: ten views.
"""

import json
import os
import re
import stat
import sys
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import urlopen

import websocket

VIEWS = 10
LIMIT = 120.0  # wall time for anything [s]


def main():
    """Look at the page, and tell."""
    path = Path(urlsplit(sys.argv[1]).path)
    mode = stat.S_IMODE(path.stat().st_mode)
    address = re.search(r'url=([^"]+)"', path.read_text()).group(1)
    origin = "/".join(address.split("/")[:3])
    with urlopen(address, timeout=LIMIT) as response:
        page = response.read().decode()
    connection = websocket.create_connection(
        address.replace("http:", "ws:") + "socket", timeout=LIMIT, origin=origin
    )
    views = 0
    while views < VIEWS:
        message = connection.recv()
        connection.send('{"type": "ack"}')
        views += isinstance(message, str) and json.loads(message)["type"] == "view"
    told = Path(os.environ["ROS_HOME"]) / "looking_browser.json"
    part = told.with_suffix(".part")
    part.write_text(
        json.dumps({"address": address, "file": str(path), "mode": mode, "page": page[:15]})
    )
    part.rename(told)
    connection.close()


if __name__ == "__main__":
    main()
