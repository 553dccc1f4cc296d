"""Who waits for what: requests at once, slow ones, and ones whose client goes away."""

import json
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import ExitStack
from urllib.parse import urlsplit

import numpy as np
import pytest
from cases import case
from explorer_client import ROLLING, ask, changed, post

import sweep
from sweep.engine.compute import compute
from sweep.explorer import lines, point, take_away, waiting
from sweep.explorer import motion as motion_module
from sweep.explorer import server as server_module
from sweep.explorer import window as window_module
from sweep.explorer.explorer import explore
from sweep.explorer.motion import motion
from sweep.explorer.waiting import ClientGoneError, ended_with
from sweep.request.spec import SweepSpec

PLACE = {"x": 2.5, "y": 0.02}
ASKED = {
    "window": (window_module, {"width": 8, "height": 6, "quantity": "peak_tilt"}),
    "point": (point, PLACE),
    "lines": (lines, {}),
    "data": (take_away, {"width": 8, "height": 6, "format": "csv"}),
}

#: A coin that hardly loses anything: two seconds of work.
COIN = {"tilt": 0.3, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 30.0}
COIN |= {"alpha": 0.5, "radius": 0.005, "gravity": 9.81}
LOSSES = {"contour_friction": 1e-8}


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


def test_closing_ends_all_threads():
    """After `close` nobody answers, no thread of the explorer is left, and closing once more does no harm."""
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


def test_a_motion_that_takes_long_holds_up_no_map(url, monkeypatch):
    """While a motion is followed windows and points are answered; another motion waits for its end."""
    begun, end = threading.Event(), threading.Event()

    def endless(*_):
        begun.set()
        end.wait(30.0)
        raise sweep.RequestError("It was long.")

    monkeypatch.setattr(motion_module, "motion", endless)
    body = json.dumps({"view": ROLLING, "x": 3.0, "y": 0.01}).encode()
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(ask, url, "motion", body)
        assert begun.wait(10.0)
        assert post(url, "window", **changed())[0]["width"] == 8
        assert ask(url, "point", body).status == 200
        second = pool.submit(ask, url, "motion", body)
        assert not wait([second], timeout=0.5).done
        end.set()
        assert b"It was long." in first.result().body
        assert b"It was long." in second.result().body


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


def test_requests_at_once_are_all_answered(monkeypatch):
    """Hundreds of connections that are opened at once are answered, each with the same numbers, and none is reset."""
    window = json.dumps(changed(width=64, height=48)).encode()
    for room in (server_module.MOST_REQUESTS, 2):
        monkeypatch.setattr(server_module, "MOST_REQUESTS", room)
        with explore() as explorer, ExitStack() as stack:
            place = urlsplit(explorer.url)
            host = f"Host: {place.netloc}\r\n"
            posted = f"POST {place.path}window HTTP/1.1\r\n{host}Content-Type: application/json\r\n"
            texts = (
                f"GET {place.path}page/main.js HTTP/1.1\r\n{host}\r\n".encode(),
                f"{posted}Content-Length: {len(window)}\r\n\r\n".encode() + window,
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
                assert len({each[-64 * 48 * 5 :] for each in answers[1::2]}) == 1


def test_a_request_waits_for_room(monkeypatch):
    """While a silent connection has the only room another one waits, and is answered when the first has gone."""
    monkeypatch.setattr(server_module, "MOST_REQUESTS", 1)
    with explore() as explorer, ThreadPoolExecutor(1) as pool:
        place = urlsplit(explorer.url)
        with socket.create_connection((place.hostname, place.port)):
            asked = pool.submit(ask, explorer.url, "about")
            assert not wait([asked], timeout=0.5).done
        assert asked.result().status == 200


def test_kernels_of_maps_are_called_in_turns(url, monkeypatch):
    """A thread that computes cells has the lock of the kernels: they use all processors by themselves."""
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
    """Return the file of a small atlas."""
    path = tmp_path_factory.mktemp("turns") / "rolling.nc"
    sweep.run_to_file(
        "rolling", path, roll_rate="2:4:6", tilt="0.1deg:10deg:5:log", method="exact", progress=False
    )
    return path


def test_a_file_is_read_in_turns_and_not_after_it_is_closed(file):
    """A window of stored cells waits while somebody else reads; what comes after the end reads nothing."""
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


def work(check):
    """Return the processor time [s] of this thread for following the coin, and whether it was given up.

    `check` is called with whether the integration has begun.
    """
    begun, integrating = time.thread_time(), threading.Event()

    def noted(times, begin):
        begin(times)
        integrating.set()

    try:
        with ended_with(lambda: check(integrating.is_set())) as begin:
            motion(SweepSpec.preset("rolling"), COIN, None, LOSSES, lambda times: noted(times, begin))
    except ClientGoneError:
        return time.thread_time() - begun, True
    return time.thread_time() - begun, False


def test_a_motion_ends_when_nobody_waits_for_it():
    """A motion whose page has gone after a moment takes a small part of the time of one that is waited for."""
    # kernels are compiled, and modules loaded, before it is timed
    motion(SweepSpec.preset("rolling"), COIN, 0.01, LOSSES)
    whole, given_up = work(lambda integrating: None)
    assert not given_up

    def gone_while_it_is_integrated(integrating):
        if integrating:
            raise ClientGoneError

    part, given_up = work(gone_while_it_is_integrated)
    assert given_up
    assert part < 0.4 * whole


def test_a_motion_is_the_same_while_it_is_watched():
    """Looking whether somebody waits changes no bit of a motion."""
    spec = SweepSpec.preset("rolling")
    start = COIN | {"roll_rate": 12.0, "radius": 0.05}
    for losses in ({}, LOSSES):
        _, plain = motion(spec, start, 3.0, losses)
        with ended_with(lambda: None) as begun:
            _, watched = motion(spec, start, 3.0, losses, begun)
        assert plain.keys() == watched.keys()
        assert all(np.array_equal(plain[name], watched[name], equal_nan=True) for name in plain)


def test_a_motion_does_not_wait_for_those_whose_pages_have_gone():
    """After pages that asked for long motions have closed their connections the next motion comes soon."""
    view = {**ROLLING, "words": {"radius": 0.005}}
    body = json.dumps({"view": view, "x": 30.0, "y": 0.3, "losses": LOSSES}).encode()
    with explore() as explorer:
        place = urlsplit(explorer.url)
        head = (
            f"POST {place.path}motion HTTP/1.1\r\nHost: {place.netloc}\r\nContent-Type: application/json\r\n"
        )
        post(explorer.url, "motion", view=ROLLING, x=3.0, y=0.01, losses=LOSSES)
        connections = [socket.create_connection((place.hostname, place.port)) for _ in range(3)]
        for connection in connections:
            connection.sendall(f"{head}Content-Length: {len(body)}\r\n\r\n".encode() + body)
        time.sleep(0.2)
        for connection in connections:
            connection.close()
        begun = time.process_time()
        post(explorer.url, "motion", view=ROLLING, x=3.0, y=0.01)
        # of all threads; the long ones would take some two seconds each
        assert time.process_time() - begun < 0.8
