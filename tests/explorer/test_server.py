import contextlib
import json
import os
import re
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import urlsplit

import pytest
from explorer_client import ROLLING, ask, post, refused

import sweep
from sweep.explorer import motion as motion_module
from sweep.explorer import server as server_module
from sweep.explorer import turns
from sweep.explorer import window as window_module
from sweep.explorer.explorer import explore

CHECKOUT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def url():
    """Return the address of an explorer of the presets."""
    with explore() as explorer:
        yield explorer.url


def raw(url, text, wait=10.0):
    """Send bytes to the server, and return all that it answers until it closes the connection."""
    place, found = urlsplit(url), b""
    with socket.create_connection((place.hostname, place.port), timeout=wait) as connection:
        connection.sendall(text)
        with contextlib.suppress(TimeoutError, ConnectionError):
            while part := connection.recv(65536):
                found += part
    return found


def test_the_page_is_sent_with_a_policy_that_lets_nothing_else_in(url):
    """The page comes with a policy without foreign or inline scripts, and no answer is kept or guessed at."""
    page = ask(url)
    assert page.status == 200
    assert page.headers["Content-Type"] == "text/html; charset=utf-8"
    policy = dict(part.strip().split(" ", 1) for part in page.headers["Content-Security-Policy"].split(";"))
    assert policy["default-src"] == "'self'"
    assert "unsafe" not in page.headers["Content-Security-Policy"]
    assert "http" not in policy["script-src"]
    assert (page.headers["X-Content-Type-Options"], page.headers["Cache-Control"]) == ("nosniff", "no-store")


def test_every_file_of_the_page_is_sent_with_its_type(url):
    """Every module, style and picture of the package is sent byte for byte; nothing else has an address."""
    folder = CHECKOUT / "sweep" / "explorer" / "page"
    kinds = {".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8"}
    files = [path for path in folder.rglob("*") if path.suffix in kinds]
    assert files
    for path in files:
        sent = ask(url, f"page/{path.relative_to(folder).as_posix()}")
        assert (sent.status, sent.headers["Content-Type"]) == (200, kinds[path.suffix])
        assert sent.body == path.read_bytes()
    assert ask(url, "page/vendor/SOURCES.toml").status == 404


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "evil.example"},
        {"Host": "127.0.0.1"},
        {"Host": "127.0.0.1:1"},
        {"Host": ""},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site", "Sec-Fetch-Mode": "cors"},
    ],
)
@pytest.mark.parametrize("path", ["about", "window"])
def test_another_host_or_site_is_refused(url, headers, path):
    """A name that leads here and is not this machine's, and pages of other sites, get nothing but a refusal."""
    body = json.dumps(changed()).encode() if path == "window" else None
    assert ask(url, path, body).status == 200
    answer = ask(url, path, body, headers=headers)
    assert answer.status == 403
    assert set(json.loads(answer.body)) == {"error", "hint", "where"}


def test_a_notebook_may_frame_the_page_and_no_more(url):
    """A frame or a link of another page opens the page itself; what it asks then is of the same origin."""
    opened = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "iframe"}
    assert ask(url, headers=opened).status == 200
    assert ask(url, "about", headers=opened).status == 403


def test_the_token_is_needed(url):
    """Without the token, with another one or one in another place there is nothing, not even the name of a file."""
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


@pytest.mark.parametrize(
    "path",
    [
        "page/../server.py", "page/../../pyproject.toml", "page/%2e%2e/server.py", "page//etc/passwd", "../", "page/",
        "page/..%2fserver.py", "page/vendor/../../guard.py", "page/index.html/", "/etc/passwd", "page/\\..\\guard.py",
        "about/", "about?x=1", "page/main.js?x", "window/../about", "nothing",
    ],
)  # fmt: skip
def test_no_path_leads_out_of_the_page(url, path):
    """Only the addresses of a fixed list are answered: no path is put together from what is asked."""
    answer = ask(url, path.replace("\\", "%5c"))
    assert answer.status == 404
    assert b"import" not in answer.body


def test_methods_have_their_addresses(url):
    """A question is posted, a file is fetched; other methods are none."""
    assert ask(url, "window").status == 405
    assert ask(url, "about", b"{}").status == 405
    assert ask(url, "nothing", b"{}").status == 404
    for method in ("PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "PATCH"):
        assert ask(url, "about", method=method).status in (403, 501)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (b"", "cannot be read"),
        (b"{", "cannot be read"),
        (b"[]", "an object"),
        (b"\xff\xfe", "cannot be read"),
        (b"[" * 60000, "cannot be read"),
        (b'{"view": 1}', "view must be an object"),
        (b'{"view": NaN}', "no number"),
        (b'{"view": {"base": "/etc/passwd.toml"}}', "base must be one of"),
        (b'{"view": {"base": "rolling", "x": {}, "y": {}}}', "name must be text"),
    ],
)
def test_a_malformed_request_is_refused_in_words(url, body, said):
    """What is no request gets status 400 with a sentence, and the server goes on."""
    answer = ask(url, "window", body)
    assert answer.status == 400
    assert said in json.loads(answer.body)["error"]
    assert ask(url, "about").status == 200


def changed(**changes):
    """Return a request for a window with other fields."""
    view = {**ROLLING, **changes.pop("view", {})}
    return {"view": view, "width": 8, "height": 8, "quantity": "peak_tilt", **changes}


@pytest.mark.parametrize(
    ("fields", "where"),
    [
        (changed(width=0), "width"),
        (changed(width=2.5), "width"),
        (changed(width=True), "width"),
        (changed(width=10**9), "width"),
        (changed(width=2001, height=2000), "width * height"),
        (changed(quantity="secret"), "quantity"),
        (changed(number=-1), "number"),
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
        (changed(view={"words": {"criterion": "aloft:10s"}}), "criterion"),
    ],
)
def test_an_impossible_request_names_the_field(url, fields, where):
    """A value that is not possible gets status 400, with a sentence and the name of the field."""
    status, error = refused(url, "window", **fields)
    assert (status, error["where"]) == (400, where), error
    assert error["error"].endswith(".")


def test_a_body_has_a_length_within_limits(url):
    """A body of 64 KiB is read; a larger one, one of no stated length or of another type is refused unread."""
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
    """Whatever arrives, the connection ends without a trace of the program, and the next request is answered."""
    answer = raw(url, text, wait=3.0)
    assert b"Traceback" not in answer
    assert b" 200 " not in answer.partition(b"\r\n")[0]
    assert ask(url, "about").status == 200
    assert "Traceback" not in capfd.readouterr().err


def test_a_defect_is_one_sentence_to_the_page(url, monkeypatch, capfd):
    """A defect gets status 500 and one sentence; where it is stands on standard error alone."""

    def broken(*_, **__):
        raise ZeroDivisionError("secret place")

    monkeypatch.setattr(window_module, "compute", broken)
    status, error = refused(url, "window", **changed())
    assert status == 500
    assert "secret" not in json.dumps(error)
    assert "secret place" in capfd.readouterr().err


def test_a_hundred_requests_at_once_are_answered(url):
    """A hundred clients that ask at once are all answered, by a bounded number of threads."""
    before = threading.active_count()
    body = json.dumps(changed(width=64, height=48)).encode()
    most = 0
    with ThreadPoolExecutor(100) as pool:
        waiting = [pool.submit(ask, url, "window", body) for _ in range(100)]
        while not all(each.done() for each in waiting):
            most = max(most, threading.active_count())
            time.sleep(0.01)
    answers = [each.result() for each in waiting]
    assert [each.status for each in answers] == [200] * 100
    # of the same cells the same numbers, whoever asks and beside whom
    assert len({each.body[-64 * 48 * 5 :] for each in answers}) == 1
    assert most <= before + 100 + server_module.MOST_CONNECTIONS


def test_more_connections_than_there_is_room_for_are_told_so(monkeypatch):
    """A connection beyond the most that are served gets status 503, and room that becomes free is given again."""
    monkeypatch.setattr(server_module, "MOST_CONNECTIONS", 2)
    with explore() as explorer:
        place = urlsplit(explorer.url)
        held = [socket.create_connection((place.hostname, place.port)) for _ in range(2)]
        time.sleep(0.2)
        assert raw(explorer.url, b"").startswith(b"HTTP/1.1 503 ")
        for each in held:
            each.close()
        for _ in range(50):
            answer = raw(explorer.url, b"GET / HTTP/1.1\r\n\r\n", wait=2.0)
            if b" 503 " not in answer.partition(b"\r\n")[0]:
                break
            time.sleep(0.1)
        assert b" 403 " in answer.partition(b"\r\n")[0]


def test_a_request_that_drips_in_is_ended(monkeypatch):
    """A client that sends a byte now and then is cut off, and keeps no thread; so is one that sends nothing."""
    monkeypatch.setattr(server_module, "ARRIVAL", 0.5)
    with explore() as explorer:
        place = urlsplit(explorer.url)
        with socket.create_connection((place.hostname, place.port), timeout=5.0) as connection:
            begun = time.monotonic()
            text = f"POST {place.path}window HTTP/1.1\r\nHost: {place.netloc}\r\nContent-Length: 60\r\n\r\n"
            # ten seconds for all of it
            with contextlib.suppress(ConnectionError):
                for byte in text.encode() + b" " * 60:
                    connection.sendall(bytes([byte]))
                    time.sleep(0.05)
                assert connection.recv(100) == b""
            assert 0.4 < time.monotonic() - begun < 3.0
        assert ask(explorer.url, "about").status == 200


def test_a_client_that_goes_away_ends_its_computation(url, monkeypatch):
    """After a client has closed its connection no further piece of its window is computed."""
    pieces = []
    compute = window_module.compute

    def slow(*given, **more):
        pieces.append(time.monotonic())
        time.sleep(0.1)
        return compute(*given, **more)

    monkeypatch.setattr(window_module, "compute", slow)
    place = urlsplit(url)
    body = json.dumps(changed(width=2000, height=1000)).encode()
    head = (
        f"POST {place.path}window HTTP/1.1\r\nHost: {place.netloc}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    )
    with socket.create_connection((place.hostname, place.port)) as connection:
        connection.sendall(head.encode() + body)
        time.sleep(0.3)
    gone = time.monotonic()
    time.sleep(0.6)
    assert pieces
    assert max(pieces) < gone + 0.2


def test_the_latest_request_of_a_lane_wins(url, monkeypatch):
    """A newer request of the same client and lane ends the older one with status 410; other lanes go on."""
    compute, begun = window_module.compute, threading.Event()

    def slow(*given, **more):
        begun.set()
        time.sleep(0.05)
        return compute(*given, **more)

    monkeypatch.setattr(window_module, "compute", slow)
    large = changed(width=1000, height=400, client="a", lane="fine", number=1)
    with ThreadPoolExecutor(4) as pool:
        old = pool.submit(ask, url, "window", json.dumps(large).encode())
        other = pool.submit(
            ask, url, "window", json.dumps({**large, "lane": "coarse", "height": 100}).encode()
        )
        begun.wait(10.0)
        new = pool.submit(ask, url, "window", json.dumps(changed(client="a", lane="fine", number=2)).encode())
        assert [each.result().status for each in (old, new, other)] == [410, 200, 200]
    assert json.loads(old.result().body)["error"] == "superseded"
    assert refused(url, "window", **changed(client="a", lane="fine", number=1))[0] == 410


def test_a_connection_answers_many_requests(url):
    """A connection is kept: a hundred requests need one."""
    place = urlsplit(url)
    text = f"GET {place.path}about HTTP/1.1\r\nHost: {place.netloc}\r\n\r\n"
    last = f"GET {place.path}about HTTP/1.1\r\nHost: {place.netloc}\r\nConnection: close\r\n\r\n"
    assert raw(url, (text * 99 + last).encode()).count(b"HTTP/1.1 200 OK") == 100


def test_only_this_machine_is_let_in(url):
    """The server listens at the loopback address alone."""
    assert urlsplit(url).hostname == "127.0.0.1"
    place = urlsplit(url)
    for address in {each[4][0] for each in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}:
        if not address.startswith("127."):
            with pytest.raises(OSError), socket.create_connection((address, place.port), timeout=2.0):
                pass


def test_a_port_that_is_taken_is_refused():
    """A port in use is refused in words."""
    with explore() as explorer:
        port = urlsplit(explorer.url).port
        with pytest.raises(Exception, match=f"cannot listen at port {port}"):
            explore(port=port)


@pytest.mark.parametrize("words", [[], ["rolling", "alpha=1"], ["spinning"]])
def test_the_command_prints_the_address_and_ends_with_ctrl_c(words):
    """`eulerdisk explore` prints the address of its page on a line of its own, answers, and ends on Ctrl-C with 0."""
    command = [sys.executable, "-m", "sweep", "explore", "--no-browser", *words]
    environment = os.environ | {"PYTHONPATH": str(CHECKOUT)}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as running:
        url = running.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", url)
        first = json.loads(ask(url, "about").body)["bases"][0]
        assert first["view"]["base"] == ("" if words else "rolling")
        assert (
            post(url, "window", view=first["view"], width=8, height=8, quantity="peak_tilt")[0]["width"] == 8
        )
        running.send_signal(2)
        said = running.communicate(timeout=20)[1]
    assert running.returncode == 0, said
    assert "Traceback" not in said


def test_closing_ends_all_threads_and_connections():
    """After `close` nobody answers, no thread of the explorer is left, and closing once more does no harm."""
    before = set(threading.enumerate())
    explorer = explore()
    url = explorer.url
    place = urlsplit(url)
    with socket.create_connection((place.hostname, place.port)) as idle:
        assert ask(url, "about").status == 200
        explorer.close()
        explorer.close()
        assert idle.recv(1) == b""
    with pytest.raises(ConnectionError):
        ask(url, "about")
    for _ in range(50):
        if not set(threading.enumerate()) - before:
            break
        time.sleep(0.1)
    assert set(threading.enumerate()) - before == set()


def test_a_start_without_a_motion_is_answered_in_words(url):
    """A disk that lifts off at once has no motion with losses: the page is told, and nothing stands in its console."""
    words = {"alpha": 0.3901, "tilt_rate": -0.696, "precession_rate": -0.66, "gravity": 0.2075}
    place = {"view": ROLLING | {"words": words}, "x": -0.28, "y": 1e-20}
    place["losses"] = {"rolling_friction": 1e-5}
    answer = ask(url, "motion", json.dumps(place).encode())
    assert (answer.status, answer.headers["Content-Type"]) == (200, "application/json")
    assert "lifts off" in json.loads(answer.body)["error"]
    assert refused(url, "motion", **place | {"x": "far"})[1]["where"] == "x"


def test_a_motion_that_takes_long_holds_up_no_map(url, monkeypatch):
    """While a motion is followed windows and points are answered; another motion is refused after some time."""
    begun, end = threading.Event(), threading.Event()

    def endless(*_):
        begun.set()
        end.wait(30.0)
        raise sweep.RequestError("It was long.")

    monkeypatch.setattr(motion_module, "motion", endless)
    monkeypatch.setattr(turns, "PATIENCE", 0.2)
    body = json.dumps({"view": ROLLING, "x": 3.0, "y": 0.01}).encode()
    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(ask, url, "motion", body)
        assert begun.wait(10.0)
        assert post(url, "window", **changed())[0]["width"] == 8
        assert ask(url, "point", body).status == 200
        assert refused(url, "motion", view=ROLLING, x=3.0, y=0.01)[1]["where"] == "motion"
        end.set()
        assert b"It was long." in first.result().body


def test_an_explanation_that_takes_long_holds_up_no_map(url, monkeypatch):
    """While a point is explained windows are answered: the kernels are held while they compute, and no longer."""
    begun, end = threading.Event(), threading.Event()

    def endless(*_):
        begun.set()
        end.wait(30.0)
        raise sweep.RequestError("It was long.")

    monkeypatch.setattr("sweep.checks.explain.explain", endless)
    body = json.dumps({"view": ROLLING, "x": 3.0, "y": 0.01}).encode()
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(ask, url, "explain", body)
        assert begun.wait(10.0)
        shown = pool.submit(post, url, "window", **changed())
        try:
            assert shown.result(10.0)[0]["width"] == 8
        finally:
            end.set()
        assert b"It was long." in first.result().body


def test_two_large_windows_are_computed_at_a_time(url, monkeypatch):
    """Of windows of more than a million pixels two are in memory at once; small ones do not wait for them."""
    inside, most = [], []
    pixels = window_module.pixels

    def noted(*arguments):
        inside.append(1)
        most.append(len(inside))
        time.sleep(0.3)
        try:
            return pixels(*arguments)
        finally:
            inside.pop()

    monkeypatch.setattr(window_module, "pixels", noted)
    monkeypatch.setattr(window_module, "LARGE", 1000)
    with ThreadPoolExecutor(5) as pool:
        asked = [changed(width=40, height=30, client=f"{i}") for i in range(5)]
        large = [pool.submit(post, url, "window", **fields) for fields in asked]
        assert all(each.result()[0]["width"] == 40 for each in large)
        assert max(most) == 2
        small = [pool.submit(post, url, "window", **changed(client=f"s{i}")) for i in range(5)]
        assert all(each.result()[0]["width"] == 8 for each in small)
    assert max(most) > 2


def test_a_client_that_has_gone_is_seen_whatever_its_descriptor():
    """With more than a thousand open files it is still seen whether a client waits: select.select() could not."""
    resource = pytest.importorskip("resource")
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < 1200:
        pytest.skip("this system lets nobody open as many files")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, 1200), hard))
    try:
        with contextlib.ExitStack() as held:
            for _ in range(1050):
                held.enter_context(open(os.devnull))
            here, there = map(held.enter_context, socket.socketpair())
            assert here.fileno() >= 1024
            handler = SimpleNamespace(connection=here)
            assert not server_module._Handler._gone(handler)
            there.sendall(b"x")
            assert not server_module._Handler._gone(handler)
            here.recv(1)
            there.close()
            assert server_module._Handler._gone(handler)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
