"""What is answered: one function for every address that the page asks."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from sweep.errors import NoMotionError
from sweep.explorer.abandon import abandoned_with
from sweep.explorer.about import about
from sweep.explorer.fields import read_count, read_number, read_object, read_text
from sweep.explorer.freed_memory import give_back
from sweep.explorer.lines import lines
from sweep.explorer.packing import packed
from sweep.explorer.point import place, point
from sweep.explorer.stored import Stored
from sweep.explorer.turns import BusyError, Lanes, motion_turn, still_there
from sweep.explorer.view import View
from sweep.explorer.window import window
from sweep.request.spec import SweepSpec

JSON, BINARY = "application/json", "application/octet-stream"

#: The largest number that a page may give a request.
_MOST_NUMBER = 2**53


#: What answers: called with the fields of a request, and with what tells whether the client has gone.
_Answering = Callable[[Mapping[str, Any], Callable[[], bool]], "Answer"]


@dataclass(frozen=True)
class Answer:
    """What is sent: a type, and an object for JSON, parts of bytes, or an open file; `name` is that to save it under.

    Who sends an answer closes its file.
    """

    kind: str
    content: Any
    name: str = ""


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
            "motion": _then_given_back(self._motion),
            "explain": _then_given_back(self._explain),
            "command": self._command,
            "data": _then_given_back(self._data),
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
            with motion_turn(check), abandoned_with(check) as begun:
                head, arrays = motion(view.spec, start, duration, losses, begun)
        except (NoMotionError, BusyError) as error:
            # no motion, now or ever, is an answer; of a status of 400 browsers write into their consoles
            words = {"error": error.message, "hint": error.hint, "where": error.where or ""}
            return Answer(JSON, {**words, "busy": isinstance(error, BusyError)})
        return Answer(BINARY, packed(head, arrays))

    def _explain(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        # this and what follows load xarray, which takes longer than a window
        from sweep.explorer.words import explanation

        return Answer(JSON, {"text": explanation(self._view(fields), self.stored, fields)})

    def _command(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        from sweep.explorer.commands import motion_commands, window_commands

        commands = motion_commands if "x" in fields else window_commands
        return Answer(JSON, commands(self._view(fields), fields))

    def _data(self, fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        from sweep.explorer.window_files import window_file

        name, content = window_file(self._view(fields), fields, still_there(gone))
        return Answer(BINARY, content, name)

    def _view(self, fields: Mapping[str, Any]) -> View:
        return View.read(fields.get("view"), self.given)


def _then_given_back(answering: _Answering) -> _Answering:
    """Return what answers likewise, and gives the memory back that it needed on the way."""

    def answer(fields: Mapping[str, Any], gone: Callable[[], bool]) -> Answer:
        try:
            return answering(fields, gone)
        finally:
            give_back()

    return answer
