"""The fields of a request from the page, each read and checked."""

import json
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from sweep.errors import RequestError, shown

#: Largest number that a page may send, in SI: squares and products of such numbers are finite.
_LARGEST = 1e12


def read_json(body: bytes) -> Mapping[str, Any]:
    """Return the object in the body of a request.

    Raises
    ------
    RequestError
        If the body is not a JSON object, or contains a number that is not finite.
    """
    try:
        found = json.loads(body, parse_constant=_no_constant)
    except (ValueError, RecursionError) as problem:
        raise RequestError(
            f"The body of a request must be a JSON object with finite numbers; this one cannot be read: {problem}.",
            hint="Reload the page.",
            where="body",
        ) from None
    return read_object(found, "body")


def _no_constant(text: str) -> NoReturn:
    raise ValueError(f"{text} is not a JSON number")


def read_object(raw: object, where: str) -> Mapping[str, Any]:
    """Return a value; refuse it if it is not a JSON object."""
    if isinstance(raw, dict):
        return raw
    refuse(where, "an object with named fields", raw)


def read_number(fields: Mapping[str, Any], name: str) -> float:
    """Return a field that must be a number of moderate size."""
    raw = fields.get(name)
    # compares without `float()`, which does not accept every whole number
    if isinstance(raw, int | float) and not isinstance(raw, bool) and abs(raw) <= _LARGEST:
        return float(raw)
    refuse(name, f"a number of at most {_LARGEST:g} in size", raw)


def read_count(fields: Mapping[str, Any], name: str, most: int) -> int:
    """Return a field that must be a whole number from 1 to `most`."""
    raw = fields.get(name)
    if isinstance(raw, int) and not isinstance(raw, bool) and 1 <= raw <= most:
        return raw
    refuse(name, f"a whole number from 1 to {most}", raw)


def read_text(fields: Mapping[str, Any], name: str, default: str | None = None) -> str:
    """Return a field that must be text; the default if it is missing."""
    raw = fields.get(name, default)
    if isinstance(raw, str):
        return raw
    refuse(name, "text", raw)


def read_choice(
    fields: Mapping[str, Any], name: str, choices: Sequence[str], default: str | None = None
) -> str:
    """Return a field that must be one of `choices`."""
    text = read_text(fields, name, default)
    if text in choices:
        return text
    refuse(name, f"one of {', '.join(choices)}", text)


def refuse(where: str, allowed: str, given: object) -> NoReturn:
    """Raise an error about a field.

    Raises
    ------
    RequestError
    """
    told = "nothing" if given is None else shown(given)
    raise RequestError(f"{where} must be {allowed}; got {told}.", hint="Reload the page.", where=where)
