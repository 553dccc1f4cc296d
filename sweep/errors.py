"""Errors that a user can correct, with their exit statuses."""

import os
import re
from pathlib import Path
from typing import Self

#: Largest number of characters of a message, and of its place: a user's word may have a million, a path four thousand.
_MOST_SHOWN, _MOST_OF_PLACE = 4000, 500

#: The escape sequence of a character beyond ASCII in an attribute of a file.
_SPELLED = re.compile(r"\\x[89a-f][0-9a-f]|\\u[0-9a-f]{4}|\\U[0-9a-f]{8}")


class RequestError(Exception):
    """A request that cannot be carried out; nothing has been changed.

    ``str(error)`` is one line: where, message, hint.

    Parameters
    ----------
    message : str
        What is wrong, what is allowed and what was given, in one or two sentences: "roll_rate must be finite; got nan."
    hint : str, optional
        What to do, in one sentence: "Write roll_rate=2.5."
    where : str, optional
        The key, the cell, the file, or the user's words.
    """

    #: Exit status of a command that ends with this error.
    status = 2

    def __init__(self, message: str, hint: str = "", where: str | None = None) -> None:
        # All texts go to args: exceptions are pickled by their args, and workers send errors between processes.
        super().__init__(message, hint, where)
        self.message, self.hint, self.where = message, hint, where

    def __str__(self) -> str:
        """Return the error as one printable line, escaping characters from the user or a file."""
        place = f"{_shortened(self.where, _MOST_OF_PLACE)}: " if self.where else ""
        text = printable(f"{place}{self.message} {self.hint}".rstrip())
        # keep the end too: the hint is there, behind the user's words
        return _shortened(text, _MOST_SHOWN)

    def at(self, where: str) -> Self:
        """Return the same error at another place."""
        return type(self)(self.message, self.hint, where)


class StorageError(RequestError):
    """The file system cannot store the results: no space, a quota, a limit or a defect. Complete blocks are kept."""

    status = 3


class NoMotionError(RequestError):
    """A valid start without a motion: none exists, it ends where it begins, or it could not be resolved."""


class FailedBlocksError(RequestError):
    """Other machines could not compute some of the blocks. Complete blocks are kept."""

    status = 1


class LeftOutWarning(UserWarning):
    """A file has variables that no atlas has and that cannot be read with it: they are left out."""


class SurroundingsWarning(RuntimeWarning):
    """The cache folder, the system or the processor costs time or changes last bits."""


class StoppedError(Exception):
    """A run was asked to stop and ended between two blocks; ``str(error)`` states which finished blocks are kept."""


def _shortened(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most // 4]} ... {text[most // 4 - most :]}"


def shown(raw: object) -> str:
    """Return a value of a request as the user wrote it, shortened for a message."""
    text = raw if isinstance(raw, str) else repr(raw)
    return text if len(text) <= 80 else f"{text[:60]} ... {text[-15:]}"


def as_path(given: object, example: str = "rolling.nc") -> Path:
    """Return a path given as text or as a path object.

    Raises
    ------
    RequestError
        If it is neither.
    """
    text = os.fspath(given) if isinstance(given, (str, os.PathLike)) else None
    if isinstance(text, str):
        return Path(text)
    raise RequestError(
        f"A path must be a string or a pathlib.Path; got a {type(given).__name__}.",
        hint=f'For example, write "{example}".',
    )


def counted(count: int, thing: str, of: int | None = None) -> str:
    """Return a count with its noun: ``1 cell``, ``0 cells``; with `of`: ``1 of 3 cells``, ``1 of 1 cell``."""
    noun = thing if (count if of is None else of) == 1 else f"{thing}s"
    return f"{count} {noun}" if of is None else f"{count} of {of} {noun}"


def are(count: int, one: str = "is", more: str = "are") -> str:
    """Return the verb for a count: ``is`` for one, ``are`` for none or several."""
    return one if count == 1 else more


def printable(text: str) -> str:
    """Return a text on one line with unprintable characters escaped: XML forbids them, and terminals obey them."""
    if text.isprintable():
        return text
    return "".join(
        each if each.isprintable() else each.encode("unicode_escape").decode("ascii") for each in text
    )


def plain_text(attribute: object) -> str:
    """Return the text of an attribute as a person wrote it, to show in figures and terminals.

    Parameters
    ----------
    attribute : object
        Text from `sweep.atlas.cf_metadata.ascii_text`. Escapes of unprintable characters are kept.
    """

    def character(spelled: re.Match[str]) -> str:
        number = int(spelled[0][2:], 16)
        found = chr(number) if 0x80 <= number < 0x110000 else ""
        return found if found.isprintable() and found else spelled[0]

    return _SPELLED.sub(character, str(attribute))
