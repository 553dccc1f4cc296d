"""A word that is not known: which one was probably meant."""

import difflib
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NoReturn

from sweep.errors import RequestError, shown
from sweep.schema import PARAMETERS, SETTINGS, WORDS
from sweep.schema.trajectory import MOTION_INPUTS, MOTION_WORDS

#: Names of the equations and of other books, in small letters -> ours.
_LETTERS: Mapping[str, str] = MappingProxyType(
    {
        "g": "gravity",
        "m": "mass",
        "r": "radius",
        "theta": "tilt",
        "theta_dot": "tilt_rate",
        "psi_dot": "precession_rate",
        "phi_dot": "roll_rate",
    }
)


def unknown_word(name: str, names: Sequence[str]) -> NoReturn:
    """Refuse a name that is not one of `names`, and say which was probably meant."""
    raise RequestError(
        "unknown word",
        "the words are " + ", ".join(names),
        shown(name),
        _meant(name, names) or "use one of these words",
        shown(name),
    )


def perhaps(word: object, known: Sequence[str]) -> str:
    """Return a question for the known word that is nearest, or nothing."""
    close = difflib.get_close_matches(str(word).lower(), known, n=1)
    return f"did you mean {close[0]}?" if close else ""


def _meant(name: str, names: Sequence[str]) -> str:
    small = name.lower()
    if "spin" in small:
        # a disk spins about the vertical, and about its own axis
        return "say roll_rate, about the disk's own axis, or precession_rate, about the vertical"
    if _LETTERS.get(small) in names:
        return f"did you mean {_LETTERS[small]}?"
    for words, command in (
        ((*MOTION_INPUTS, *MOTION_WORDS), "simulate"),
        ((*PARAMETERS, *SETTINGS, *WORDS), "run"),
    ):
        if name in words:
            return f"leave it out: it is a word of eulerdisk {command}"
    return perhaps(name, names)
