"""The server: HTTP on the loopback interface of this machine, only for the person who opened the page."""

import contextlib
import io
import json
import os
import secrets
import selectors
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np

from sweep.errors import RequestError
from sweep.explorer.answers import JSON, Answer, Answers
from sweep.explorer.fields import read_json
from sweep.explorer.pages import INDEX, KERNELS, content_policy, page_files
from sweep.explorer.waiting import ClientGoneError

#: Largest body of a request [bytes].
MOST_BYTES = 64 * 1024

#: Largest number of requests that are answered at a time, each by a thread; a browser sends up to six.
MOST_REQUESTS = 64

#: Time [s] within which a request must arrive, including its body, and within which a part of an answer must be
#: received.
_ARRIVAL = 5.0

#: Time [s] for which a request waits for room: longer than requests that never arrive can take it.
_PATIENCE = _ARRIVAL + 1.0

#: Number of bytes of a file that are in memory at a time.
_CHUNK = 2**18

#: Headers of every answer.
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Connection": "close",
}

HOST = "127.0.0.1"

#: Values by which a browser marks a request of the page itself, and an address that a person typed.
_OWN = ("same-origin", "none")

_LAST_PORT = 65_535

_PORT_HINT = "Leave out port, or give a free one, such as 8123."


@dataclass(frozen=True)
class Request:
    """A request as it arrived.

    `body` reads a given number of bytes of the body, and returns None if they do not arrive; `check` raises an error if
    the client has closed its connection.
    """

    method: str
    path: str
    headers: Mapping[str, str]
    body: Callable[[int], bytes | None]
    check: Callable[[], None]


class Server(ThreadingHTTPServer):
    """Answers requests from this machine until it is closed.

    Parameters
    ----------
    answers : Answers
    port : int
        Port; 0 for any free one.
    framed : bool
        Whether a notebook may show the page in a frame.

    Attributes
    ----------
    token : str
        32 random characters, which are the first part of every path.

    Raises
    ------
    RequestError
        If the port cannot be used.
    """

    daemon_threads = True
    block_on_close = False
    request_queue_size = 1024

    def __init__(self, answers: Answers, port: int = 0, *, framed: bool = False) -> None:
        if not 0 <= port <= _LAST_PORT:
            raise RequestError(
                f"A port must be a number from 0 to {_LAST_PORT}; got {port}.", hint=_PORT_HINT, where="port"
            )
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as problem:
            raise RequestError(
                f"The explorer cannot listen on port {port}: {problem.strerror or problem}.",
                hint=_PORT_HINT,
                where="port",
            ) from None
        self.token = secrets.token_urlsafe(24)
        self._answers, self._pages = answers, page_files()
        self._policy = content_policy(self._pages[INDEX].content, framed=framed)
        self._hosts = tuple(f"{name}:{self.server_port}" for name in (HOST, "localhost"))
        self._room = threading.BoundedSemaphore(MOST_REQUESTS)

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self.server_port}/{self.token}/"

    def app(self, request: Request) -> Answer:
        """Return the answer to a request."""
        if refusal := self._refusal(request.path, request.headers):
            return _problem(403, refusal)
        path = request.path.split("/", 2)[2] if request.path.count("/") > 1 else "/"
        name = INDEX if path == "" else path.removeprefix("page/") if path.startswith("page/") else None
        if request.method == "GET":
            if path == "about":
                return self._make_answer(lambda: self._answers.about)
            if name == KERNELS and self._answers.has_own_kernels:
                return self._make_answer(lambda: self._answers.kernels)
            if name in self._pages:
                page = self._pages[name]
                headers = {"Content-Security-Policy": self._policy} if name == INDEX else {}
                return Answer(page.kind, [page.content], headers)
            if path in self._answers:
                return _problem(405, "This address needs POST.", {"Allow": "POST"})
            return _problem(404, "There is nothing at this address.")
        body = _read_body(request)
        if isinstance(body, Answer):
            return body
        if path not in self._answers:
            status = 405 if path == "about" or name is not None else 404
            return _problem(status, "This address does not accept POST.", {"Allow": "GET"})
        return self._make_answer(lambda: self._answers.answer(path, read_json(body), request.check))

    def _refusal(self, path: str, headers: Mapping[str, str]) -> str:
        """Return why a request is refused; empty if it is accepted.

        A page of another site could reach this server under its own host name (then ``Host`` is that name), send it a
        form or a script's request (then the browser adds an ``Origin``), or show it in a frame.
        """
        if headers.get("Host", "") not in self._hosts:
            return f"The host must be {' or '.join(self._hosts)}."
        origin = headers.get("Origin")
        # a link or a frame of another page, such as a notebook, may open the page itself
        opens = headers.get("Sec-Fetch-Mode") == "navigate" and path == f"/{self.token}/"
        foreign = headers.get("Sec-Fetch-Site", "none") not in _OWN and not opens
        if foreign or (origin is not None and origin not in [f"http://{host}" for host in self._hosts]):
            return "Requests from pages of other sites are not answered."
        given = path.split("/")[1] if path.startswith("/") else ""
        if not secrets.compare_digest(given.encode(), self.token.encode()):
            return "The address needs the token that eulerdisk explore printed."
        return ""

    def _make_answer(self, make: Callable[[], Answer]) -> Answer:
        """Return the answer that `make` creates, or an answer that reports its error."""
        try:
            # values from a page may be arbitrarily large
            with np.errstate(all="ignore"):
                return make()
        except ClientGoneError:
            return _problem(410, "No client waits for this answer.")
        except RequestError as error:
            return Answer(
                JSON, {"error": error.message, "hint": error.hint, "where": error.where or ""}, status=400
            )
        except MemoryError:
            return _problem(400, "This process has too little memory for that.")
        except Exception:
            # the page gets one sentence, the terminal the details
            traceback.print_exc()
            return _problem(500, "This is a bug in eulerdisk; see the terminal for details.")

    def server_bind(self) -> None:
        """Bind the socket, without looking up the name of the machine as `HTTPServer` does."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = HOST, self.server_address[1]

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Wait until there is room for a request; later ones wait in the system's queue meanwhile."""
        if self._room.acquire(timeout=_PATIENCE):
            return True
        _refuse_for_room(request)
        return False

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer a request, then release its room."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._room.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Print the error of a request to standard error, unless the client has merely gone."""
        problem = sys.exc_info()[1]
        if not isinstance(problem, ConnectionError | TimeoutError):
            traceback.print_exception(problem)


def _read_body(request: Request) -> bytes | Answer:
    """Return the body of a request, or an answer that says why it cannot be read."""
    length = request.headers.get("Content-Length", "")
    if request.headers.get("Transfer-Encoding") or not (length.isascii() and length.isdigit()):
        return _problem(411, "A request needs its length.")
    if len(length) > 9 or int(length) > MOST_BYTES:
        return _problem(413, f"A request can have at most {MOST_BYTES} bytes; got {length}.")
    if request.headers.get("Content-Type", "").partition(";")[0].strip().lower() != JSON:
        return _problem(415, f"A request must be {JSON}.")
    body = request.body(int(length))
    return _late_answer() if body is None else body


def _late_answer() -> Answer:
    return _problem(
        HTTPStatus.REQUEST_TIMEOUT, f"The request did not arrive completely within {_ARRIVAL:g} s."
    )


def _problem(status: int, problem: str, headers: Mapping[str, str] | None = None, hint: str = "") -> Answer:
    return Answer(JSON, {"error": problem, "hint": hint, "where": ""}, headers or {}, status)


def _head(answer: Answer, length: int) -> bytes:
    """Return the head of an answer with a body of `length` bytes."""
    headers = {"Content-Type": answer.kind, "Content-Length": str(length)}
    lines = [f"HTTP/1.1 {answer.status} {HTTPStatus(answer.status).phrase}"]
    lines += [f"{name}: {value}" for name, value in {**_HEADERS, **headers, **answer.headers}.items()]
    return "\r\n".join([*lines, "", ""]).encode("latin-1")


def _json_bytes(content: Any) -> bytes:
    return json.dumps(content, allow_nan=False, separators=(",", ":")).encode()


def _refuse_for_room(connection: socket.socket) -> None:
    """Refuse a request for which there is no room, without a thread and without waiting for it."""
    answer = _problem(
        HTTPStatus.SERVICE_UNAVAILABLE,
        f"The explorer is already answering {MOST_REQUESTS} requests, the most at a time.",
        {"Retry-After": str(round(_ARRIVAL))},
        "Try again in some seconds. If that does not help, close other pages of this explorer.",
    )
    content = _json_bytes(answer.content)
    with contextlib.suppress(OSError):
        connection.setblocking(False)
        # unread data would make the system reset the connection, so that the client loses the answer
        with contextlib.suppress(BlockingIOError):
            connection.recv(2 * MOST_BYTES)
        connection.sendall(_head(answer, len(content)) + content)


class _Arrival(io.RawIOBase):
    """The bytes of a connection until a deadline, when it ends as if the client had closed it."""

    def __init__(self, connection: socket.socket, seconds: float) -> None:
        self._connection, self._end = connection, time.monotonic() + seconds
        self.is_late = False

    def readable(self) -> bool:
        """Return True: it can be read."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read available bytes, or wait for them until the deadline."""
        left = self._end - time.monotonic()
        try:
            if left > 0:
                self._connection.settimeout(left)
                return self._connection.recv_into(buffer)
        except TimeoutError:
            pass
        self.is_late = True
        return 0


class _Handler(BaseHTTPRequestHandler):
    """Reads a request, and writes its answer."""

    server: Server
    protocol_version = "HTTP/1.1"
    timeout = _ARRIVAL
    server_version, sys_version = "eulerdisk", ""

    def setup(self) -> None:
        """Read from the connection with a deadline: a request that drips in would keep its room forever."""
        super().setup()
        self._arrival = _Arrival(self.connection, self.timeout)
        self.rfile = io.BufferedReader(self._arrival)

    def do_GET(self) -> None:
        """Answer a GET request."""
        headers: Any = self.headers
        # it may lack lines, or the end of a line
        if self._arrival.is_late:
            self._send(_late_answer())
            return
        self._send(self.server.app(Request(self.command, self.path, headers, self._read, self._check)))

    def do_POST(self) -> None:
        """Answer a POST request of the page."""
        self.do_GET()

    def _read(self, length: int) -> bytes | None:
        body = self.rfile.read(length)
        return body if len(body) == length else None

    def _check(self) -> None:
        try:
            with selectors.DefaultSelector() as selector:
                selector.register(self.connection, selectors.EVENT_READ)
                gone = bool(selector.select(0)) and not self.connection.recv(1, socket.MSG_PEEK)
        except (OSError, ValueError):
            gone = True
        if gone:
            raise ClientGoneError

    def _send(self, answer: Answer) -> None:
        content = answer.content
        if answer.kind == JSON:
            content = [_json_bytes(content)]
        with contextlib.nullcontext() if isinstance(content, list) else content:
            if isinstance(content, list):
                length, parts = sum(map(len, content)), iter(content)
            else:
                length, parts = os.fstat(content.fileno()).st_size, iter(lambda: content.read(_CHUNK), b"")
            self.close_connection = True
            # the answer gets its own time limit, not the rest of the request's
            self.connection.settimeout(self.timeout)
            self.wfile.write(_head(answer, length))
            for part in parts:
                self.wfile.write(part)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Answer a malformed HTTP request with one sentence."""
        del explain
        self._send(_problem(int(code), f"This request cannot be answered: {message or 'malformed'}."))

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing about single requests."""
