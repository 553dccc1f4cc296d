"""What is answered: one function for every address that the page asks."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import NoMotionError
from sweep.explorer.about import about
from sweep.explorer.fields import read_count, read_number, read_object, read_text
from sweep.explorer.lines import lines
from sweep.explorer.point import place, point
from sweep.explorer.stored import Stored
from sweep.explorer.view import View
from sweep.explorer.waiting import MOTIONS, Lanes, ended_with, still_there, turn
from sweep.explorer.window import window
from sweep.request.spec import SweepSpec

JSON, BINARY = "application/json", "application/octet-stream"

#: The largest number that a page may give a request.
_MOST_NUMBER = 2**53


#: What answers: called with the fields of a request, and with what tells whether the client has gone.
_Answering = Callable[[Mapping[str, Any], Callable[[], bool]], "Answer"]


@dataclass(frozen=True)
class Answer:
    """What is sent: a type, and an object for JSON, parts of bytes, or an open file, which the server closes."""

    kind: str
    content: Any
    headers: Mapping[str, str] = field(default_factory=dict)
    status: int = 200


class Answers:
    """All that the page can ask, for what the explorer was given.

    Parameters
    ----------
    given : SweepSpec or None
        The base with the empty name.
    stored : Stored or None
        The atlas whose spec that is.
    """

    def __init__(self, given: SweepSpec | None, stored: Stored | None = None) -> None:
        self.given, self.stored = given, stored
        self._lanes = Lanes()
        self.posted: Mapping[str, _Answering] = {
            "window": self._window,
            "point": self._point,
            "lines": self._lines,
            "motion": self._motion,
            "explain": self._explain,
            "command": self._command,
            "data": self._data,
        }

    def about(self) -> Answer:
        """Answer ``GET ./about``."""
        return Answer(JSON, self._known)

    @cached_property
    def _known(self) -> dict[str, Any]:
        return about(self.given, self.stored)

    def _window(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        number = read_count(fields, "number", _MOST_NUMBER) if "number" in fields else 1
        client, lane = (read_text(fields, name, "") for name in ("client", "lane"))
        check = self._lanes.enter(client[:64], lane[:64], number, gone)
        head, arrays = window(self._view(fields), self.stored, fields, check)
        return Answer(BINARY, packed({**head, "number": number}, arrays))

    def _point(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        return Answer(JSON, point(self._view(fields), self.stored, fields))

    def _lines(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        return Answer(JSON, {"lines": lines(self._view(fields), self.stored)})

    def _motion(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        # it loads more than a map needs
        from sweep.explorer.motion import make_ready, motion

        view = self._view(fields)
        start = {name: float(values[0]) for name, values in view.starts(*place(fields)).items()}
        duration = None if fields.get("duration") is None else read_number(fields, "duration")
        losses = read_object(fields.get("losses") or {}, "losses")
        # a slider that moves asks for many, and its page waits for the last one alone
        check = still_there(gone)
        # compiling takes seconds, and is no motion that others wait for
        make_ready(view.spec, losses)
        try:
            with turn(MOTIONS, check), ended_with(check) as begun:
                head, arrays = motion(view.spec, start, duration, losses, begun)
        except NoMotionError as error:
            # no motion is an answer; of a status of 400 browsers write into their consoles
            return Answer(JSON, {"error": error.message, "hint": error.hint, "where": error.where or ""})
        return Answer(BINARY, packed(head, arrays))

    def _explain(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        # this and what follows load xarray, which takes longer than a window
        from sweep.explorer.point import explanation

        return Answer(JSON, {"text": explanation(self._view(fields), self.stored, fields)})

    def _command(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        from sweep.explorer.take_away import motion_commands, window_commands

        commands = motion_commands if "x" in fields else window_commands
        return Answer(JSON, commands(self._view(fields), fields))

    def _data(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        from sweep.explorer.take_away import window_file

        name, content = window_file(self._view(fields), fields, still_there(gone))
        return Answer(BINARY, content, {"Content-Disposition": f'attachment; filename="{name}"'})

    def _view(self, fields: Mapping[str, Any]) -> View:
        return View.read(fields.get("view"), self.given)


#: Type of an array -> what the head calls it; all little-endian.
_TYPES = {"f8": "<f8", "f4": "<f4", "u1": "u1", "i4": "<i4"}


def packed(head: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> list[bytes | memoryview]:
    """Return the parts of a binary answer.

    Parameters
    ----------
    head : mapping
        What JSON can hold; ``arrays`` is added to it.
    arrays : mapping of str to array
        float64, float32, int32 or uint8, any shape; sent in this order, in C order. The widest types come first, so
        that every array begins at a multiple of its own width.

    Returns
    -------
    list of bytes or memoryview
        Four bytes with the length of the head (little-endian), the head with spaces after it such that the arrays begin
        at a multiple of 8 bytes, and the arrays.
    """
    kinds = {name: f"{array.dtype.kind}{array.dtype.itemsize}" for name, array in arrays.items()}
    named = [{"name": name, "type": kind, "count": arrays[name].size} for name, kind in kinds.items()]
    text = json.dumps({**head, "arrays": named}, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-(4 + len(text)) % 8)
    parts: list[bytes | memoryview] = [len(text).to_bytes(4, "little"), text]
    return parts + [
        _bytes_of(np.ascontiguousarray(arrays[name], _TYPES[kind])) for name, kind in kinds.items()
    ]


def _bytes_of(array: npt.NDArray[Any]) -> memoryview:
    """Return the bytes of an array in C order, which are not copied."""
    return array.reshape(-1).view(np.uint8).data
