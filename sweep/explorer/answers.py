"""Answers to the page: one function for each address."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.explorer.about import about
from sweep.explorer.lines import lines
from sweep.explorer.own_module import has_own_module, kernels_of
from sweep.explorer.plan import plan
from sweep.explorer.point import explanation, stored_point
from sweep.explorer.stored import Stored
from sweep.explorer.view import View
from sweep.explorer.window import computed_window, stored_window
from sweep.request.spec import SweepSpec

JSON, BINARY = "application/json", "application/octet-stream"

#: A function that answers a request: called with its view, its fields, and a function that raises an error if the
#: client has gone.
_Answering = Callable[[View, Mapping[str, Any], Callable[[], None]], "Answer"]


@dataclass(frozen=True)
class Answer:
    """An answer: its content type, and an object for JSON, parts of bytes, or an open file, which the server closes."""

    kind: str
    content: Any
    headers: Mapping[str, str] = field(default_factory=dict)
    status: int = 200


class Answers:
    """All answers to the page, for the subject of the explorer.

    Parameters
    ----------
    given : SweepSpec or None
        The base with the empty name.
    stored : Stored or None
        The atlas whose spec `given` is.
    """

    def __init__(self, given: SweepSpec | None, stored: Stored | None = None) -> None:
        self.given, self.stored = given, stored
        self._answering: Mapping[str, _Answering] = {
            "plan": lambda view, _, __: _json(plan(view)),
            "window": lambda view, fields, _: _window(stored_window(view, stored, fields)),
            "cells": lambda view, fields, check: _window(computed_window(view, fields, check)),
            "point": lambda view, fields, _: _json({"stored": stored_point(view, stored, fields)}),
            "lines": lambda view, _, __: _json({"lines": lines(view, stored)}),
            "explain": lambda view, fields, _: _json({"text": explanation(view, stored, fields)}),
            "command": _command,
            "data": _data,
        }

    @cached_property
    def about(self) -> Answer:
        """The answer to ``GET ./about``."""
        return _json(about(self.given, self.stored))

    @property
    def has_own_kernels(self) -> bool:
        """Whether the page computes with a module other than the disk's."""
        return has_own_module(self.given)

    @property
    def kernels(self) -> Answer:
        """The page's own module, made when it is first requested."""
        return Answer("application/wasm", [kernels_of(self.given)])

    def __contains__(self, path: object) -> bool:
        return path in self._answering

    def answer(self, path: str, fields: Mapping[str, Any], check: Callable[[], None]) -> Answer:
        """Answer a request of the page; `check` raises an error if its client has gone.

        Raises
        ------
        RequestError
        ClientGoneError
        """
        return self._answering[path](View.read(fields.get("view"), self.given), fields, check)


def _json(content: Mapping[str, Any]) -> Answer:
    return Answer(JSON, content)


def _window(found: tuple[Mapping[str, Any], Mapping[str, npt.NDArray[Any]]] | None) -> Answer:
    return _json({"head": None}) if found is None else Answer(BINARY, packed(*found))


# imported here, because a map does not need them


def _command(view: View, fields: Mapping[str, Any], check: Callable[[], None]) -> Answer:
    from sweep.explorer.take_away import motion_commands, window_commands

    return _json((motion_commands if "x" in fields else window_commands)(view, fields))


def _data(view: View, fields: Mapping[str, Any], check: Callable[[], None]) -> Answer:
    from sweep.explorer.take_away import window_file

    name, content = window_file(view, fields, check)
    return Answer(BINARY, content, {"Content-Disposition": f'attachment; filename="{name}"'})


def packed(head: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> list[bytes | memoryview]:
    """Return the parts of a binary answer.

    Parameters
    ----------
    head : mapping
        Anything that JSON can represent; ``arrays`` is added to it.
    arrays : mapping of str to array
        float64, float32, int32 or uint8, of any shape, in C order. They must be ordered from the widest type to the
        narrowest, so that every array begins at a multiple of its own width.

    Returns
    -------
    list of bytes or memoryview
        Four bytes with the length of the head (little-endian), the head, padded with spaces so that the arrays begin at
        a multiple of 8 bytes, and the arrays.
    """
    kinds = {name: f"{array.dtype.kind}{array.dtype.itemsize}" for name, array in arrays.items()}
    named = [{"name": name, "type": kind, "count": arrays[name].size} for name, kind in kinds.items()]
    text = json.dumps({**head, "arrays": named}, allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-(4 + len(text)) % 8)
    # bytes of arrays in C order, without copies
    held = (np.ascontiguousarray(each, each.dtype.newbyteorder("<")) for each in arrays.values())
    return [len(text).to_bytes(4, "little"), text, *(each.reshape(-1).view(np.uint8).data for each in held)]
