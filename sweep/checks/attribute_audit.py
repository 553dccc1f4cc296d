"""Attributes, coordinates, types and dimensions of an atlas held against its spec and the tables of its model."""

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
from sweep.atlas.dataset import coordinates
from sweep.checks.tally import Statement, Tally, cell_in_words, difference_check, row_in_words, unchecked
from sweep.engine.grid import blocks, starts_of
from sweep.errors import shown
from sweep.model.quantity import Array
from sweep.request.spec import SweepSpec
from sweep.version import __version__

if TYPE_CHECKING:
    import xarray as xr

#: Relative tolerance of an axis: the logarithm in a range differs in its last bits between processors.
_ROUNDING = 1e-12

#: Global attributes that nothing in the file or in this program decides, and why.
FREE: Mapping[str, str] = {
    "title": "free text",
    "history": "free text, beside the time of date_created",
    "comment": "free text",
    "kernel_hash": "names the code that computed the cells, which cannot be had from its hash",
    "versions": "the libraries that were there when the cells were computed",
}

#: Attributes of a variable that say what its values mean. The others are words that a later version may put otherwise.
_MEANING = ("units", "flag_values", "flag_meanings", "_FillValue", "coordinates", "sample_dimension")

#: Global attributes that a later version may put otherwise.
_WORDS = (
    "Conventions", "summary", "keywords", "references", "criterion_meaning", "software", "license", "citation",
)  # fmt: skip

_TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")


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
        Whether the code that made the atlas is this code. If it, or the version, is not, words that a later version may
        put otherwise, and variables that it may have added, are not judged.
    """
    # words may change with the version though the arithmetic stays
    own = own and str(dataset.attrs.get("source")).startswith(f"eulerdisk {__version__}, ")
    yield from _global_statements(spec, dataset, own)
    declared = [*coordinate_declarations(spec), *cell_declarations(spec), *boundary]
    yield from _variable_statements({each.name: each for each in declared}, dataset, own)


def coordinate_statements(spec: SweepSpec, dataset: "xr.Dataset") -> Iterator[Statement]:
    """Yield what is found of the coordinates: the axes and the fixed parameters, whose shapes are known to be right."""
    for declared, values in coordinates(spec):
        if declared.name in dataset:
            yield _of_coordinate(spec, dataset, declared, values)
    yield from _start_statements(spec, dataset)


def _start_statements(spec: SweepSpec, dataset: "xr.Dataset") -> Iterator[Statement]:
    """Yield what is found of the values that a list gives each of its starts."""
    tallies = {name: Tally(name, spec.model.parameters[name].units) for name in spec.listed}
    for span in blocks(spec.size) if spec.listed else ():
        starts = starts_of(spec, span)
        for name, tally in tallies.items():
            stored = np.asarray(dataset[name][span.start : span.stop].values, np.float64)
            against = f"{getattr(spec, name)} of the spec"
            none = np.zeros(stored.shape)
            tally.add_all(span.start, [difference_check(name, against, stored, starts[name], none)])
    for tally in tallies.values():
        yield tally.statement(lambda place: cell_in_words(spec, place))


def _of_coordinate(spec: SweepSpec, dataset: "xr.Dataset", declared: Declaration, values: Array) -> Statement:
    name, tally = declared.name, Tally(declared.name, str(declared.attributes["units"]))
    against = "the axis of the spec" if declared.dims else "the value in the spec"
    stored = np.asarray(dataset[name], np.float64)
    tally.add_all(0, [difference_check(name, against, stored, values, _ROUNDING * np.abs(values))])
    return tally.statement(
        lambda place: row_in_words(spec, {name: np.intp(place)}) if declared.dims else "the one value"
    )


def made_by(dataset: "xr.Dataset", code: str) -> bool:
    """Return whether an atlas says that code of a hash made it."""
    return str(dataset.attrs.get("kernel_hash")) == code


def _global_statements(spec: SweepSpec, dataset: "xr.Dataset", own: bool) -> Iterator[Statement]:
    stored = dataset.attrs
    # of attributes that hold a path, a time or a hash only the form is expected, see `_FORMS`
    expected = {**global_attributes(spec, "", "1970-01-01T00:00:00Z")}
    for name, value in expected.items():
        if name not in stored:
            if own or not _added_later(spec, name):
                yield _wrong(name, "what every atlas has", "missing")
            continue
        form = _FORMS.get(name)
        against, right = (
            form(spec, stored) if form else ("its spec and this version", _equal(stored[name], value))
        )
        if not right and not own and name in _WORDS:
            yield unchecked(name, "made by other code, which may put it otherwise")
        elif not right:
            yield _wrong(name, against, shown(stored[name]) + ("" if form else f" instead of {shown(value)}"))
        elif name in FREE:
            yield unchecked(name, FREE[name])
        else:
            yield Statement(name, against, judged=1)
    for name in map(str, stored):
        if name not in expected:
            yield unchecked(name, FREE.get(name, "no attribute of an atlas"))


def _added_later(spec: SweepSpec, name: str) -> bool:
    """Return whether older files may lack an attribute: words, units, and numbers that the coordinates have too."""
    return name in _WORDS or name.endswith("_units") or name in spec.fixed


def _wrong(name: str, against: str, words: str) -> Statement:
    return Statement(name, against, judged=1, wrong=1, named=[words])


def _equal(stored: Any, expected: Any) -> bool:
    """Return whether two attributes are the same: texts, or numbers with the same values and shape."""
    if isinstance(stored, str) or isinstance(expected, str):
        return isinstance(stored, str) and isinstance(expected, str) and stored == expected
    return np.shape(stored) == np.shape(expected) and bool(np.all(np.asarray(stored) == np.asarray(expected)))


_Form = Callable[[SweepSpec, Mapping[str, Any]], tuple[str, bool]]


def _source(spec: SweepSpec, stored: Mapping[str, Any]) -> tuple[str, bool]:
    form = rf"eulerdisk \d[\w.+]*, method {re.escape(spec.method)}"
    return "eulerdisk VERSION, method of the spec", re.fullmatch(form, str(stored["source"])) is not None


def _fingerprint(spec: SweepSpec, stored: Mapping[str, Any]) -> tuple[str, bool]:
    digest = hashlib.sha256(str(stored["sweep_spec"]).encode()).hexdigest()
    return "SHA-256 of sweep_spec", str(stored["sweep_fingerprint"]) == digest


def _canonical(spec: SweepSpec, stored: Mapping[str, Any]) -> tuple[str, bool]:
    return "the canonical text of the spec that it spells", str(stored["sweep_spec"]) == spec.canonical()


def _created(spec: SweepSpec, stored: Mapping[str, Any]) -> tuple[str, bool]:
    text = str(stored["date_created"])
    return "a time in history", bool(_TIME.fullmatch(text)) and text in str(stored.get("history", text))


def _hash(spec: SweepSpec, stored: Mapping[str, Any]) -> tuple[str, bool]:
    return "the form of a SHA-256", re.fullmatch("[0-9a-f]{64}", str(stored["kernel_hash"])) is not None


def _versions(spec: SweepSpec, stored: Mapping[str, Any]) -> tuple[str, bool]:
    try:
        named = json.loads(str(stored["versions"]))
    except (ValueError, RecursionError):
        named = None
    right = isinstance(named, dict) and all(isinstance(each, str) for each in named.values())
    return "a table of versions in JSON", right


def _words(name: str) -> _Form:
    return lambda _, stored: ("words", isinstance(stored[name], str))


_FORMS: Mapping[str, _Form] = {
    "source": _source,
    "sweep_fingerprint": _fingerprint,
    "sweep_spec": _canonical,
    "date_created": _created,
    "kernel_hash": _hash,
    "versions": _versions,
    "title": _words("title"),
    "history": _words("history"),
}


def _variable_statements(
    declared: Mapping[str, Declaration], dataset: "xr.Dataset", own: bool
) -> Iterator[Statement]:
    in_file = "source" in dataset.encoding
    scalars = {name for name, each in declared.items() if each.coordinate and not each.dims}
    for name, each in declared.items():
        if name not in dataset:
            if own:
                yield _wrong(name, "what every atlas of its spec has", "missing")
            else:
                yield unchecked(name, "not in the file: made by other code, which may not have known it")
            continue
        yield from _of_variable(each, dataset[name], own, in_file, scalars)
    for name in map(str, dataset.variables):
        if name not in declared:
            yield unchecked(name, "no variable of an atlas of its spec")


def _of_variable(
    declared: Declaration, variable: "xr.DataArray", own: bool, in_file: bool, scalars: Set[str]
) -> Iterator[Statement]:
    """Yield one statement of all attributes of a variable that are right, and one of each that is not."""
    stored, expected = {**variable.attrs}, dict(declared.attributes)
    if in_file:
        encoded = variable.encoding
        stored |= {
            name: encoded[name] for name in ("_FillValue", "coordinates") if encoded.get(name) is not None
        }
        if declared.fill is not None:
            expected["_FillValue"] = declared.fill
    else:
        # what xarray keeps among the encoding it drops in most operations
        expected.pop("coordinates", None)
        stored.pop("coordinates", None)
    right = 0
    for name, value in {"dtype": declared.dtype, "dimensions": list(declared.dims), **expected}.items():
        given = {"dtype": variable.dtype.str[1:], "dimensions": list(map(str, variable.dims))}.get(
            name, stored.get(name)
        )
        place = f"{declared.name}:{name}"
        if given is not None and (_equal_lists(given, value) or (not own and _older(name, given, value))):
            right += 1
        elif own or name in (*_MEANING, "dtype", "dimensions"):
            words = "missing" if given is None else f"{shown(given)} instead of {shown(value)}"
            yield _wrong(place, "the table of the model", words)
    yield Statement(f"{declared.name}:", "the table of the model", judged=right)
    for name in stored.keys() - expected.keys():
        if name == "coordinates" and set(str(stored[name]).split()) <= scalars:
            # xarray adds it when it saves a variable from memory
            continue
        if name in (
            "coordinates",
            "_FillValue",
            "flag_values",
            "flag_meanings",
            "units",
            "scale_factor",
            "add_offset",
        ):
            yield _wrong(
                f"{declared.name}:{name}",
                "the table of the model",
                f"{shown(stored[name])} instead of nothing",
            )
        else:
            yield unchecked(f"{declared.name}:{name}", "no attribute of such a variable")


def _equal_lists(given: Any, value: Any) -> bool:
    return given == value if isinstance(value, list) else _equal(given, value)


def _older(name: str, given: Any, value: Any) -> bool:
    """Return whether flags and coordinates are those of a version that knew fewer of them."""
    if name == "flag_values":
        return np.array_equal(given, np.asarray(value)[: np.size(given)])
    if name == "coordinates":
        return set(str(given).split()) <= set(str(value).split())
    if name == "flag_meanings":
        return isinstance(given, str) and str(value).split()[: len(given.split())] == given.split()
    return False
