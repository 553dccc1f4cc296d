"""Connections to the explorer: many at once, slow ones, and ones whose client goes away."""

import contextlib
import json
import os
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from urllib.parse import urlsplit

import pytest
from explorer_client import ROLLING, ask, changed, post, raw, refused

import sweep
from sweep.explorer import motion as motion_module
from sweep.explorer import server as server_module
from sweep.explorer import turns
from sweep.explorer import window as window_module
from sweep.explorer.explorer import explore


@pytest.fixture(scope="module")
def url():
    """Return the address of an explorer of the presets."""
    with explore() as explorer:
        yield explorer.url


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


def test_a_motion_that_takes_long_holds_up_no_map(url, monkeypatch):
    """While a motion is followed windows and points are answered; another motion is told to wait."""
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
        # it is no refusal, which browsers would write into their consoles
        words = post(url, "motion", view=ROLLING, x=3.0, y=0.01)
        assert (words["busy"], words["where"]) == (True, "motion")
        end.set()
        assert b"It was long." in first.result().body


def test_nobody_waits_for_a_motion_whose_kernel_is_compiled(url, monkeypatch):
    """Compiling takes many seconds on a busy machine: a motion that has its kernel is followed meanwhile."""
    begun, end = threading.Event(), threading.Event()
    ordinary = motion_module.make_ready

    def endless(spec, losses):
        if not losses:
            return ordinary(spec, losses)
        begun.set()
        return end.wait(30.0)

    monkeypatch.setattr(motion_module, "make_ready", endless)
    monkeypatch.setattr(turns, "PATIENCE", 0.2)
    with ThreadPoolExecutor(1) as pool:
        asked = {"view": ROLLING, "x": 3.0, "y": 0.01}
        first = pool.submit(post, url, "motion", **asked, losses={"rolling_friction": 1e-3})
        assert begun.wait(10.0)
        assert post(url, "motion", **asked)[1]["time"].size > 100
        end.set()
        assert first.result()[1]["time"].size > 100


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
