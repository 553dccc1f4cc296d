"""Refusals of unknown words, with suggestions for the intended word."""

import difflib
from collections.abc import Mapping, Sequence
from typing import NoReturn

from sweep.errors import RequestError, shown
from sweep.model.description import Model


def unknown_word(
    name: str, known: Sequence[str], model: Model, elsewhere: Mapping[str, str] | None = None
) -> NoReturn:
    """Refuse a name that is not in `known`, and suggest the intended one.

    Parameters
    ----------
    name : str
    known : sequence of str
    model : Model
        Its `synonyms` and `ambiguous` give the hints.
    elsewhere : mapping of str to str, optional
        Names that belong elsewhere -> an explanation where.

    Raises
    ------
    RequestError
    """
    small = name.lower()
    hint = next((text for part, text in model.ambiguous.items() if part in small), "")
    if not hint and model.synonyms.get(small) in known:
        hint = f"Did you mean {model.synonyms[small]}?"
    if not hint and elsewhere and name in elsewhere:
        hint = f"Leave it out: {elsewhere[name]}."
    raise RequestError(
        f"{shown(name)} is not a word of this request; the words are {', '.join(known)}.",
        hint=hint or suggestion(name, (*known, *(elsewhere or ()))) or "Use one of these words.",
        where=shown(name),
    )


def nearest_word(word: object, known: Sequence[str]) -> str | None:
    """Return the known word that was probably intended, or None."""
    return next(iter(difflib.get_close_matches(str(word).lower(), known, n=1)), None)


def suggestion(word: object, known: Sequence[str]) -> str:
    """Return ``Did you mean WORD?`` for the word that was probably intended; empty if none is close."""
    meant = nearest_word(word, known)
    return f"Did you mean {meant}?" if meant else ""
