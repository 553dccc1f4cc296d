"""The values of a spec as text: TOML, and the plain types of its canonical JSON."""

import json
from dataclasses import asdict
from typing import Any

from sweep.request.axes import Range, Values
from sweep.request.criterion import Criterion
from sweep.request.distributions import Distribution
from sweep.request.start_table import Column, StartTable


def toml_value(value: object) -> str:
    """Return the value of a word as TOML."""
    if isinstance(value, Values):
        return "[" + ", ".join(map(repr, value.values)) + "]"
    # JSON's strings are TOML's, as long as nothing outside ASCII is escaped in pairs.
    return repr(value) if isinstance(value, float | int) else json.dumps(str(value), ensure_ascii=False)


def to_json(value: Any) -> Any:
    """Return the value of a word as plain types, which `from_json` reads."""
    if isinstance(value, Criterion):
        return value.kept()
    if isinstance(value, Distribution):
        return str(value)
    if isinstance(value, StartTable):
        return value.to_json()
    if isinstance(value, Column):
        return {"column": value.name}
    return asdict(value) if isinstance(value, Range | Values) else value


def from_json(value: Any) -> object:
    """Return what `to_json` made plain types of."""
    if not isinstance(value, dict):
        return value
    if "sha256" in value:
        return StartTable.from_json(value)
    if "column" in value:
        return Column(str(value["column"]))
    if "kind" in value:
        return Criterion(**value)
    return Range(**value) if "count" in value else Values(**value)
