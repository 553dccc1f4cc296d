"""The values of a spec as text: TOML, the plain types of its canonical JSON, and as people write them."""

import json
from dataclasses import asdict
from typing import Any

from sweep.errors import shown
from sweep.model.description import Request
from sweep.model.quantity import Quantity
from sweep.request.criterion import Criterion
from sweep.request.sources import Distribution, Range, Values
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


def as_written(value: object, quantity: Quantity) -> str:
    """Return a value of a spec, which is in SI, as a person would have written it: angles in degrees."""
    unit = "deg" if quantity.units == "rad" else ""

    def one(number: float) -> str:
        return f"{number * quantity.plot_scale:.10g}{unit}"

    if isinstance(value, float):
        return one(value)
    if isinstance(value, Range):
        return f"{one(value.start)}:{one(value.stop)}:{value.count}" + ":log" * (value.spacing == "log")
    return ",".join(map(one, value.values)) if isinstance(value, Values) else str(value)


def both_written(specs: tuple[Request, Request], name: str) -> tuple[str, str]:
    """Return a word of two specs as people write it; with all digits, in SI, where that is the same text of both."""
    values = [spec.model.name if name == "model" else getattr(spec, name) for spec in specs]
    quantities = [{**spec.quantities, **spec.model.settings}.get(name) for spec in specs]
    exact = [",".join(value) if isinstance(value, tuple) else str(value) for value in values]
    written = [
        text if quantity is None else as_written(value, quantity)
        for value, quantity, text in zip(values, quantities, exact, strict=True)
    ]
    first, second = map(shown, exact if written[0] == written[1] else written)
    return first, second
