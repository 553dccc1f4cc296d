"""The text of a user's file: parsed, never run; what is refused is named with its line."""

import ast
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

from sweep.errors import RequestError, shown

#: Bytes of a file, its lines, and the characters of a line at most. A definition has about a thousand bytes.
MOST_BYTES, MOST_LINES, MOST_IN_LINE = 64_000, 1000, 4000

#: First words of sentences.
_LEADING = re.compile(r"(?:A|An|At|Every|Some|The|This)\b")
_LINE_END = re.compile(r"\r\n|\r|\n")


class LineError(RequestError):
    """A line of a user's file is not possible."""


class Source:
    """A text, and what its lines are called in messages.

    Parameters
    ----------
    text : str
    where : str
        What the file is called; empty if it has no name.
    first : int
        The number of its first line.

    Raises
    ------
    RequestError
        If it is too large.
    """

    def __init__(self, text: str, where: str = "", first: int = 1) -> None:
        self._lines, self._where, self._first = _LINE_END.split(text), where, first
        self._text = text.removeprefix("\ufeff")
        if len(text) > MOST_BYTES or len(self._lines) > MOST_LINES:
            self.refuse(
                min(len(self._lines), MOST_LINES),
                f"a file of systems has at most {MOST_BYTES} characters and {MOST_LINES} lines; got {len(text)} and "
                f"{len(self._lines)}",
                "Keep only what defines the system.",
            )
        for number, line in enumerate(self._lines, 1):
            if len(line) > MOST_IN_LINE:
                self.refuse(
                    number,
                    f"a line has at most {MOST_IN_LINE} characters; got {len(line)}",
                    "Break the line.",
                )

    def refuse(self, line: int, problem: str, hint: str) -> NoReturn:
        """Refuse what stands in a line, counted from 1."""
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
        """Say of what is refused inside in which line it stands, and before it `what` it is."""
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
            If it is not Python, or nested too deep.
        """
        try:
            with warnings.catch_warnings():
                # of a backslash in a string
                warnings.simplefilter("ignore")
                return ast.parse(self._text)
        except SyntaxError as problem:
            self.refuse(problem.lineno or 1, f"this is not Python: {problem.msg}", "Correct this line.")
        except ValueError as problem:
            self.refuse(self._longest(), f"this is not Python: {problem}", "Correct this line.")
        # by brackets, signs or operators in thousands
        except (MemoryError, RecursionError):
            self.refuse(
                self._longest(), "this is nested too deep to be read", "Give parts of it names of their own."
            )

    def _longest(self) -> int:
        return max(range(len(self._lines)), key=lambda at: len(self._lines[at])) + 1
