"""The text of a user's file, which is parsed and never executed; refusals name the line."""

import ast
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

from sweep.errors import RequestError, shown

#: Largest numbers of bytes and lines of a file, and of characters of a line. A definition has about a thousand bytes.
MOST_BYTES, MOST_LINES, MOST_IN_LINE = 64_000, 1000, 4000

#: Words at the beginning of a message, which become lower-case after a colon.
_LEADING = re.compile(r"(?:A|An|At|Every|Some|The|This)\b")
_LINE_END = re.compile(r"\r\n|\r|\n")


class LineError(RequestError):
    """An error in a line of a user's file."""


class Source:
    """A text, with the names of its lines in messages.

    Parameters
    ----------
    text : str
    where : str
        The name of the file; may be empty.
    first : int
        The number of the first line.

    Raises
    ------
    RequestError
        If the text is too large.
    """

    def __init__(self, text: str, where: str = "", first: int = 1) -> None:
        self._lines, self._where, self._first = _LINE_END.split(text), where, first
        self._text = text.removeprefix("\ufeff")
        if len(text) > MOST_BYTES or len(self._lines) > MOST_LINES:
            self.refuse(
                min(len(self._lines), MOST_LINES),
                f"a file of systems has at most {MOST_BYTES} characters and {MOST_LINES} lines; got {len(text)} and "
                f"{len(self._lines)}",
                "Keep only the definition of the system.",
            )
        for number, line in enumerate(self._lines, 1):
            if len(line) > MOST_IN_LINE:
                self.refuse(
                    number,
                    f"a line has at most {MOST_IN_LINE} characters; got {len(line)}",
                    "Break the line.",
                )

    def refuse(self, line: int, problem: str, hint: str) -> NoReturn:
        """Raise an error for a line, counted from 1."""
        said = self._lines[line - 1].strip() if 0 < line <= len(self._lines) else ""
        problem = problem.removesuffix(".")
        raise LineError(
            f"{problem[:1].upper()}{problem[1:]}" + (f"; the line is {shown(said)!r}." if said else "."),
            hint=hint,
            where=f"{self._where}, line {line + self._first - 1}"
            if self._where
            else f"line {line + self._first - 1}",
        )

    @contextmanager
    def at(self, node: ast.AST, what: str = "") -> Iterator[None]:
        """Add the line of a node to errors raised inside, and `what` in front of their messages."""
        try:
            yield
        except LineError:
            raise
        except RequestError as error:
            problem = (
                f"{what}: {_LEADING.sub(lambda word: word[0].lower(), error.message)}"
                if what
                else error.message
            )
            self.refuse(getattr(node, "lineno", 1), problem, error.hint)

    def parsed(self) -> ast.Module:
        """Return the tree of the text.

        Raises
        ------
        RequestError
            If the text is not Python, or is nested too deeply.
        """
        try:
            with warnings.catch_warnings():
                # warnings about backslashes in strings
                warnings.simplefilter("ignore")
                return ast.parse(self._text)
        except SyntaxError as problem:
            self.refuse(problem.lineno or 1, f"this is not Python: {problem.msg}", "Correct this line.")
        except ValueError as problem:
            self.refuse(self._longest(), f"this is not Python: {problem}", "Correct this line.")
        # thousands of nested brackets, signs or operators
        except (MemoryError, RecursionError):
            self.refuse(self._longest(), "this is nested too deeply", "Assign parts of it to names.")

    def _longest(self) -> int:
        return max(range(len(self._lines)), key=lambda at: len(self._lines[at])) + 1
