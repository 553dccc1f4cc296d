"""A client of the explorer without any of the server's code: HTTP, JSON and little-endian arrays."""

import contextlib
import http.client
import json
import socket
import struct
from types import SimpleNamespace
from urllib.parse import urlsplit

import numpy as np

ROLLING = {
    "base": "rolling",
    "words": {},
    "x": {"name": "roll_rate", "centre": 3.0, "half": 1.0, "scale": "linear"},
    "y": {"name": "tilt", "centre": -4.0, "half": 2.0, "scale": "log"},
}


def side(name, centre, half, scale="linear"):
    """Return one side of a window in the form of a request."""
    return {"name": name, "centre": centre, "half": half, "scale": scale}


def about(url):
    """Return the page's first request, `about`."""
    return json.loads(ask(url, "about").body)


def ask(url, path="", body=None, method=None, headers=None):
    """Ask the server at an address; return its status, headers and body."""
    place = urlsplit(url)
    connection = http.client.HTTPConnection(place.hostname, place.port, timeout=60)
    try:
        given = {"Content-Type": "application/json"} if body is not None else {}
        connection.putrequest(
            method or ("GET" if body is None else "POST"), place.path + path, skip_host=True
        )
        sent = {"Host": place.netloc, **given, **(headers or {})}
        if body is not None:
            sent.setdefault("Content-Length", str(len(body)))
        for name, value in sent.items():
            connection.putheader(name, value)
        connection.endheaders(body)
        answer = connection.getresponse()
        return SimpleNamespace(status=answer.status, headers=answer.headers, body=answer.read())
    finally:
        connection.close()


def post(url, path, **fields):
    """Post fields as JSON; return the object, or the head and arrays of a binary answer."""
    answer = ask(url, path, json.dumps(fields).encode())
    assert answer.status == 200, answer.body
    return (
        json.loads(answer.body)
        if answer.headers["Content-Type"] == "application/json"
        else unpacked(answer.body)
    )


def post_refused(url, path, **fields):
    """Post fields that are refused; return the status and the error."""
    answer = ask(url, path, json.dumps(fields).encode())
    assert answer.status != 200
    return answer.status, json.loads(answer.body)


def unpacked(body):
    """Return the head and the arrays of a binary answer."""
    (length,) = struct.unpack("<I", body[:4])
    head, at, arrays = json.loads(body[4 : 4 + length]), 4 + length, {}
    assert at % 8 == 0
    for each in head["arrays"]:
        kind = np.dtype(each["type"]).newbyteorder("<")
        arrays[each["name"]] = np.frombuffer(body, kind, each["count"], at)
        at += each["count"] * kind.itemsize
    assert at == len(body)
    return head, arrays


def raw(url, text, wait=10.0):
    """Send bytes to the server, and return its answer up to the end of the connection."""
    place, found = urlsplit(url), b""
    with socket.create_connection((place.hostname, place.port), timeout=wait) as connection:
        connection.sendall(text)
        with contextlib.suppress(TimeoutError, ConnectionError):
            while part := connection.recv(65536):
                found += part
    return found


def changed(**changes):
    """Return a request for a window with other fields."""
    view = {**ROLLING, **changes.pop("view", {})}
    return {"view": view, "width": 8, "height": 8, "quantity": "peak_tilt", **changes}
