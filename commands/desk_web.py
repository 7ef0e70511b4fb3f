"""Run by Debian's Python: noVNC's page and a way to the screen, for those who know the token.

Usage: DESK_TOKEN=TOKEN python3 desk_web.py LISTENING_SOCKET VNC_SOCKET PAGE_FOLDER

Every address begins with the token: http://HOST:PORT/TOKEN/. Anything else gets a bare 403, pages
and WebSockets alike.
"""

import hmac
import os
import sys
from urllib.parse import urlencode

from websockify.websocketproxy import ProxyRequestHandler, WebSocketProxy

WEB_SOCKET = "websockify"  # the address below the token
PAGE = "vnc.html"
SETTINGS = {"autoconnect": "true", "resize": "scale", "reconnect": "true"}  # of noVNC


def handler_for(token):
    """Makes the class that answers requests.

    Args:
        token: What the first part of each address has to be.
    """

    class Handler(ProxyRequestHandler):
        """Takes the token off the address, then does what websockify does."""

        def parse_request(self):
            """Reads a request; without the token it ends here."""
            if not super().parse_request():
                return False
            given, _, self.path = self.path.lstrip("/").partition("/")
            if not hmac.compare_digest(given.encode(errors="replace"), token.encode()):
                self.close_connection = True
                self.send_error(403, "Wrong token", "./run desk prints the address.")
                return False
            self.path = f"/{self.path}"
            return True

        def handle_upgrade(self):
            """Goes on to the screen, at one address only."""
            if self.path != f"/{WEB_SOCKET}":
                self.send_error(404)
                return
            super().handle_upgrade()

        def do_GET(self):  # noqa: N802 - the library's name
            """Sends the page, or a file of it."""
            if self.path in ("/", ""):
                path = {"path": f"/{token}/{WEB_SOCKET}"}
                self.send_response(302)
                self.send_header("Location", f"/{token}/{PAGE}?{urlencode({**SETTINGS, **path})}")
                self.send_header("Content-Length", "0")
                self.end_headers()
                return
            super().do_GET()

        def end_headers(self):
            """Keeps the address, with the token in it, from other sites."""
            self.send_header("Referrer-Policy", "no-referrer")
            super().end_headers()

    return Handler


def main():
    """Serves until SIGTERM."""
    listening, vnc, folder = sys.argv[1:]
    token = os.environ.pop("DESK_TOKEN")
    server = WebSocketProxy(
        RequestHandlerClass=handler_for(token),
        listen_fd=int(listening),
        unix_target=vnc,
        web=folder,
        file_only=True,
    )
    server.start_server()


if __name__ == "__main__":
    main()
