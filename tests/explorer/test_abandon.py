"""Motions that nobody waits for any more: the server does not follow them to their end."""

import json
import socket
import time
from urllib.parse import urlsplit

import numpy as np
import pytest
from explorer_client import ROLLING, post

from sweep.explorer.abandon import abandoned_with
from sweep.explorer.explorer import explore
from sweep.explorer.motion import motion
from sweep.explorer.turns import SupersededError
from sweep.request.spec import SweepSpec

#: A coin that hardly loses anything: two seconds of work.
COIN = {"tilt": 0.3, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 30.0}
COIN |= {"alpha": 0.5, "radius": 0.005, "gravity": 9.81}
LOSSES = {"contour_friction": 1e-8}


def work(check):
    """Return the processor time [s] of this thread for following the coin, and whether it was given up."""
    begun = time.thread_time()
    try:
        with abandoned_with(check) as times:
            motion(SweepSpec.preset("rolling"), COIN, None, LOSSES, times)
    except SupersededError:
        return time.thread_time() - begun, True
    return time.thread_time() - begun, False


def test_a_motion_ends_when_nobody_waits_for_it():
    """A motion whose page has gone after a moment takes a small part of the time of one that is waited for."""
    whole, given_up = work(lambda: None)
    assert not given_up
    looks = []

    def gone_at_the_second_look():
        looks.append(1)
        if len(looks) > 1:
            raise SupersededError

    part, given_up = work(gone_at_the_second_look)
    assert given_up
    assert part < 0.4 * whole


def test_a_motion_is_the_same_while_it_is_watched():
    """Looking whether somebody waits changes no bit of a motion."""
    spec = SweepSpec.preset("rolling")
    start = COIN | {"roll_rate": 12.0, "radius": 0.05}
    for losses in ({}, LOSSES):
        _, plain = motion(spec, start, 3.0, losses)
        with abandoned_with(lambda: None) as begun:
            _, watched = motion(spec, start, 3.0, losses, begun)
        assert plain.keys() == watched.keys()
        assert all(np.array_equal(plain[name], watched[name], equal_nan=True) for name in plain)


@pytest.mark.parametrize("waiting", [0, 2])
def test_a_motion_does_not_wait_for_those_whose_pages_have_gone(waiting):
    """After pages that asked for long motions have closed their connections the next motion comes soon."""
    view = {**ROLLING, "words": {"radius": 0.005}}
    body = json.dumps({"view": view, "x": 30.0, "y": 0.3, "losses": LOSSES}).encode()
    with explore() as explorer:
        place = urlsplit(explorer.url)
        head = (
            f"POST {place.path}motion HTTP/1.1\r\nHost: {place.netloc}\r\nContent-Type: application/json\r\n"
        )
        post(explorer.url, "motion", view=ROLLING, x=3.0, y=0.01, losses=LOSSES)
        connections = [socket.create_connection((place.hostname, place.port)) for _ in range(1 + waiting)]
        for connection in connections:
            connection.sendall(f"{head}Content-Length: {len(body)}\r\n\r\n".encode() + body)
        time.sleep(0.2)
        for connection in connections:
            connection.close()
        begun = time.process_time()
        post(explorer.url, "motion", view=ROLLING, x=3.0, y=0.01)
        # of all threads; the long ones would take some two seconds each
        assert time.process_time() - begun < 0.8
