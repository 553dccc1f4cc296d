"""Waiting: simultaneous requests, slow ones, and clients that disconnect."""

import json
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack
from urllib.parse import urlsplit

import pytest
from cases import case
from explorer_client import ROLLING, ask, changed, post

import sweep
from sweep.engine.compute import compute
from sweep.explorer import lines, point, take_away, waiting
from sweep.explorer import server as server_module
from sweep.explorer.explorer import explore
from sweep.explorer.waiting import ClientGoneError

PLACE = {"x": 2.5, "y": 0.02}
ASKED = {
    "lines": (lines, {}),
    "explain": (point, PLACE),
    "data": (take_away, {"width": 8, "height": 6, "format": "csv"}),
}


def test_a_client_that_goes_away_ends_its_computation(url, monkeypatch):
    """After a client has closed its connection, no further piece of its file is computed."""
    pieces = []
    compute = take_away.compute

    def slow(*given, **more):
        pieces.append(given)
        time.sleep(0.1)
        return compute(*given, **more)

    monkeypatch.setattr(take_away, "compute", slow)
    place = urlsplit(url)
    body = json.dumps(changed(width=1000, height=1000, format="csv")).encode()
    head = (
        f"POST {place.path}data HTTP/1.1\r\nHost: {place.netloc}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    )
    with socket.create_connection((place.hostname, place.port)) as connection:
        connection.sendall(head.encode() + body)
        while not pieces:
            time.sleep(0.01)
    before = -1
    while len(pieces) > before:
        before = len(pieces)
        time.sleep(1.0)
    # a million cells are 62 pieces
    assert len(pieces) < 31


def test_closing_ends_all_threads():
    """After `close`, nothing answers, no thread is left, and closing again is harmless."""
    before = set(threading.enumerate())
    explorer = explore()
    url = explorer.url
    assert ask(url, "about").status == 200
    explorer.close()
    explorer.close()
    with pytest.raises(ConnectionError):
        ask(url, "about")
    for _ in range(50):
        if not set(threading.enumerate()) - before:
            break
        time.sleep(0.1)
    assert set(threading.enumerate()) - before == set()


def test_an_explanation_that_takes_long_holds_up_no_map(url, monkeypatch):
    """While a point is explained, lines are answered, because kernels are locked only while they compute."""
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
        shown = pool.submit(post, url, "lines", view=ROLLING)
        try:
            assert shown.result(10.0)["lines"]
        finally:
            end.set()
        assert b"It was long." in first.result().body


def test_requests_at_once_are_all_answered(monkeypatch):
    """Hundreds of simultaneous connections are answered with the same numbers, and none is reset."""
    asked = json.dumps({"view": ROLLING}).encode()
    for room in (server_module.MOST_REQUESTS, 2):
        monkeypatch.setattr(server_module, "MOST_REQUESTS", room)
        with explore() as explorer, ExitStack() as stack:
            place = urlsplit(explorer.url)
            host = f"Host: {place.netloc}\r\n"
            posted = f"POST {place.path}plan HTTP/1.1\r\n{host}Content-Type: application/json\r\n"
            texts = (
                f"GET {place.path}page/main.js HTTP/1.1\r\n{host}\r\n".encode(),
                f"{posted}Content-Length: {len(asked)}\r\n\r\n".encode() + asked,
            )
            opened = []
            for i in range(300):
                connection = stack.enter_context(
                    socket.create_connection((place.hostname, place.port), timeout=60.0)
                )
                connection.sendall(texts[i % 2])
                opened.append(connection)
            answers = [b"".join(iter(lambda each=each: each.recv(2**16), b"")) for each in opened]
            with case(room):
                assert {each.partition(b"\r\n")[0] for each in answers} == {b"HTTP/1.1 200 OK"}
                assert len(set(answers[::2])) == 1
                assert len({each.partition(b"\r\n\r\n")[2] for each in answers[1::2]}) == 1


def test_a_request_waits_for_room(monkeypatch):
    """If a silent connection takes the only place, another waits and is answered when the first has gone."""
    monkeypatch.setattr(server_module, "MOST_REQUESTS", 1)
    with explore() as explorer, ThreadPoolExecutor(1) as pool:
        place = urlsplit(explorer.url)
        with socket.create_connection((place.hostname, place.port)):
            asked = pool.submit(ask, explorer.url, "about")
            assert not wait([asked], timeout=0.5).done
        assert asked.result().status == 200


def test_kernels_of_maps_are_called_in_turns(url, monkeypatch):
    """A thread that computes cells holds the kernel lock, because kernels use all processors."""
    held = []

    def watched(*given, **named):
        held.append(waiting.KERNELS._is_owned())
        return compute(*given, **named)

    for path, (module, fields) in ASKED.items():
        held.clear()
        monkeypatch.setattr(module, "compute", watched)
        body = json.dumps({"view": ROLLING, **fields}).encode()
        assert ask(url, path, body).status == 200
        assert held, path
        assert all(held), path


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """Return the path of a small atlas."""
    path = tmp_path_factory.mktemp("turns") / "rolling.nc"
    sweep.run_to_file(
        "rolling", path, roll_rate="2:4:6", tilt="0.1deg:10deg:5:log", method="exact", progress=False
    )
    return path


def test_a_file_is_read_in_turns_and_not_after_it_is_closed(file):
    """A window of stored cells waits for other readers; nothing is read after closing."""
    with explore(file) as explorer, ThreadPoolExecutor(1) as pool:
        stored = explorer._subject.stored
        view = json.loads(ask(explorer.url, "about").body)["bases"][0]["view"]
        asked = {"view": view, "width": 6, "height": 5, "quantity": "peak_tilt", "stored": True}
        with stored._lock:
            found = pool.submit(post, explorer.url, "window", **asked)
            assert not wait([found], timeout=0.5).done
        assert found.result()[1]["stored"].all()
    with pytest.raises(ClientGoneError), stored._reading():
        pytest.fail("A file that is closed was read.")
