"""Attributes, types and dimensions of an atlas compared with its spec and the tables of its model."""

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.cf_metadata import (
    Declaration,
    cell_declarations,
    coordinate_declarations,
    global_attributes,
)
from sweep.checks.statement import Statement
from sweep.errors import shown
from sweep.request.spec import SweepSpec
from sweep.version import __version__

if TYPE_CHECKING:
    import xarray as xr

#: Global attributes that nothing in the file or in this program decides, and why.
FREE: Mapping[str, str] = {
    "title": "free text",
    "history": "free text, beside the time of date_created",
    "comment": "free text",
    "kernel_hash": "names the code that computed the cells, which cannot be had from its hash",
    "versions": "the libraries that were there when the cells were computed",
}

#: Attributes of a variable that say what its values mean. Other code may put the others in other words.
_MEANING = (
    "units",
    "flag_values",
    "flag_meanings",
    "_FillValue",
    "coordinates",
    "sample_dimension",
    "dtype",
    "dimensions",
)

#: Attributes that an atlas has not, by which other programs read its values as others or as missing.
_READ_OTHERWISE = (
    "scale_factor", "add_offset", "valid_min", "valid_max", "valid_range", "missing_value", "_Unsigned", "flag_masks",
    "compress",
)  # fmt: skip

#: The reference for attributes of variables.
_TABLE = "the table of the model"

#: Global attributes that other code may put in other words.
_WORDS = (
    "Conventions", "summary", "keywords", "references", "criterion_meaning", "software", "license", "citation",
)  # fmt: skip

_TIME = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ"

#: Attributes.
_Attributes = Mapping[str, Any]


def _is_table_of_versions(text: str) -> bool:
    try:
        named = json.loads(text)
    except (ValueError, RecursionError):
        return False
    return isinstance(named, dict) and all(isinstance(each, str) for each in named.values())


#: Global attributes of which only the form is known: what they are compared with, and whether they fit it.
_FORMS: Mapping[str, tuple[str, Callable[[SweepSpec, _Attributes, str], object]]] = {
    "source": (
        "eulerdisk VERSION, method of the spec",
        lambda spec, _, text: re.fullmatch(rf"eulerdisk \d[\w.+]*, method {re.escape(spec.method)}", text),
    ),
    "sweep_fingerprint": (
        "SHA-256 of sweep_spec",
        lambda _, held, text: text == hashlib.sha256(str(held["sweep_spec"]).encode()).hexdigest(),
    ),
    "sweep_spec": (
        "the canonical text of the spec that it spells",
        lambda spec, _, text: text == spec.canonical(),
    ),
    "date_created": (
        "a time in history",
        lambda _, held, text: re.fullmatch(_TIME, text) and text in str(held.get("history", text)),
    ),
    "kernel_hash": ("the form of a SHA-256", lambda _, __, text: re.fullmatch("[0-9a-f]{64}", text)),
    "versions": ("a table of versions in JSON", lambda _, __, text: _is_table_of_versions(text)),
    "title": ("words", lambda _, held, __: isinstance(held["title"], str)),
    "history": ("words", lambda _, held, __: isinstance(held["history"], str)),
}


def attribute_statements(
    spec: SweepSpec, dataset: "xr.Dataset", boundary: Iterable[Declaration], own: bool
) -> Iterator[Statement]:
    """Yield what is found of the global attributes, and of the attributes of all variables.

    Parameters
    ----------
    spec : SweepSpec
    dataset : xarray.Dataset
        The atlas.
    boundary : iterable of Declaration
        The variables of the boundary that its verdicts have.
    own : bool
        Whether the code that made the atlas is this code. If it, or the version, is not, words are not judged.
    """
    # words may change with the version though the arithmetic stays
    own = own and str(dataset.attrs.get("source")).startswith(f"eulerdisk {__version__}, ")
    # of attributes that hold a path, a time or a hash only the form is expected
    expected = global_attributes(spec, "", "1970-01-01T00:00:00Z")
    for name, value in expected.items():
        yield from _of_global(spec, dataset.attrs, name, value, own)
    for name in [str(each) for each in dataset.attrs if each not in expected]:
        yield Statement(name, FREE.get(name, "no attribute of an atlas"))
    declared = {
        each.name: each for each in (*coordinate_declarations(spec), *cell_declarations(spec), *boundary)
    }
    scalars = {name for name, each in declared.items() if each.coordinate and not each.dims}
    for name, each in declared.items():
        if name in dataset:
            yield from _of_variable(each, dataset[name], own, "source" in dataset.encoding, scalars)
        else:
            yield _wrong(name, "what every atlas of its spec has", "missing")
    for name in [str(each) for each in dataset.variables if each not in declared]:
        yield Statement(name, "no variable of an atlas of its spec")


def _of_global(
    spec: SweepSpec, stored: _Attributes, name: str, value: object, own: bool
) -> Iterator[Statement]:
    if name not in stored:
        yield _wrong(name, "what every atlas has", "missing")
        return
    against, fits = _FORMS.get(name, ("its spec and this version", None))
    right = fits(spec, stored, str(stored[name])) if fits else _equal(stored[name], value)
    if not right and not own and name in _WORDS:
        yield Statement(name, "made by other code, which may put it otherwise")
    elif not right:
        yield _wrong(name, against, shown(stored[name]) + ("" if fits else f" instead of {shown(value)}"))
    elif name in FREE:
        yield Statement(name, FREE[name])
    else:
        yield Statement(name, against, judged=1)


def _of_variable(
    declared: Declaration, variable: "xr.DataArray", own: bool, in_file: bool, scalars: Set[str]
) -> Iterator[Statement]:
    """Yield one statement of all attributes of a variable that are right, and one of each that is not."""
    # what xarray keeps among the encoding it drops in most operations
    encoded = {
        name: variable.encoding.get(name)
        for name in ("_FillValue", "missing_value", "coordinates", "_Unsigned")
        if in_file
    }
    stored = {**variable.attrs} | {name: value for name, value in encoded.items() if value is not None}
    expected = {**declared.attributes}
    if not in_file:
        stored.pop("coordinates", None)
        expected.pop("coordinates", None)
    elif declared.fill is not None:
        expected["_FillValue"] = declared.fill
    stored |= {"dtype": variable.dtype.str[1:], "dimensions": " ".join(map(str, variable.dims))}
    expected |= {"dtype": declared.dtype, "dimensions": " ".join(declared.dims)}
    right = 0
    for name, value in expected.items():
        given = stored.get(name)
        if given is not None and _equal(given, value):
            right += 1
        elif own or name in _MEANING:
            words = "missing" if given is None else f"{shown(given)} instead of {shown(value)}"
            yield _wrong(f"{declared.name}:{name}", _TABLE, words)
    yield Statement(f"{declared.name}:", _TABLE, judged=right)
    for name in [each for each in stored if each not in expected]:
        place = f"{declared.name}:{name}"
        if name == "missing_value" and declared.fill is not None and _equal(stored[name], declared.fill):
            # as CDO writes it: the same values are missing
            yield Statement(place, "no attribute of such a variable")
        elif name in (*_MEANING, *_READ_OTHERWISE):
            # xarray adds it when it saves a variable from memory
            if name != "coordinates" or not set(str(stored[name]).split()) <= scalars:
                yield _wrong(place, _TABLE, f"{shown(stored[name])} instead of nothing")
        else:
            yield Statement(place, "no attribute of such a variable")


def _wrong(name: str, against: str, words: str) -> Statement:
    return Statement(name, against, judged=1, wrong=1, named=[words])


def _equal(stored: Any, expected: Any) -> bool:
    """Return whether two attributes are the same: texts, or numbers with the same values and shape."""
    if isinstance(stored, str) or isinstance(expected, str):
        return isinstance(stored, str) and isinstance(expected, str) and stored == expected
    return np.array_equal(np.asarray(stored), np.asarray(expected))
