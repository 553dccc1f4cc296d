"""The server: HTTP on the loopback device of this machine, one thread for every connection."""

import contextlib
import json
import os
import selectors
import socket
import sys
import threading
import time
import traceback
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, BinaryIO

import numpy as np

from sweep.errors import RequestError
from sweep.explorer.answers import JSON, Answer, Answers
from sweep.explorer.fields import read_json
from sweep.explorer.guard import Guard
from sweep.explorer.pages import INDEX, content_policy, page_files
from sweep.explorer.turns import SupersededError

#: Bytes of the body of a request at most.
MOST_BYTES = 64 * 1024

#: Connections at once: a browser keeps six.
MOST_CONNECTIONS = 128

#: Seconds in which a request has to arrive, and after which a connection without requests is closed.
ARRIVAL, _IDLE = 10.0, 60.0

#: Bytes of a file that are in memory at a time.
_CHUNK = 2**18

#: Sent with every answer.
_HEADERS = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
}

HOST = "127.0.0.1"

_LAST_PORT = 65_535

_PORT_HINT = "Leave --port out, or give one that is free, as in --port 8123."


class Server(ThreadingHTTPServer):
    """Answers requests of this machine until it is closed.

    Parameters
    ----------
    answers : Answers
    port : int
        0 for any that is free.
    framed : bool
        Whether a notebook may show the page in a frame.

    Raises
    ------
    RequestError
        If the port cannot be used.
    """

    daemon_threads = True
    block_on_close = False
    request_queue_size = 128

    def __init__(self, answers: Answers, port: int = 0, *, framed: bool = False) -> None:
        if not 0 <= port <= _LAST_PORT:
            raise RequestError(
                f"A port is a number from 0 to {_LAST_PORT}; got {port}.", hint=_PORT_HINT, where="port"
            )
        # the base class closes the server where it cannot listen
        self._connections: set[socket.socket] = set()
        #: connection -> the time at which its request began to arrive
        self._arriving: dict[socket.socket, float] = {}
        try:
            super().__init__((HOST, port), _Handler)
        except OSError as problem:
            raise RequestError(
                f"The explorer cannot listen at port {port}: {problem.strerror or problem}.",
                hint=_PORT_HINT,
                where="port",
            ) from None
        self.answers = answers
        self.guard = Guard(self.server_port)
        self.pages = page_files()
        self.policy = content_policy(self.pages[INDEX].content, framed=framed)
        self._room = threading.BoundedSemaphore(MOST_CONNECTIONS)

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self.server_port}/{self.guard.token}/"

    def server_bind(self) -> None:
        """Bind the socket; the name of the machine, which `HTTPServer` would look up, is not needed."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = HOST, self.server_address[1]

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a connection in a thread of its own, unless there are too many."""
        if not self._room.acquire(blocking=False):
            request.settimeout(1.0)
            with contextlib.suppress(OSError):
                request.sendall(_TOO_MANY)
            self.shutdown_request(request)
            return
        try:
            super().process_request(request, client_address)
        except RuntimeError:
            # the system has no more threads
            self._room.release()
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer the requests of a connection, one after another."""
        self._connections.add(request)
        try:
            super().process_request_thread(request, client_address)
        finally:
            self.arrived(request)
            self._connections.discard(request)
            self._room.release()

    def arrives(self, connection: socket.socket) -> None:
        """Note that a request has begun to arrive."""
        self._arriving.setdefault(connection, time.monotonic())

    def arrived(self, connection: socket.socket) -> None:
        """Note that all of a request is there."""
        self._arriving.pop(connection, None)

    def server_close(self) -> None:
        """Close the address and all connections: a page that still asks is told that nobody is there."""
        super().server_close()
        for connection in list(self._connections):
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)

    def service_actions(self) -> None:
        """End connections whose requests take too long to arrive; called twice a second."""
        late = time.monotonic() - ARRIVAL
        for connection, since in list(self._arriving.items()):
            if since < late:
                with contextlib.suppress(OSError):
                    connection.shutdown(socket.SHUT_RDWR)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say on standard error what went wrong with a connection; a client that has gone is nothing wrong."""
        problem = sys.exception() if hasattr(sys, "exception") else sys.exc_info()[1]
        if not isinstance(problem, ConnectionError | TimeoutError):
            traceback.print_exception(problem)


_BUSY = json.dumps(
    {
        "error": f"The explorer has {MOST_CONNECTIONS} connections open, and takes no more.",
        "hint": "Close other pages of it.",
        "where": "connections",
    }
).encode()
_TOO_MANY = (
    b"HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/json\r\nConnection: close\r\n"
    + f"Content-Length: {len(_BUSY)}\r\n\r\n".encode()
    + _BUSY
)


class _Handler(BaseHTTPRequestHandler):
    """Reads the requests of one connection and writes the answers."""

    server: Server
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    timeout = _IDLE
    server_version, sys_version = "eulerdisk", ""

    def handle_one_request(self) -> None:
        """Wait for a request; from its first byte on it has a limited time to arrive."""
        if self.rfile.peek(1):  # type: ignore[attr-defined]  # a BufferedReader has it
            self.server.arrives(self.connection)
            super().handle_one_request()
        else:
            self.close_connection = True

    def do_GET(self) -> None:
        """Send the page, one of its files, or what it has to know."""
        path = self._let_in()
        if path is None:
            return
        self.server.arrived(self.connection)
        name = INDEX if path == "" else path.removeprefix("page/") if path.startswith("page/") else None
        if path == "about":
            self._answer(self.server.answers.about)
        elif path in self.server.answers.posted:
            self._error(405, "This address is asked with POST.", allow="POST")
        elif name in self.server.pages:
            page = self.server.pages[name]
            self._send(200, page.kind, [page.content], policy=name == INDEX)
        else:
            self._error(404, "There is nothing at this address.")

    def do_POST(self) -> None:
        """Answer a question of the page."""
        path = self._let_in()
        if path is None:
            return
        body = self._body()
        if body is None:
            return
        self.server.arrived(self.connection)
        answer = self.server.answers.posted.get(path)
        if answer is None:
            known = path in ("", "about") or path.startswith("page/")
            self._error(405 if known else 404, "There is nothing to post to at this address.", allow="GET")
            return
        self._answer(lambda: answer(read_json(body), self._gone))

    def _let_in(self) -> str | None:
        """Return the path behind the token; None if the request was refused."""
        refusal = self.server.guard.refusal(self.path, self.headers)  # type: ignore[arg-type]
        if refusal:
            self._error(403, refusal, close=True)
            return None
        return self.path.split("/", 2)[2] if self.path.count("/") > 1 else "/"

    def _body(self) -> bytes | None:
        """Return the body of a request; None if the request was refused."""
        length = self.headers.get("Content-Length", "")
        if self.headers.get("Transfer-Encoding") or not (length.isascii() and length.isdigit()):
            self._error(411, "A request says how long it is.", close=True)
            return None
        if len(length) > 9 or int(length) > MOST_BYTES:
            self._error(413, f"A request has at most {MOST_BYTES} bytes; got {length}.", close=True)
            return None
        if self.headers.get_content_type() != JSON:
            self._error(415, f"A request is {JSON}.", close=True)
            return None
        body = self.rfile.read(int(length))
        if len(body) < int(length):
            self.close_connection = True
            return None
        return body

    def _answer(self, make: Any) -> None:
        try:
            # values of a page may be as large as they like
            with np.errstate(all="ignore"):
                answer: Answer = make()
        except SupersededError:
            self._error(410, "superseded")
        except RequestError as error:
            self._send_json(400, {"error": error.message, "hint": error.hint, "where": error.where or ""})
        except MemoryError:
            self._error(400, "The memory of this process is not enough for that.")
        except Exception:
            # the page gets one sentence, whoever started the server the rest
            traceback.print_exc()
            self._error(500, "This is a defect of eulerdisk; what is known of it stands in the terminal.")
        else:
            content = [_json(answer.content)] if answer.kind == JSON else answer.content
            with contextlib.nullcontext() if isinstance(content, list) else content:
                self._send(200, answer.kind, content, name=answer.name)

    def _gone(self) -> bool:
        """Whether the client has closed the connection."""
        try:
            # not select.select(), which takes no descriptor from 1024 on
            with selectors.DefaultSelector() as selector:
                selector.register(self.connection, selectors.EVENT_READ)
                readable = selector.select(0)
            return bool(readable) and not self.connection.recv(1, socket.MSG_PEEK)
        except (OSError, ValueError):
            return True

    def _error(self, status: int, problem: str, *, close: bool = False, allow: str = "") -> None:
        self.close_connection |= close
        self._send_json(status, {"error": problem, "hint": "", "where": ""}, allow=allow)

    def _send_json(self, status: int, content: Any, allow: str = "") -> None:
        self._send(status, JSON, [_json(content)], allow=allow)

    def _send(
        self,
        status: int,
        kind: str,
        content: list[bytes | memoryview] | BinaryIO,
        *,
        policy: bool = False,
        name: str = "",
        allow: str = "",
    ) -> None:
        self.send_response_only(status)
        for header, value in _HEADERS.items():
            self.send_header(header, value)
        self.send_header("Content-Type", kind)
        length = sum(map(len, content)) if isinstance(content, list) else os.fstat(content.fileno()).st_size
        self.send_header("Content-Length", str(length))
        if policy:
            self.send_header("Content-Security-Policy", self.server.policy)
        if name:
            self.send_header("Content-Disposition", f'attachment; filename="{name}"')
        if allow and status == 405:
            self.send_header("Allow", allow)
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        for part in content if isinstance(content, list) else iter(lambda: content.read(_CHUNK), b""):
            self.wfile.write(part)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Answer a request that is none, in one sentence."""
        del explain
        self._error(
            int(code), f"This is no request that is answered here: {message or 'malformed'}.", close=True
        )

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing of single requests."""


def _json(content: Any) -> bytes:
    return json.dumps(content, allow_nan=False, separators=(",", ":")).encode()
