"""The fields of a request of the page: read one by one, refused in words."""

import json
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from sweep.errors import RequestError, shown

#: Nothing on a page is larger, in SI: the squares and products of such numbers are finite.
_LARGEST = 1e12


def read_json(body: bytes) -> Mapping[str, Any]:
    """Return the object that the body of a request holds.

    Raises
    ------
    RequestError
        If it is no JSON, no object, or has a number that is not finite.
    """
    try:
        found = json.loads(body, parse_constant=_no_constant)
    except (ValueError, RecursionError) as problem:
        raise RequestError(
            f"The body of a request is one JSON object of finite numbers; this one cannot be read: {problem}.",
            hint="Load the page again.",
            where="body",
        ) from None
    return read_object(found, "body")


def _no_constant(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number of JSON")


def read_object(raw: object, where: str) -> Mapping[str, Any]:
    """Return an object of JSON."""
    if isinstance(raw, dict):
        return raw
    refuse(where, "an object with named fields", raw)


def read_number(fields: Mapping[str, Any], name: str) -> float:
    """Return a number that can be computed with."""
    raw = fields.get(name)
    # without `float`, which does not take every whole number
    if isinstance(raw, int | float) and not isinstance(raw, bool) and abs(raw) <= _LARGEST:
        return float(raw)
    refuse(name, f"a number of at most {_LARGEST:g} in size", raw)


def read_count(fields: Mapping[str, Any], name: str, most: int) -> int:
    """Return a whole number from 1 to `most`."""
    raw = fields.get(name)
    if isinstance(raw, int) and not isinstance(raw, bool) and 1 <= raw <= most:
        return raw
    refuse(name, f"a whole number from 1 to {most}", raw)


def read_text(fields: Mapping[str, Any], name: str, default: str | None = None) -> str:
    """Return a text, the default if there is none."""
    raw = fields.get(name, default)
    if isinstance(raw, str):
        return raw
    refuse(name, "text", raw)


def read_choice(
    fields: Mapping[str, Any], name: str, choices: Sequence[str], default: str | None = None
) -> str:
    """Return one of some texts."""
    text = read_text(fields, name, default)
    if text in choices:
        return text
    refuse(name, f"one of {', '.join(choices)}", text)


def refuse(where: str, allowed: str, given: object) -> NoReturn:
    """Refuse a field.

    Raises
    ------
    RequestError
    """
    told = "nothing" if given is None else shown(given)
    raise RequestError(f"{where} must be {allowed}; got {told}.", hint="Load the page again.", where=where)
