"""Refuse a word that is not known, and say which one was probably meant."""

import difflib
from collections.abc import Mapping, Sequence
from typing import NoReturn

from sweep.errors import RequestError, shown
from sweep.model.description import Model


def unknown_word(
    name: str, known: Sequence[str], model: Model, elsewhere: Mapping[str, str] | None = None
) -> NoReturn:
    """Refuse a name that is not one of `known`, and say which was probably meant.

    Parameters
    ----------
    name : str
    known : sequence of str
    model : Model
        Its `synonyms` and `ambiguous` give the hints.
    elsewhere : mapping of str to str, optional
        Names that have no place here -> where they have one, in words.

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
        f"{shown(name)} is no word of this request; the words are {', '.join(known)}.",
        hint=hint or suggestion(name, (*known, *(elsewhere or ()))) or "Use one of these words.",
        where=shown(name),
    )


def nearest_word(word: object, known: Sequence[str]) -> str | None:
    """Return the known word that was probably meant, or None."""
    return next(iter(difflib.get_close_matches(str(word).lower(), known, n=1)), None)


def suggestion(word: object, known: Sequence[str]) -> str:
    """Return a question for the known word that was probably meant, or nothing."""
    meant = nearest_word(word, known)
    return f"Did you mean {meant}?" if meant else ""
