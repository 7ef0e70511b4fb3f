"""The server for pages: its token and password, slow, wild and many browsers."""

import asyncio
import contextlib
import http.client
import ipaddress
import json
import random
import socket
import threading
import time
from urllib.parse import urlencode

import psutil
import pytest
import websocket
from bullet_web.server import (
    LOOPBACK,
    MAX_PAGES,
    PORTS,
    WINDOW,
    File,
    Page,
    Server,
    listen,
    machine_address,
)

from bullet_web import server as server_module
from paddock_common import open_files

PATIENCE = 60.0  # [s]
WILD = 10000
SCENE = b'{"number": 7}'


class Content:
    """Notes what pages do."""

    files = {"index.html": File("text/html", b"<p>page"), "live.js": File("text/javascript", b"1")}

    def __init__(self):
        self.events = []

    def scene(self, number):
        return SCENE if number == 7 else None

    def asset(self, name):
        return File("image/png", b"png") if name == "abc" else None

    def opened(self, page):
        page.put("status", json.dumps({"you": page.number}))
        self.events.append(("opened", page.number))

    def received(self, page, message):
        self.events.append((page.number, message))

    def closed(self, page):
        self.events.append(("closed", page.number))


class Running:
    """A Server in a thread of its own."""

    def __init__(self, password=""):
        self.content = Content()
        self.loop = asyncio.new_event_loop()
        self.listening = listen(0, False)
        self.port = self.listening.getsockname()[1]
        started = threading.Event()

        def run():
            asyncio.set_event_loop(self.loop)
            self.server = Server(self.content, password)
            self.server.start(self.listening)
            self.loop.call_soon(started.set)
            self.loop.run_forever()

        self._thread = threading.Thread(target=run, daemon=True)
        self._thread.start()
        assert started.wait(PATIENCE)

    def call(self, function):
        """Runs a function in the server's thread; gives its result."""

        async def work():
            return function()

        return asyncio.run_coroutine_threadsafe(work(), self.loop).result(PATIENCE)

    def request(self, path, method="GET", body=None, **headers):
        """Status, headers and body of a response."""
        connection = http.client.HTTPConnection(LOOPBACK, self.port, timeout=PATIENCE)
        try:
            connection.request(method, path, body, headers)
            response = connection.getresponse()
            return response.status, dict(response.getheaders()), response.read()
        finally:
            connection.close()

    def open(self, token=None, path="socket", **options):
        """A WebSocket of a page."""
        token = self.server.token if token is None else token
        url = f"ws://{LOOPBACK}:{self.port}/{token}/{path}"
        options.setdefault("origin", f"http://{LOOPBACK}:{self.port}")
        return websocket.create_connection(url, timeout=PATIENCE, **options)

    def close(self):
        self.call(self.server.stop)
        self.listening.close()
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join(PATIENCE)
        self.loop.close()


@pytest.fixture
def running():
    made = Running()
    yield made
    made.close()


def wait(condition):
    """Waits for a true value and returns it."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.005)
    raise AssertionError("not in time")


def test_a_request_without_its_body_is_closed(monkeypatch):
    """Without the token, too: a thousand of them kept everybody out, for as long as they wanted."""
    monkeypatch.setattr(server_module, "BODY", 0.5)
    running = Running()
    try:
        head = b"POST /x/ HTTP/1.1\r\nHost: x\r\nContent-Length: 4000\r\n\r\n"
        held = [socket.create_connection((LOOPBACK, running.port)) for _ in range(200)]
        for each in held:
            each.sendall(head)
            each.settimeout(PATIENCE)
        assert [each.recv(1) for each in held] == [b""] * 200
        assert running.request(f"/{running.server.token}/")[0] == 200
    finally:
        running.close()


def test_at_the_limit_of_open_files_connections_are_refused_and_later_accepted(monkeypatch):
    running = Running()
    try:
        with monkeypatch.context() as patch:
            patch.setattr(open_files.resource, "getrlimit", lambda _: (open_files.RESERVED, 4096))
            with pytest.raises(OSError):
                running.request("/")
        assert running.request(f"/{running.server.token}/")[0] == 200
    finally:
        running.close()


def test_who_knows_the_token_gets_the_page_and_its_files(running):
    token = running.server.token
    status, headers, body = running.request(f"/{token}/")
    assert (status, body) == (200, b"<p>page")
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert headers["Referrer-Policy"] == "no-referrer"
    assert "Server" not in headers
    assert running.request(f"/{token}/live.js")[0] == 200
    assert running.request(f"/{token}/scene/7")[2] == SCENE
    assert running.request(f"/{token}/asset/abc")[1]["Cache-Control"].startswith("private")
    for missing in ("scene/8", "scene/x", "asset/xyz", "../etc/passwd", "node.py", "live.js/"):
        assert running.request(f"/{token}/{missing}")[0] == 404


@pytest.mark.parametrize("path", ["", "live.js", "scene/7", "asset/abc", "socket", "nothing"])
def test_without_the_token_there_is_nothing(running, path):
    token = running.server.token
    for wrong in ("", token[:-1], token + "x", token.swapcase(), "%00", "ü".encode().hex()):
        status, _, body = running.request(f"/{wrong}/{path}")
        assert (status, body) == (403, b"")
    assert running.request("/")[0] == 403
    assert running.request(f"/x/{token}/{path}")[0] == 403
    assert running.request(f"/?{token}")[0] == 403


def test_a_web_socket_needs_the_token_and_the_page_s_own_origin(running):
    for arguments in ({"token": "x"}, {"token": ""}, {"origin": "http://evil.example"}):
        with pytest.raises(websocket.WebSocketBadStatusException) as error:
            running.open(**arguments)
        assert error.value.status_code == 403
    assert running.content.events == []
    running.open().close()


def test_tokens_differ_and_are_long(running):
    other = Running()
    try:
        assert running.server.token != other.server.token
        assert len(running.server.token) >= 22  # 128 bits
    finally:
        other.close()


def test_only_this_machine_reaches_the_port():
    with listen(0, False) as first, listen(0, False) as second:
        assert first.getsockname()[0] == LOOPBACK
        taken = first.getsockname()[1]
        assert taken in PORTS and second.getsockname()[1] > taken
        with pytest.raises(OSError, match=f"cannot listen on port {taken}: Address already in use"):
            listen(taken, False)


def test_a_class_of_thirty_has_a_page_each():
    """A server has a world of each; the twenty-first found no port."""
    with contextlib.ExitStack() as stack:
        taken = {stack.enter_context(listen(0, False)).getsockname()[1] for _ in range(30)}
    assert len(taken) == 30 and taken <= set(PORTS)


def test_a_shared_page_is_told_by_a_number_or_else_by_the_name(monkeypatch):
    told = machine_address()
    if told != socket.gethostname():
        with socket.socket() as own:
            own.bind((ipaddress.ip_address(told).compressed, 0))  # an interface of this machine
    monkeypatch.setattr("socket.gethostname", lambda: "lab")

    class Nowhere(socket.socket):
        def connect(self, address):
            raise OSError("Network is unreachable")

    monkeypatch.setattr("socket.socket", Nowhere)
    assert machine_address() == "lab"


def test_a_shared_page_asks_for_the_password():
    running = Running("parking lot")
    try:
        path = f"/{running.server.token}/"
        status, _, body = running.request(path)
        assert status == 200 and b"password" in body and b"<p>page" not in body
        for name in ("live.js", "scene/7", "asset/abc", "socket"):
            assert running.request(path + name)[0] == 403
        kind = {"Content-Type": "application/x-www-form-urlencoded"}
        wrong = urlencode({"password": "parking"})
        status, headers, body = running.request(path, "POST", wrong, **kind)
        assert status == 403 and "Set-Cookie" not in headers
        assert b"<form" in body and b"not the password" in body  # to try again
        right = urlencode({"password": "parking lot"})
        assert running.request("/x/", "POST", right, **kind)[::2] == (403, b"")
        status, headers, _ = running.request(path, "POST", right, **kind)
        assert status == 303
        cookie = headers["Set-Cookie"].split(";")[0]
        assert "HttpOnly" in headers["Set-Cookie"] and "SameSite=Strict" in headers["Set-Cookie"]
        assert running.request(path, Cookie=cookie)[2] == b"<p>page"
        assert running.request(f"{path}live.js", Cookie=cookie)[0] == 200
        running.open(cookie=cookie).close()
        with pytest.raises(websocket.WebSocketBadStatusException):
            running.open(cookie="paddock=x")
    finally:
        running.close()


def test_messages_come_checked_and_pages_go(running):
    client = running.open()
    assert json.loads(client.recv()) == {"you": 1}
    client.send('{"type": "drive", "speed": 0.5, "steering": 0}')
    command = {"type": "drive", "speed": 0.5, "steering": 0}
    wait(lambda: (1, command) in running.content.events)
    client.close()
    wait(lambda: ("closed", 1) in running.content.events)
    assert running.server.pages == {}


def test_a_page_gets_the_newest_once_it_has_acknowledged(running):
    client = running.open()
    page = wait(lambda: running.server.pages.get(1))
    client.recv()
    for number in range(50):
        running.call(lambda: page.put("view", str(number)))
    sent = [client.recv() for _ in range(WINDOW - 1)]
    assert sent == [str(number) for number in range(WINDOW - 1)]
    client.send('{"type": "ack"}')
    assert client.recv() == "49"
    client.close()


def test_a_browser_that_reads_no_more_costs_nothing(running):
    slow, quick = running.open(), running.open()
    pages = wait(lambda: len(running.server.pages) == 2 and list(running.server.pages.values()))
    quick.recv()
    quick.send('{"type": "ack"}')
    before = psutil.Process().memory_info().rss
    load = bytes(200_000)
    for _ in range(500):  # 100 MB for a browser that does not read
        for page in pages:
            running.call(lambda: page.put("image", load))
        assert quick.recv() == load
        quick.send('{"type": "ack"}')
    assert psutil.Process().memory_info().rss - before < 30e6
    for client in (slow, quick):
        client.close()


def test_a_browser_that_acknowledges_what_it_does_not_read_costs_nothing(running):
    client = running.open(sockopt=((socket.SOL_SOCKET, socket.SO_RCVBUF, 65536),))
    page = wait(lambda: running.server.pages.get(1))
    before = psutil.Process().memory_info().rss
    load = bytes(200_000)
    for _ in range(500):
        running.call(lambda: page.put("image", load))
        client.send('{"type": "ack"}')
    client.send('{"type": "take"}')
    wait(lambda: (1, {"type": "take"}) in running.content.events)
    assert psutil.Process().memory_info().rss - before < 30e6
    client.shutdown()
    wait(lambda: not running.server.pages)


def test_wild_messages_end_and_stall_nothing(running):
    chance = random.Random(5)
    witness = running.open()
    witness.recv()
    left = WILD
    closed = 0
    while left:
        wild = running.open()
        try:
            while left:
                left -= 1
                size = chance.choice((0, 1, 20, 200, 2000, 4096))
                if chance.random() < 0.2:
                    wild.send_binary(random_bytes(chance, size))
                elif chance.random() < 0.3:
                    wild.send(json.dumps({"type": chance.choice(("do", "drive", "want", "ack"))}))
                else:
                    text = random_bytes(chance, size).decode("latin1")
                    wild.send(chance.choice(("", '{"type": "drive", "speed":', "[[[")) + text)
        except (OSError, websocket.WebSocketException):
            closed += 1
        wild.shutdown()
    assert closed > 0  # too many messages close a page
    witness.send('{"type": "take"}')
    wait(lambda: (1, {"type": "take"}) in running.content.events)
    wait(lambda: len(running.server.pages) == 1)
    witness.close()


@pytest.mark.parametrize(
    "flood", [b"\x89\x80\0\0\0\0", b"\x81\x82\0\0\0\0{}"], ids=["ping", "text"]
)
def test_a_flood_ends_its_connection_at_once(running, flood):
    """Pings were answered without an end: another page took 8 s to open."""
    wild = running.open()
    with pytest.raises(OSError):
        for _ in range(1000):
            wild.sock.sendall(1000 * flood)
    wait(lambda: not running.server.pages)


def random_bytes(chance, size):
    """Bytes of a random.Random, whose randbytes() came with Python 3.9."""
    return bytes(chance.choices(range(256), k=size))


def test_broken_requests_end_nothing(running):
    chance = random.Random(6)
    token = running.server.token
    for number in range(200):
        with socket.create_connection((LOOPBACK, running.port), PATIENCE) as client:
            head = f"GET /{token}/socket HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\n"
            text = head.encode() if number % 2 else b""
            client.sendall(text + random_bytes(chance, chance.choice((1, 100, 20000))))
    assert running.request(f"/{token}/")[0] == 200


def test_a_message_that_is_too_long_closes_its_page(running):
    client = running.open()
    client.recv()
    client.send('"' + 5000 * "x" + '"')
    with contextlib.suppress(websocket.WebSocketException, OSError):
        while client.recv():  # empty when it is closed
            pass
    wait(lambda: not running.server.pages)
    assert running.content.events[-1] == ("closed", 1)


def test_fifty_pages_open_and_close_without_leaving_memory(running):
    def cycle():
        clients = [running.open() for _ in range(50)]
        for client in clients:
            client.recv()
        for client in clients:
            client.close()
        wait(lambda: not running.server.pages)

    cycle()
    cycle()
    process = psutil.Process()
    memory, files = process.memory_info().rss, process.num_fds()
    for _ in range(6):
        cycle()
    assert process.memory_info().rss - memory < 8e6
    wait(lambda: process.num_fds() <= files + 2)


def test_there_is_a_limit_of_pages(running):
    clients = [running.open() for _ in range(MAX_PAGES)]
    wait(lambda: len(running.server.pages) == MAX_PAGES)
    extra = running.open()
    assert extra.recv() == ""  # closed
    for client in (*clients, extra):
        client.close()


def test_a_page_may_send_so_many_messages_a_second():
    class Clock:
        now = 0.0

        def __call__(self):
            return self.now

    clock = Clock()
    page = Page(1, lambda message: None, clock)
    assert sum(page.may_send() for _ in range(1000)) == 600
    clock.now += 1.0
    assert sum(page.may_send() for _ in range(1000)) <= 200
