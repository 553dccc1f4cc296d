"""Comparison of the attributes, types and dimensions of an atlas with its spec and its model's tables."""

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.cf_metadata import (
    Declaration,
    cell_declarations,
    coordinate_declarations,
    global_attributes,
    read_texts,
)
from sweep.checks.statement import Statement
from sweep.errors import shown
from sweep.request.spec import SweepSpec
from sweep.version import __version__

if TYPE_CHECKING:
    import xarray as xr

#: Global attributes whose content cannot be checked, and why.
FREE: Mapping[str, str] = {
    "title": "free text",
    "history": "free text, except for the time in date_created",
    "comment": "free text",
    "requested_as": "the words and units of the request, which the spec does not contain",
    "kernel_hash": "identifies the code that computed the cells; a hash does not reveal the code",
    "versions": "the libraries installed when the cells were computed",
}

#: Attributes that give the values of a variable their meaning. Other code may word the remaining ones differently.
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

#: Attributes that no atlas has, and that make other programs change values or treat them as missing.
_READ_OTHERWISE = (
    "scale_factor", "add_offset", "valid_min", "valid_max", "valid_range", "missing_value", "_Unsigned", "flag_masks",
    "compress",
)  # fmt: skip

#: Reference for the attributes of variables.
_TABLE = "the table of the model"

#: Global attributes that other code may word differently.
_WORDS = (
    "Conventions", "summary", "keywords", "references", "criterion_meaning", "software", "license", "citation",
)  # fmt: skip

_TIME = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ"

#: Attributes by name.
_Attributes = Mapping[str, Any]


#: Global attributes whose form is checked: the expected form, and a test of whether they have it.
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
        "the canonical text of the spec",
        lambda spec, _, text: text == spec.canonical(),
    ),
    "date_created": (
        "a time in history",
        lambda _, held, text: re.fullmatch(_TIME, text) and text in str(held.get("history", text)),
    ),
    "kernel_hash": ("the form of a SHA-256", lambda _, __, text: re.fullmatch("[0-9a-f]{64}", text)),
    "versions": ("a table of versions in JSON", lambda _, __, text: read_texts(text) is not None),
    "requested_as": ("a table of words in JSON", lambda _, __, text: read_texts(text) is not None),
    "title": ("text", lambda _, held, __: isinstance(held["title"], str)),
    "history": ("text", lambda _, held, __: isinstance(held["history"], str)),
}


def attribute_statements(
    spec: SweepSpec, dataset: "xr.Dataset", boundary: Iterable[Declaration], own: bool
) -> Iterator[Statement]:
    """Yield the results for the global attributes and for the attributes of all variables.

    Parameters
    ----------
    spec : SweepSpec
    dataset : xarray.Dataset
        The atlas.
    boundary : iterable of Declaration
        The boundary variables that follow from the verdicts of the atlas.
    own : bool
        Whether this code made the atlas. If the code or the version differs, wording is not judged.
    """
    # a new version may change wording without changing the arithmetic
    own = own and str(dataset.attrs.get("source")).startswith(f"eulerdisk {__version__}, ")
    # placeholders: for attributes with a command, a time or a hash, only the form is checked
    expected = global_attributes(spec, "", "1970-01-01T00:00:00Z")
    for name, value in expected.items():
        yield from _of_global(spec, dataset.attrs, name, value, own)
    for name in [str(each) for each in dataset.attrs if each not in expected]:
        yield Statement(name, FREE.get(name, "not an attribute of atlases"))
    declared = {
        each.name: each for each in (*coordinate_declarations(spec), *cell_declarations(spec), *boundary)
    }
    scalars = {name for name, each in declared.items() if each.coordinate and not each.dims}
    for name, each in declared.items():
        if name in dataset:
            yield from _of_variable(each, dataset[name], own, "source" in dataset.encoding, scalars)
        else:
            yield _wrong(name, "the variables of its spec", "missing")
    for name in [str(each) for each in dataset.variables if each not in declared]:
        yield Statement(name, "not a variable of atlases with this spec")


def _of_global(
    spec: SweepSpec, stored: _Attributes, name: str, value: object, own: bool
) -> Iterator[Statement]:
    if name not in stored:
        yield _wrong(name, "the attributes of every atlas", "missing")
        return
    against, fits = _FORMS.get(name, ("its spec and this version", None))
    right = fits(spec, stored, str(stored[name])) if fits else _equal(stored[name], value)
    if not right and not own and name in _WORDS:
        yield Statement(name, "made by other code, which may word it differently")
    elif not right:
        yield _wrong(name, against, shown(stored[name]) + ("" if fits else f" instead of {shown(value)}"))
    elif name in FREE:
        yield Statement(name, FREE[name])
    else:
        yield Statement(name, against, judged=1)


def _of_variable(
    declared: Declaration, variable: "xr.DataArray", own: bool, in_file: bool, scalars: Set[str]
) -> Iterator[Statement]:
    """Yield one statement for all correct attributes of a variable, and one for each wrong attribute."""
    # most xarray operations drop the encoding, so it is checked only if the variable comes from a file
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
            # CDO writes this; the same values are missing
            yield Statement(place, "not an attribute of this variable")
        elif name in (*_MEANING, *_READ_OTHERWISE):
            # xarray adds the coordinates when it saves a variable from memory
            if name != "coordinates" or not set(str(stored[name]).split()) <= scalars:
                yield _wrong(place, _TABLE, f"{shown(stored[name])} instead of nothing")
        else:
            yield Statement(place, "not an attribute of this variable")


def _wrong(name: str, against: str, words: str) -> Statement:
    return Statement(name, against, judged=1, wrong=1, named=[words])


def _equal(stored: Any, expected: Any) -> bool:
    """Return whether two attributes are the same: texts, or numbers with the same values and shape."""
    if isinstance(stored, str) or isinstance(expected, str):
        return isinstance(stored, str) and isinstance(expected, str) and stored == expected
    return np.array_equal(np.asarray(stored), np.asarray(expected))
