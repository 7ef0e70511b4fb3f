"""HTTP and WebSockets for pages; every request has to carry the token. No ROS.

Every address begins with the token: http://HOST:PORT/TOKEN/. Anything else gets a bare 403, files
and WebSockets alike. With a password (for --share) a page asks for it first and gets a cookie.

A page gets a message only after it has acknowledged earlier ones and the connection has taken them,
and of each kind only the newest: a browser that is slow or reads no more costs a few messages and
nothing else.
"""

from __future__ import annotations

import asyncio
import hmac
import logging
import secrets
import socket
import time
from collections import OrderedDict, deque
from collections.abc import Mapping
from typing import Any, Callable, NamedTuple, Optional, Protocol, Union
from urllib.parse import urlsplit

import tornado.httpserver
import tornado.netutil
import tornado.web
import tornado.websocket
from paddock_common.open_files import Listening

from bullet_web.messages import MAX_BYTES, BadMessage, json_of, parse

LOOPBACK, EVERYWHERE = "127.0.0.1", "0.0.0.0"
ELSEWHERE = ("192.0.2.1", 9)  # outside any network of one's own (RFC 5737)
PORTS = range(7080, 7280)  # the first free one is taken
WINDOW = 3  # messages that a page has not acknowledged, or its connection not taken yet
# Kinds of messages, the first go first; others go behind them as they come.
ORDER = (
    *("status", "scene", "waiting", "notice", "view", "contacts", "data", "frames"),
    *("points", "image"),
)
NOTICES = 20  # kept for a page
RATE = 200.0  # messages a page may send a second, and ...
BURST = 600.0  # ... at once; then it is closed
MAX_PAGES = 100
IDLE, BODY = 60.0, 10.0  # [s] for the headers of a request, and for its body
PING = 20.0  # [s] between two; a page that does not answer one is closed
COOKIE = "paddock"
SLOW = 1.0  # [s] that a wrong password takes
SECURITY = {
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
}
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' blob: data:; connect-src 'self' ws://{host} wss://{host}; "
    "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
LOGIN = """<!doctype html><meta name="viewport" content="width=device-width">
<title>Paddock</title><body style="font: 18px sans-serif; margin: 3em">
<form method="post"><label>Password <input name="password" type="password" autofocus></label>
<button>Open</button></form>"""
WRONG = LOGIN + "<p>That is not the password.</p>"


Write = Callable[[Union[str, bytes]], Optional["asyncio.Future[Any]"]]


class File(NamedTuple):
    """A file that pages load."""

    type: str
    data: bytes


class Content(Protocol):
    """What the server shows; called in its thread."""

    @property
    def files(self) -> Mapping[str, File]:
        """Files that pages load, by the name below the token."""

    def scene(self, number: int) -> bytes | None:
        """JSON of a scene; None: it is not the present one."""

    def asset(self, name: str) -> File | None:
        """A mesh or an image of the present scene."""

    def opened(self, page: Page) -> None:
        """A page has come."""

    def received(self, page: Page, message: dict[str, Any]) -> None:
        """A checked message of a page, but no acknowledgement."""

    def closed(self, page: Page) -> None:
        """A page has gone."""


class Page:
    """One browser that looks.

    Args:
        number: of the page, from 1.
        write: sends a message; its future is done when the connection has taken it.
        now: wall time [s].

    Attributes:
        wanted: fields of its last message "want".
        refused: how many of its messages were refused.
    """

    def __init__(
        self,
        number: int,
        write: Write,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.number = number
        self.wanted: dict[str, Any] = {}
        self.refused = 0
        self._write, self._now = write, now
        self._slots: OrderedDict[str, str | bytes] = OrderedDict()
        self._notices: deque[str] = deque(maxlen=NOTICES)
        self._in_flight = 0  # not acknowledged
        self._unwritten = 0  # not taken by the connection: who does not read may acknowledge
        self._budget, self._counted = BURST, now()

    def put(self, kind: str, message: str | bytes) -> None:
        """Send a message as soon as the page takes it; a newer one of its kind replaces it."""
        self._slots[kind] = message
        self._pump()

    def notify(self, text: str, good: bool = False) -> None:
        """Tell its user something."""
        self._notices.append(json_of({"type": "notice", "text": text, "good": good}))
        self._pump()

    def acknowledged(self) -> None:
        """The page has taken a message."""
        self._in_flight = max(0, self._in_flight - 1)
        self._pump()

    def waits(self, kind: str) -> bool:
        """Whether a message of that kind is still to be sent: another would replace it."""
        return kind in self._slots

    def may_send(self) -> bool:
        """Count a message of the page; whether they are not too many."""
        now = self._now()
        self._budget = min(BURST, self._budget + RATE * (now - self._counted)) - 1.0
        self._counted = now
        return self._budget >= 0.0

    def _pump(self) -> None:
        while max(self._in_flight, self._unwritten) < WINDOW:
            message = self._next()
            if message is None:
                return
            self._in_flight += 1
            written = self._write(message)
            if written is not None:
                self._unwritten += 1
                written.add_done_callback(self._written)

    def _written(self, future: asyncio.Future[Any]) -> None:
        future.cancelled() or future.exception()  # else a closed connection is logged as an error
        self._unwritten -= 1
        self._pump()

    def _next(self) -> str | bytes | None:
        for kind in ORDER:
            if kind == "notice" and self._notices:
                return self._notices.popleft()
            if kind in self._slots:
                return self._slots.pop(kind)
        return self._slots.popitem(last=False)[1] if self._slots else None


class Guarded(tornado.web.RequestHandler):
    """Answers those who know the token, and the password where there is one."""

    server: Server

    def initialize(self, server: Server) -> None:
        self.server = server

    def prepare(self) -> None:
        given = self.request.path.lstrip("/").partition("/")[0]
        if not hmac.compare_digest(given.encode(errors="replace"), self.server.token.encode()):
            raise tornado.web.HTTPError(403)
        if not self.server.knows(self.get_cookie(COOKIE)):
            self.let_in()

    def let_in(self) -> None:
        """Refuse who has not given the password."""
        raise tornado.web.HTTPError(403)

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        for name, value in SECURITY.items():
            self.set_header(name, value)

    def write_error(self, status_code: int, **_: Any) -> None:
        self.finish()


class Index(Guarded):
    """The page itself, or the question for the password."""

    def let_in(self) -> None:
        if self.request.method not in ("GET", "POST"):
            raise tornado.web.HTTPError(403)

    def get(self, _token: str) -> None:
        if not self.server.knows(self.get_cookie(COOKIE)):
            self.finish(LOGIN)
            return
        host = self.request.host
        if not host.isascii() or any(sign in host for sign in " ;,'\"\\"):
            raise tornado.web.HTTPError(400)
        self.set_header("Content-Security-Policy", POLICY.format(host=host))
        self.set_header("Cache-Control", "no-store")
        self.finish(self.server.content.files["index.html"].data)

    async def post(self, token: str) -> None:
        if not self.server.password:
            raise tornado.web.HTTPError(405)
        async with self.server.guessing:  # one guess after the other
            if not self.server.is_password(self.get_body_argument("password", "") or ""):
                await asyncio.sleep(SLOW)
                self.set_status(403)
                self.finish(WRONG)
                return
        self.set_cookie(
            COOKIE, self.server.key, path=f"/{token}/", httponly=True, samesite="Strict"
        )
        self.redirect(f"/{token}/", status=303)


class Files(Guarded):
    """Scripts, scenes, meshes and images."""

    def get(self, _token: str, name: str) -> None:
        folder, _, rest = name.partition("/")
        file, cached = self.server.content.files.get(name), False
        if folder == "asset" and file is None:
            file, cached = self.server.content.asset(rest), True
        elif folder == "scene" and rest.isdecimal() and len(rest) < 10:
            data = self.server.content.scene(int(rest))
            file = None if data is None else File("application/json", data)
        if file is None:
            raise tornado.web.HTTPError(404)
        self.set_header("Content-Type", file.type)
        age = "private, max-age=86400, immutable" if cached else "no-cache"
        self.set_header("Cache-Control", age)
        self.finish(file.data)


class Socket(Guarded, tornado.websocket.WebSocketHandler):
    """The WebSocket of a page."""

    page: Page | None = None

    def check_origin(self, origin: str) -> bool:
        """Pages of other sites do not get in."""
        return urlsplit(origin).netloc.lower() == self.request.headers.get("Host", "").lower()

    def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        self.page = self.server.add(self._send)
        if self.page is None:
            self.close(1008, f"{MAX_PAGES} pages are open")

    def _send(self, message: str | bytes) -> asyncio.Future[Any] | None:
        try:
            return self.write_message(message, binary=isinstance(message, bytes))
        except tornado.websocket.WebSocketClosedError:
            return None  # on_close follows

    def on_message(self, message: str | bytes) -> None:
        if self._may_send() and self.page is not None:
            self.server.received(self.page, message)

    def on_ping(self, data: bytes) -> None:
        """A ping has been answered; it counts as a message."""
        self._may_send()

    def _may_send(self) -> bool:
        if self.page is None or self.page.may_send():
            return True
        stream = self.ws_connection and self.ws_connection.stream
        self.close(1008, "too many messages")
        if stream:
            stream.close()  # of which tornado reads for 5 s more
        return False

    def on_close(self) -> None:
        page, self.page = self.page, None
        if page is not None:
            self.server.remove(page)


def listen(port: int, share: bool) -> socket.socket:
    """Open the port on which browsers come in.

    Args:
        port: its number; 0: the first free one of PORTS.
        share: whether other machines can reach it.

    Raises:
        OSError: it is taken.
    """
    problem = OSError("no port")
    for number in [port] if port else PORTS:
        server = Listening()
        server.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            server.bind((EVERYWHERE if share else LOOPBACK, number))
        except OSError as error:
            server.close()
            asked = port or f"{PORTS[0]} to {PORTS[-1]}"
            problem = OSError(f"cannot listen on port {asked}: {error.strerror}")
            continue
        server.listen(100)
        server.setblocking(False)
        return server
    raise problem


def machine_address() -> str:
    """What other machines call this one: its number in their network, else its name.

    Tablets know no names of a network without a name server.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(ELSEWHERE)  # sends nothing; the system chooses the interface
        except OSError:
            return socket.gethostname()
        return str(probe.getsockname()[0])


class Server:
    """Serves a Content; to be used in the thread of an asyncio loop.

    Args:
        password: that pages are asked for; empty: none.

    Attributes:
        token: first part of every address.
        pages: those that are open, by number.
    """

    def __init__(self, content: Content, password: str = "") -> None:
        self.content, self.password = content, password
        self.token, self.key = secrets.token_urlsafe(16), secrets.token_urlsafe(16)
        self.pages: dict[int, Page] = {}
        self.guessing = asyncio.Lock()
        self._opened = 0
        mine = {"server": self}
        application = tornado.web.Application(
            [
                (r"/([^/]*)/", Index, mine),
                (r"/([^/]*)/socket", Socket, mine),
                (r"/([^/]*)/(.+)", Files, mine),
            ],
            default_handler_class=Guarded,
            default_handler_args=mine,
            log_function=lambda _: None,  # addresses have the token
            compress_response=True,
            websocket_max_message_size=MAX_BYTES,
            websocket_ping_interval=PING,
        )
        self._http = tornado.httpserver.HTTPServer(
            application,
            max_body_size=MAX_BYTES,
            max_header_size=16384,
            idle_connection_timeout=IDLE,
            body_timeout=BODY,
        )

    def start(self, listening: socket.socket) -> None:
        """Accept browsers."""
        for name in ("access", "general"):  # broken requests are browsers' matter
            logging.getLogger(f"tornado.{name}").setLevel(logging.CRITICAL)
        self._http.add_socket(listening)

    def stop(self) -> None:
        """Accept no more."""
        self._http.stop()

    def knows(self, cookie: str | None) -> bool:
        """Whether a browser need not give the password (any more)."""
        return not self.password or hmac.compare_digest((cookie or "").encode(), self.key.encode())

    def is_password(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), self.password.encode())

    def add(self, write: Write) -> Page | None:
        """A page has come; None: there are too many."""
        if len(self.pages) >= MAX_PAGES:
            return None
        self._opened += 1
        page = self.pages[self._opened] = Page(self._opened, write)
        self.content.opened(page)
        return page

    def remove(self, page: Page) -> None:
        """A page has gone."""
        del self.pages[page.number]
        self.content.closed(page)

    def received(self, page: Page, text: str | bytes) -> None:
        """A page has sent something."""
        try:
            message = parse(text)
        except BadMessage as error:
            page.refused += 1
            page.notify(str(error))
            return
        if message["type"] == "ack":
            page.acknowledged()
        else:
            self.content.received(page, message)
