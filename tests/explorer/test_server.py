"""Answers and refusals of the explorer's server."""

import contextlib
import json
import os
import re
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from cases import case
from explorer_client import ROLLING, ask, changed, post, post_refused, raw
from messages import assert_facts

from sweep.errors import RequestError
from sweep.explorer import answers, server
from sweep.explorer.explorer import explore

CHECKOUT = Path(__file__).resolve().parents[2]


def test_the_page_is_sent_with_a_policy_that_lets_nothing_else_in(url):
    """The page's policy forbids foreign and inline scripts, and responses are neither cached nor sniffed."""
    page = ask(url)
    assert page.status == 200
    assert page.headers["Content-Type"] == "text/html; charset=utf-8"
    policy = dict(part.strip().split(" ", 1) for part in page.headers["Content-Security-Policy"].split(";"))
    assert policy["default-src"] == "'self'"
    # the kernels are WebAssembly; nothing else is evaluated
    assert page.headers["Content-Security-Policy"].replace("'wasm-unsafe-eval'", "").count("unsafe") == 0
    assert "http" not in policy["script-src"]
    assert (page.headers["X-Content-Type-Options"], page.headers["Cache-Control"]) == ("nosniff", "no-store")


def test_every_file_of_the_page_is_sent_with_its_type(url):
    """Every module, style and picture of the package is sent byte for byte; nothing else is served."""
    folder = CHECKOUT / "sweep" / "explorer" / "page"
    kinds = {".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8"}
    kinds |= {".wasm": "application/wasm"}
    files = [path for path in folder.rglob("*") if path.suffix in kinds]
    assert files
    for path in files:
        sent = ask(url, f"page/{path.relative_to(folder).as_posix()}")
        assert (sent.status, sent.headers["Content-Type"]) == (200, kinds[path.suffix])
        assert sent.body == path.read_bytes()
    assert ask(url, "page/vendor/SOURCES.toml").status == 404


def test_another_host_or_site_is_refused(url):
    """Requests with another host name, or from pages of other sites, are refused."""
    for headers in [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1"},
        {"Host": "127.0.0.1:1"},
        {"Host": ""},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site", "Sec-Fetch-Mode": "cors"},
    ]:
        for path in ["about", "window"]:
            with case(headers, path):
                body = json.dumps(changed()).encode() if path == "window" else None
                assert ask(url, path, body).status == 200
                answer = ask(url, path, body, headers=headers)
                assert answer.status == 403
                assert set(json.loads(answer.body)) == {"error", "hint", "where"}


def test_a_notebook_may_frame_the_page_and_no_more(url):
    """A frame or link of another page may open only the page itself; its requests are then same-origin."""
    opened = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "iframe"}
    assert ask(url, headers=opened).status == 200
    assert ask(url, "about", headers=opened).status == 403


def test_the_token_is_needed(url):
    """Without the right token in the right place, nothing is revealed, not even a file name."""
    place = urlsplit(url)
    base, token = f"http://{place.netloc}", place.path.strip("/")
    assert len(token) == 32
    for path in (
        "/",
        "/about",
        f"/{token[:-1]}/about",
        f"/{token}x/about",
        f"/x/{token}/about",
        f"/?{token}/",
        "//",
    ):
        answer = ask(base, path)
        assert answer.status == 403, path
        assert token not in answer.body.decode()


def test_no_path_leads_out_of_the_page(url):
    """Only a fixed list of addresses is answered; no path is built from a request."""
    for path in [
        "page/../server.py",
        "page/../../pyproject.toml",
        "page/%2e%2e/server.py",
        "page//etc/passwd",
        "../",
        "page/",
        "page/..%2fserver.py",
        "page/vendor/../../guard.py",
        "page/index.html/",
        "/etc/passwd",
        "page/\\..\\guard.py",
        "about/",
        "about?x=1",
        "page/main.js?x",
        "window/../about",
        "nothing",
    ]:
        with case(path):
            answer = ask(url, path.replace("\\", "%5c"))
            assert answer.status == 404
            assert b"import" not in answer.body


def test_methods_have_their_addresses(url):
    """Questions are posted and files are fetched; other methods are refused."""
    assert ask(url, "window").status == 405
    assert ask(url, "about", b"{}").status == 405
    assert ask(url, "nothing", b"{}").status == 404
    for method in ("PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "PATCH"):
        assert ask(url, "about", method=method).status in (403, 501)


def test_a_malformed_request_is_refused_in_words(url):
    """A malformed request gets status 400 with a sentence, and the server continues."""
    for body, said in [
        (b"", "read"),
        (b"{", "read"),
        (b"[]", "object"),
        (b"\xff\xfe", "read"),
        (b"[" * 60000, "read"),
        (b'{"view": 1}', "view"),
        (b'{"view": NaN}', "number"),
        (b'{"view": {"base": "/etc/passwd.toml"}}', "base"),
        (b'{"view": {"base": "rolling", "x": {}, "y": {}}}', "name"),
    ]:
        with case(body, said):
            answer = ask(url, "window", body)
            assert answer.status == 400
            assert_facts(json.loads(answer.body)["error"], said)
            assert ask(url, "about").status == 200


def test_an_impossible_request_names_the_field(url):
    """An invalid value gets status 400 with a sentence and the field's name."""
    for fields, where in [
        (changed(width=0), "width"),
        (changed(width=2.5), "width"),
        (changed(width=True), "width"),
        (changed(width=10**9), "width"),
        (changed(width=2001, height=2000), "width * height"),
        (changed(view={"x": {**ROLLING["x"], "half": 0.0}}), "x.half"),
        (changed(view={"x": {**ROLLING["x"], "half": "1"}}), "half"),
        (changed(view={"x": {**ROLLING["x"], "centre": 10**400}}), "centre"),
        (changed(view={"x": {**ROLLING["x"], "centre": -2e12}}), "centre"),
        (changed(view={"words": {"tilt_rate": 1e300}}), "tilt_rate"),
        (changed(view={"x": {**ROLLING["x"], "scale": "log", "centre": 900.0}}), "x.centre"),
        (changed(view={"x": {**ROLLING["x"], "name": "tilt"}}), "y.name"),
        (changed(view={"x": {**ROLLING["x"], "name": "colour"}}), "x.name"),
        (changed(view={"words": {"alpha": 2.0}}), "alpha=2.0"),
        (changed(view={"words": {"alpha": "0.5,1"}}), "alpha"),
        (changed(view={"words": {"alpha": "x" * 2000}}), "alpha"),
        (changed(view={"words": {"starts": "/etc/passwd"}}), "words"),
        (changed(view={"words": {"model": "bead"}}), "words"),
        (changed(view={"words": {"criterion": "departure:900deg"}}), "criterion=departure:900deg"),
    ]:
        with case(fields, where):
            status, error = post_refused(url, "window" if "width" in where else "plan", **fields)
            assert (status, error["where"]) == (400, where), error
            assert error["error"].endswith(".")


def test_a_body_has_a_length_within_limits(url):
    """A body of 64 KiB is accepted; a larger one, or one without length or of another type, is refused unread."""
    padding = b" " * (64 * 1024 - 2)
    assert ask(url, "window", b"{}" + padding).status == 400
    assert ask(url, "window", b"{} " + padding).status == 413
    place = urlsplit(url)
    head = f"POST {place.path}window HTTP/1.1\r\nHost: {place.netloc}\r\n"
    for lines, status in (
        ("Content-Type: application/json\r\n", b" 411 "),
        ("Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n", b" 411 "),
        ("Content-Type: application/json\r\nContent-Length: 99999999999999999999\r\n", b" 413 "),
        ("Content-Type: application/json\r\nContent-Length: -1\r\n", b" 411 "),
        ("Content-Type: text/plain\r\nContent-Length: 2\r\n", b" 415 "),
    ):
        assert status in raw(url, f"{head}{lines}\r\n{{}}".encode()).partition(b"\r\n")[0], lines


@pytest.mark.parametrize(
    "text",
    [
        b"\r\n\r\n", b"nonsense\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\x16\x03\x01\x02\x00\x01",
        b"GET /" + b"a" * 70000 + b" HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 200 + b"\r\n",
        b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", b"\x00" * 100 + b"\r\n\r\n",
    ],
)  # fmt: skip
def test_what_is_no_http_leaves_the_server_well(url, text, capfd):
    """For any input, the connection ends without a traceback, and the next request is answered."""
    answer = raw(url, text, wait=3.0)
    assert b"Traceback" not in answer
    assert b" 200 " not in answer.partition(b"\r\n")[0]
    assert ask(url, "about").status == 200
    assert "Traceback" not in capfd.readouterr().err


def test_a_defect_is_one_sentence_to_the_page(url, monkeypatch, capfd):
    """A defect gives status 500 and one sentence; its traceback is only on standard error."""

    def broken(*_, **__):
        raise ZeroDivisionError("secret place")

    monkeypatch.setattr(answers, "lines", broken)
    status, error = post_refused(url, "lines", **changed())
    assert status == 500
    assert "secret" not in json.dumps(error)
    assert "secret place" in capfd.readouterr().err


def test_connections_that_say_nothing_hold_no_place_for_long(url, monkeypatch):
    """If silent connections take all places, a request is answered when the first of them is closed."""
    assert server._Handler.timeout <= 5.0
    monkeypatch.setattr(server._Handler, "timeout", 0.5)
    place = urlsplit(url)
    with contextlib.ExitStack() as silent:
        for _ in range(server.MOST_REQUESTS + 1):
            silent.enter_context(socket.create_connection((place.hostname, place.port), timeout=10.0))
        assert ask(url, "about").status == 200


@contextlib.contextmanager
def dripping(url, count, pause):
    """Hold this many connections, each of which sends a line of an endless head after each pause [s]."""
    place, ended = urlsplit(url), threading.Event()

    def drip(connections):
        while not ended.wait(pause):
            for connection in connections:
                with contextlib.suppress(OSError):
                    connection.sendall(b"X-More: 1\r\n")

    with contextlib.ExitStack() as opened:
        connections = [
            opened.enter_context(socket.create_connection((place.hostname, place.port), timeout=30.0))
            for _ in range(count)
        ]
        for connection in connections:
            connection.sendall(f"GET {place.path}about HTTP/1.1\r\nHost: {place.netloc}\r\n".encode())
        thread = threading.Thread(target=drip, args=(connections,))
        thread.start()
        try:
            yield connections
        finally:
            ended.set()
            thread.join()


def test_requests_that_drip_in_hold_no_place_for_long(url, monkeypatch):
    """A head that arrives line by line has the same deadline as silence, and its place is free again."""
    monkeypatch.setattr(server._Handler, "timeout", 0.6)
    with dripping(url, server.MOST_REQUESTS, 0.2) as connections:
        begun = time.monotonic()
        assert ask(url, "about").status == 200
        assert time.monotonic() - begun < server._PATIENCE
        assert {each.recv(2**16).partition(b"\r\n")[0] for each in connections} == {
            b"HTTP/1.1 408 Request Timeout"
        }


def test_a_body_that_drips_in_is_given_up(url, monkeypatch):
    """Head and body have one common deadline, however often bytes arrive."""
    monkeypatch.setattr(server._Handler, "timeout", 0.6)
    place = urlsplit(url)
    head = f"POST {place.path}window HTTP/1.1\r\nHost: {place.netloc}\r\nContent-Type: application/json\r\n"
    with socket.create_connection((place.hostname, place.port), timeout=30.0) as connection:
        connection.sendall(f"{head}Content-Length: 1000\r\n\r\n".encode())
        begun = time.monotonic()
        connection.settimeout(0.2)
        answer = b""
        while not answer and time.monotonic() - begun < 10.0:
            with contextlib.suppress(TimeoutError):
                connection.sendall(b" ")
                answer = connection.recv(2**16)
    assert answer.startswith(b"HTTP/1.1 408 ")


def test_a_request_without_room_is_told_so(url, monkeypatch):
    """If no place becomes free, a request gets status 503 with a sentence; later one is answered."""
    monkeypatch.setattr(server, "_PATIENCE", 0.2)
    with dripping(url, server.MOST_REQUESTS, 0.5):
        answer = ask(url, "about")
        assert answer.status == 503
        assert int(answer.headers["Retry-After"]) >= 1
        assert_facts(json.loads(answer.body)["error"], f"{server.MOST_REQUESTS}")
    assert ask(url, "about").status == 200


def test_only_this_machine_is_let_in(url):
    """The server listens only on the loopback address."""
    assert urlsplit(url).hostname == "127.0.0.1"
    place = urlsplit(url)
    addresses = set()
    # the machine's name may not resolve
    with contextlib.suppress(socket.gaierror):
        addresses = {each[4][0] for each in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    for address in addresses:
        if not address.startswith("127."):
            with pytest.raises(OSError), socket.create_connection((address, place.port), timeout=2.0):
                pass


def test_a_port_that_is_taken_is_refused():
    """A port in use is refused with the reason."""
    with explore() as explorer:
        port = urlsplit(explorer.url).port
        with pytest.raises(Exception, match=rf"\b{port}\b.*Address already in use"):
            explore(port=port)


def test_a_port_that_is_none_is_refused():
    """An invalid port is refused with the valid numbers."""
    for port in [-1, 65_536, 99_999_999]:
        with case(port):
            with pytest.raises(RequestError) as caught:
                explore(port=port)
            assert_facts(caught.value.message, "0", "65535", f"{port}")


@pytest.mark.slow_lane
def test_the_command_prints_the_address_and_ends_with_ctrl_c():
    """`eulerdisk explore` prints the page's address on a separate line, answers, and exits on Ctrl-C with 0."""
    for words in [[], ["rolling", "alpha=1"], ["spinning"]]:
        with case(words):
            command = [sys.executable, "-m", "sweep", "explore", "--no-browser", *words]
            environment = os.environ | {"PYTHONPATH": str(CHECKOUT)}
            with subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
            ) as running:
                url = running.stdout.readline().strip()
                assert re.fullmatch(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", url)
                first = json.loads(ask(url, "about").body)["bases"][0]
                assert first["view"]["base"] == ("" if words else "rolling")
                assert post(url, "plan", view=first["view"])["cells"]["model"] == "disk"
                running.send_signal(2)
                said = running.communicate(timeout=300)[1]
            assert running.returncode == 0, said
            assert "Traceback" not in said
