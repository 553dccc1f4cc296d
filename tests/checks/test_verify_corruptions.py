"""`verify` names every corrupt variable and attribute of every kind of atlas.

The tests go through the content of the files, so that a variable or attribute without a check fails them. No
checksum
protects a file: it contains no hash of its content, and the fingerprint of the spec is checked like any
attribute.
"""

import hashlib
import itertools
from functools import lru_cache

import netCDF4
import numpy as np
import pytest
from kernel_runner import run_blocks
from messages import assert_in_order

import sweep
from sweep.atlas.boundary_search import boundary_groups
from sweep.atlas.completion import BOUNDARY
from sweep.atlas.dataset import assemble, empty_columns
from sweep.checks.verify import _checked, findings, verify
from sweep.errors import RequestError
from sweep.model import space_sample
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.compiled

#: Attributes that may differ, with the reason that the report of `verify` gives.
FREE_TEXT = {
    "title": "free text",
    "history": "free text, beside the time of date_created",
    "kernel_hash": "names code that cannot be had from it: all that is found is that other code made the file",
    "versions": "nothing in the file follows from them",
    "requested_as": "words and units that the spec does not contain",
}


def partial(spec):
    """Return an atlas whose last block is not computed, as `info --partial` writes it."""
    columns = empty_columns(spec)
    *first, last = run_blocks(spec, block_cells=10)
    for block in first:
        for name, column in block.columns.items():
            columns[name][block.span.start : block.span.stop] = column
    for column in columns.values():
        column[last.span.start :] = np.nan if column.dtype.kind == "f" else 0
    dataset = assemble(spec, columns, "sweep.run")
    return dataset.assign_attrs(comment="Partial: 2 of 3 blocks; the other cells are not computed.")


def small(preset, **words):
    """Return a preset with few cells."""
    return SweepSpec.preset(preset).replace(**words)


ROLLING = {"roll_rate": "2:4:6", "tilt": "0.1deg,1deg,4deg"}
SPECS = {
    "rolling": small("rolling", **ROLLING),
    "spinning": small("spinning", precession_rate="3:5:6", tilt="0.1deg,1deg"),
    "circling": small("circling", precession_rate="0.1:5:9", tilt="2deg,9deg", contact="yes"),
    "steady": SweepSpec(tilt="5deg,10deg", precession_rate="steady-slow", roll_rate="-8:8:5", tilt_rate=1e-3),
    "refined": small("rolling", **ROLLING, boundary="refined:1e-9"),
    "edges": small("circling", precession_rate="0.05:6:14", tilt="2deg,9deg", boundary="refined:1e-8"),
    "cube": SweepSpec(
        alpha="0.5,1", roll_rate="2:3.5:4", tilt="1deg,4deg", boundary="refined", criterion="amplification:9"
    ),
    "exact": small("rolling", **ROLLING, method="exact", contact="yes"),
    "falls": SweepSpec(tilt="-50deg,20deg", roll_rate="0:3:7", tilt_rate="-1,1", contact="yes"),
    "horizon": small("rolling", **ROLLING, duration=1.2),
    "cell": SweepSpec(tilt="1deg", roll_rate=3, contact="yes"),
    "partial": small("rolling", **{**ROLLING, "roll_rate": "2:4:9"}),
    "own": small(
        "rolling", **ROLLING, boundary="refined:1e-6", criterion="peak_tilt > 3*tilt and nutation_period > 3s"
    ),
    "own falls": SweepSpec(
        tilt="-50deg,20deg",
        roll_rate="0:3:7",
        criterion="fall_time < 0.3s or ending != fell",
        boundary="refined:1e-3",
    ),
    "reclassified": small("rolling", **ROLLING),
}
KINDS = tuple(SPECS)


@lru_cache
def atlas(kind):
    """Return the atlas of a kind; tests must not change it."""
    found = partial(SPECS[kind]) if kind == "partial" else sweep.run(SPECS[kind])
    return sweep.reclassify(found, "departure:2deg") if kind == "reclassified" else found


@pytest.fixture(autouse=True)
def each_once(monkeypatch):
    """Cache results that depend only on the spec and the verdicts, to save time."""
    from sweep.atlas import cf_metadata
    from sweep.checks import verify as verify_module

    # tests/model/test_space_sample.py tests the sample in space
    monkeypatch.setattr(space_sample, "FEW", 0)
    monkeypatch.setattr(verify_module, "boundary_groups", _boundary)
    for module in (cf_metadata, verify_module):
        monkeypatch.setattr(module, "arithmetic_hash", _hash)


_KEPT = {}


def _boundary(spec, stability):
    key = spec.canonical() + stability.tobytes().hex()
    if key not in _KEPT:
        _KEPT[key] = boundary_groups(spec, stability)
    return _KEPT[key]


def _hash(spec):
    key = spec.canonical()
    if key not in _KEPT:
        _KEPT[key] = sweep.engine.compute.arithmetic_hash(spec)
    return _KEPT[key]


def wrong_values(dataset):
    """Return the number of wrong values by name, as `verify` finds them."""
    found = findings(verify(dataset))
    assert found.passed == (not found.wrong and not found.missing and not found.disagreeing)
    return {each.name: each.wrong for each in found.wrong}


def test_the_atlases_pass():
    """The uncorrupted atlases have nothing wrong; a partial one does not pass, but no line of it is wrong."""
    for kind in KINDS:
        found = findings(verify(atlas(kind)))
        assert [each.name for each in found.wrong] == [], kind
        assert found.passed == (kind != "partial")


# --- one value of a variable -----------------------------------------------------------------------------------------


def one_value(variable):
    """Return the possible corruptions of one value: each with its function and a bool array of its places."""
    values, codes = variable.values, variable.attrs.get("flag_values")
    if values.dtype.kind == "f":
        finite = np.isfinite(values)
        known = finite & (values != 0.0)
        return {
            "5 % more": (lambda x: 1.05 * x, known),
            "0.1 % more": (lambda x: x + 1e-3 * x, known),
            "zero": (lambda x: 0.0, known),
            "missing": (lambda x: np.nan, finite),
            "not missing": (lambda x: 1.0, ~finite),
        }
    every = np.ones(values.shape, bool)
    if codes is None:
        return {"one more": (lambda x: x + 1, every), "negative": (lambda x: -5, every)}
    legal = [int(code) for code in codes if code != 0 or len(codes) == 2]
    others = (lambda x: legal[(legal.index(x) + 1) % len(legal)], np.isin(values, legal))
    return {"another flag": others, "no flag": (lambda x: 77, every)}


def with_values(dataset, values):
    """Return an atlas with other values of some variables."""
    # variables without coordinates, because xarray would align them with corrupt axes
    replaced = {name: dataset[name].variable.copy(data=each) for name, each in values.items()}
    coords = {name: each for name, each in replaced.items() if name in dataset.coords}
    return dataset.assign_coords(coords).assign(
        {name: each for name, each in replaced.items() if name not in coords}
    )


#: Corrupt values of one variable per copy; more would look like the rounding of another processor.
MOST = 3


def batch(dataset, left):
    """Return a copy with as many corruptions as fit, each in its own cell or row, and the list of them."""
    values, taken, done = {}, {}, []
    for name, label in left:
        change, where = one_value(dataset[name])[label]
        used = taken.setdefault(dataset[name].dims, set())
        place = next((each for each in map(tuple, np.argwhere(where)) if each not in used), None)
        # scalars have no dimensions and would all share one place
        if dataset[name].ndim == 0 and name in dataset.coords and name not in values:
            place = ()
        if place is None or sum(each == name for each, _ in done) == MOST:
            continue
        used.add(place)
        values.setdefault(name, dataset[name].values.copy())[place] = change(dataset[name].values[place])
        done.append((name, label))
    return with_values(dataset, values), done


@pytest.mark.slow_lane
def test_one_corrupt_value_is_named(pick):
    """A value that is 5 % or 0.1 % too large, zero, missing or superfluous is named, and so is any other flag."""
    for kind in pick(KINDS, 5):
        dataset, missed = atlas(kind), []
        # the boundary follows from the verdicts, and other values of a cell from its ending
        alone = ("stability", "ending")
        for group in (
            [name for name in map(str, dataset.variables) if name not in alone],
            *([name] for name in alone),
        ):
            left = [
                (name, label)
                for name in group
                for label, (_, where) in one_value(dataset[name]).items()
                if where.any() and (kind != "cell" or label == "5 % more")
            ]
            while left:
                copy, done = batch(dataset, left)
                found = wrong_values(copy)
                for name in {name for name, _ in done}:
                    labels = [label for other, label in done if other == name]
                    if found.get(name, 0) < len(labels):
                        missed.append((name, labels))
                left = [each for each in left if each not in done]
        assert missed == []


@pytest.mark.slow_lane
def test_one_corrupt_value_of_other_code_is_named_or_said_not_to_be_checked(pick):
    """An atlas of other code is not recomputed: errors that it misses are in lines marked as not checked."""
    for kind in pick(("circling", "rolling", "falls", "exact"), 2):
        dataset, missed = atlas(kind).assign_attrs(kernel_hash="0" * 64), set()
        open_ = {
            each.name
            for each in findings(verify(dataset)).statements
            if "otherwise not checked" in each.against
        }
        for name in (name for name in map(str, dataset.data_vars) if not of_the_boundary(name)):
            for label, (change, where) in one_value(dataset[name]).items():
                if not where.any():
                    continue
                place = tuple(np.argwhere(where)[-1])
                values = dataset[name].values.copy()
                values[place] = change(values[place])
                if not wrong_values(with_values(dataset, {name: values})):
                    missed.add((name, label))
        found_open = {name for name, _ in missed}
        # near a separatrix the tolerance allows any period; no corrupted cell was that near
        assert found_open <= open_ <= {*found_open, "nutation_period"}
        # presence and range of values are checked even then
        assert not {"missing", "not missing", "negative"} & {label for _, label in missed}


# --- a whole variable ------------------------------------------------------------------------------------------------

WHOLE = {
    "5 % more": lambda values: 1.05 * values,
    "zero": lambda values: 0.0 * values,
    "missing": lambda values: np.nan * values,
    "a millionth": lambda values: 1e-6 * values,
    "a thousand times": lambda values: 1e3 * values,
}


def of_the_boundary(name):
    """Return True for variables of the boundary."""
    return name.startswith(("boundary_", "predicted_", "critical_", "curve_"))


@pytest.mark.slow_lane
def test_a_whole_corrupt_variable_is_named(pick):
    """A variable whose values are all 5 % too large, zero, missing, or wrong by a factor is named."""
    for kind in pick(("exact", "refined", "falls"), 1):
        dataset, missed = atlas(kind), []
        floats = [name for name in map(str, dataset.variables) if dataset[name].dtype.kind == "f"]
        floats = [name for name in floats if np.any(np.nan_to_num(dataset[name].values))]
        cells = [name for name in floats if dataset[name].dims == dataset["ending"].dims]
        # the variables of a cell depend on each other; lines of the boundary and coordinates are independent
        others = [name for name in floats if name not in cells and not name.endswith("_halfwidth")]
        halves = [name for name in floats if name.endswith("_halfwidth")]
        for label, change in pick(WHOLE.items(), 3):
            narrow = label in ("a millionth", "a thousand times")
            # a refined atlas has the same cells as others, and its brackets take long
            cells = cells if kind != "refined" else []
            for group in (halves, *([] if narrow else [others, *([name] for name in cells)])):
                found = wrong_values(
                    with_values(dataset, {name: change(dataset[name].values) for name in group})
                )
                missed += [(name, label) for name in group if name not in found]
        assert missed == []


def test_a_missing_variable_is_named():
    """An atlas with a missing variable is refused, or the line of the variable says so."""
    for kind in ("steady", "edges", "exact", "cell"):
        dataset, gone = atlas(kind), []
        # these are recomputed from the spec or the verdicts
        again = {*dataset.coords} - {*dataset["ending"].dims}
        again |= {name for name in map(str, dataset.data_vars) if name.startswith(BOUNDARY)}
        for name in map(str, dataset.variables):
            if name in again:
                continue
            try:
                _checked(dataset.drop_vars(name), None)
            except RequestError:
                with pytest.raises(RequestError, match=name):
                    verify(dataset.drop_vars(name))
            else:
                gone.append(name)
        for code in (dataset.attrs["kernel_hash"], "0" * 64):
            assert set(gone) <= wrong_values(dataset.drop_vars(gone).assign_attrs(kernel_hash=code)).keys()
        assert "fall_time" in gone


def test_a_boundary_of_another_shape_is_named():
    """The report of a boundary with a wrong number of values states the number and the expected one."""
    dataset = atlas("edges")
    values = dataset["boundary_precession_rate"]
    shorter = dataset.assign(boundary_precession_rate=("other", values.values.ravel()[:-1], values.attrs))
    (told,) = (each for each in findings(verify(shorter)).wrong if each.name == "boundary_precession_rate")
    assert_in_order(told.named[0], f"{values.size - 1} values", str(values.size))


def test_a_corrupt_type_is_named():
    """A variable in single precision, or an integer of another width, is named."""
    for kind in ("edges", "exact", "falls"):
        dataset = atlas(kind)
        other = {"f8": "f4", "f4": "f8", "i1": "i2", "i4": "i8"}
        types = {name: other[each.dtype.str[1:]] for name, each in dataset.variables.items()}
        found = wrong_values(
            with_values(dataset, {name: dataset[name].values.astype(types[name]) for name in types})
        )
        assert {f"{name}:dtype" for name in types} <= found.keys()


# --- attributes ------------------------------------------------------------------------------------------------------

#: Attributes that are required for reading, or with which the others are compared.
ALONE = ("sweep_spec", "eulerdisk_format", "kernel_hash", "source")


def other_value(value):
    """Return another value of the same type for an attribute."""
    if isinstance(value, str):
        return f"{value}x"
    return np.asarray(value)[::-1] if np.ndim(value) else 2 * value + 1


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Return the atlases as read from files, with the encodings of the file."""
    folder, found = tmp_path_factory.mktemp("files"), {}
    for kind in KINDS:
        sweep.save(atlas(kind), folder / f"{kind}.nc")
        with sweep.open_atlas(folder / f"{kind}.nc") as dataset:
            found[kind] = dataset.load()
    return found


@pytest.mark.slow_lane
def test_a_corrupt_attribute_is_named(files, pick):
    """Every global and variable attribute is named if it is changed or removed."""
    for kind, change in itertools.product(pick(KINDS, 5), ("another value", "removed")):
        expected, found = corrupt_attributes(files[kind], change)
        free = {"title", "history"} if change == "another value" else set()
        assert expected - found.keys() == free, (kind, change)


@pytest.mark.slow_lane
@pytest.mark.parametrize("name", ["tilt_max", "ending", "steps", "roll_rate"])
@pytest.mark.filterwarnings("ignore:variable .* has _Unsigned attribute")
def test_an_attribute_by_which_others_read_otherwise_is_named(files, tmp_path, name):
    """Added attributes that make other programs treat values as missing, or misread them, are named."""
    for attribute, value in {
        "valid_min": 0.1,
        "valid_max": 2,
        "valid_range": [0, 1],
        "_Unsigned": "true",
        "missing_value": 1e9,
        "flag_masks": np.array([1, 2], np.int8),
        "compress": "roll_rate tilt",
    }.items():
        if attribute == "missing_value" and name not in files["rolling"].coords:
            # xarray refuses a second fill value next to the file's
            continue
        sweep.save(files["rolling"], tmp_path / "a.nc", overwrite=True)
        with netCDF4.Dataset(tmp_path / "a.nc", "a") as file:
            file[name].setncattr(attribute, value)
        with sweep.open_atlas(tmp_path / "a.nc") as dataset:
            assert f"{name}:{attribute}" in wrong_values(dataset)


def corrupt_attributes(dataset, change):
    """Return the names of all attributes, after corrupting them, and what `verify` finds wrong."""
    dataset, expected = dataset.copy(deep=True), set()

    def corrupt(attributes, name, place):
        expected.add(place)
        if change == "removed":
            del attributes[name]
        else:
            attributes[name] = other_value(attributes[name])

    for name in set(dataset.attrs) - {*ALONE, "comment"}:
        corrupt(dataset.attrs, name, name)
    for name, variable in dataset.variables.items():
        for attribute in list(variable.attrs):
            corrupt(variable.attrs, attribute, f"{name}:{attribute}")
        for attribute in ("_FillValue", "coordinates"):
            # xarray adds the coordinates of a curve when it saves one from memory; a run does not
            optional = attribute == "coordinates" and name.startswith("curve_") and change == "removed"
            if variable.encoding.get(attribute) is not None and not optional:
                corrupt(variable.encoding, attribute, f"{name}:{attribute}")
    return expected, wrong_values(dataset)


@pytest.mark.slow_lane
def test_a_corrupt_origin_is_named(files):
    """A corrupt spec, format, code hash or program is named, or the file is not read."""
    for kind in ("rolling", "exact"):
        dataset = files[kind]
        attributes = dataset.attrs
        spec = SweepSpec.from_canonical(attributes["sweep_spec"])
        corrupt = [
            {"sweep_spec": attributes["sweep_spec"].replace(",", ", ")},
            {"kernel_hash": "x" + attributes["kernel_hash"][1:]},
            {"kernel_hash": attributes["kernel_hash"] + "0"},
            {"source": attributes["source"] + "x"},
            {"source": "somebody"},
            {"eulerdisk_format": np.int32(0)},
        ]
        moved = attributes["sweep_spec"].replace('"tilt_rate":0.0', '"tilt_rate":0.001')
        assert "sweep_fingerprint" in wrong_values(dataset.assign_attrs(sweep_spec=moved))
        for each in corrupt:
            assert each.keys() <= wrong_values(dataset.assign_attrs(each)).keys()
        # a spec with a matching fingerprint is contradicted by the cells
        for other in (
            spec.replace(criterion="departure:4deg"),
            spec.replace(alpha=0.6),
            spec.replace(tilt_rate=0.1),
        ):
            text = other.canonical()
            claims = {"sweep_spec": text, "sweep_fingerprint": hashlib.sha256(text.encode()).hexdigest()}
            assert wrong_values(dataset.assign_attrs(claims, criterion=str(other.criterion)))
        for name in ("kernel_hash", "source", "eulerdisk_format"):
            removed = {key: value for key, value in attributes.items() if key != name}
            stripped = dataset.copy()
            stripped.attrs = removed
            assert name in wrong_values(stripped)
        with pytest.raises(RequestError, match="canonical"):
            verify(dataset.assign_attrs(sweep_spec="{}"))


def test_what_other_code_left_out_is_named():
    """Missing global attributes and flags are named, even in an atlas of other code."""
    dataset = atlas("rolling").assign_attrs(kernel_hash="0" * 64)
    assert wrong_values(dataset) == {}
    gone = {"license", "radius", "radius_units", "criterion_meaning"}
    stripped = dataset.copy(deep=True)
    stripped.attrs = {name: value for name, value in dataset.attrs.items() if name not in gone}
    flags = stripped["ending"].attrs
    flags["flag_values"] = flags["flag_values"][:-1]
    flags["flag_meanings"] = flags["flag_meanings"].rpartition(" ")[0]
    assert wrong_values(stripped).keys() == gone | {"ending:flag_values", "ending:flag_meanings"}


def test_what_other_code_says_of_values_is_compared():
    """Units, flags and types are compared, even in an atlas of other code; wording is not."""
    dataset = atlas("rolling").assign_attrs(kernel_hash="0" * 64)
    other = dataset.copy(deep=True)
    other["tilt_max"].attrs.update(units="deg", long_name="another name")
    other["ending"].attrs["flag_meanings"] += "x"
    other["steps"] = other["steps"].astype("i8")
    assert wrong_values(other).keys() == {"tilt_max:units", "ending:flag_meanings", "steps:dtype"}


def test_nothing_is_free_without_a_reason():
    """Only free text is not checked by `verify`, and the report gives the reason."""
    allowed = {**FREE_TEXT, "comment": "free text"}
    for kind in KINDS:
        for each in findings(verify(atlas(kind))).statements:
            if not each.checked and not each.name.endswith(":"):
                assert each.name in allowed
                assert each.against


#: Kinds of atlases, and changes of their variables.
FOUND_WITHOUT_REPETITION = (
    ("rolling", {"boundary_roll_rate": lambda x: 1.05 * x}),
    ("rolling", {"boundary_roll_rate": lambda x: np.nan * x}),
    ("rolling", {"predicted_roll_rate": lambda x: 1.05 * x}),
    ("rolling", {"critical_roll_rate": lambda x: 1.05 * x}),
    ("rolling", {"nutation_period": lambda x: x + 2e-5}),
    ("refined", {"boundary_roll_rate_halfwidth": lambda x: 1e-6 * x}),
    ("refined", {"boundary_roll_rate_halfwidth": lambda x: 1e3 * x}),
    ("refined", {"boundary_roll_rate": lambda x: x + 1e-8}),
    ("refined", {"curve_roll_rate": lambda x: 1.05 * x}),
    ("refined", {"curve_roll_rate_halfwidth": lambda x: 1e-6 * x}),
    ("falls", {"fall_time": lambda x: 1.5 * x}),
    ("falls", {"fall_time": lambda x: x + 1e-3 * x}),
    ("circling", {"least_normal_force": lambda x: 1.05 * x}),
    ("circling", {"friction_needed": lambda x: 1.05 * x}),
    ("exact", {"separatrix": lambda x: 1.05 * x}),
)


def test_numbers_made_by_other_code_are_checked():
    """Without repetition, numbers are checked by quadrature, exact bisection, verdicts and theory."""
    for kind in dict.fromkeys(kind for kind, _ in FOUND_WITHOUT_REPETITION):
        assert wrong_values(atlas(kind).assign_attrs(kernel_hash="0" * 64)) == {}
    for number, (kind, change) in enumerate(FOUND_WITHOUT_REPETITION):
        dataset = atlas(kind).assign_attrs(kernel_hash="0" * 64)
        values = {name: each(dataset[name].values) for name, each in change.items()}
        assert change.keys() <= wrong_values(with_values(dataset, values)).keys(), (number, kind, *change)


def test_a_stated_error_that_is_too_small_is_named():
    """Stated errors are named if all are 0, negative or a thousandth of the true errors."""
    dataset = atlas("rolling")
    true = verify(dataset).tilt_difference.values
    for change in (0.0 * true, -dataset.tilt_error.values, 1e-3 * true + 1e-30):
        found = findings(verify(with_values(dataset, {"tilt_error": change.astype("f4")})))
        assert "tilt_error" in [each.name for each in found.wrong]
    line = next(each for each in findings(verify(dataset)).statements if each.name == "tilt_error")
    assert_in_order(line.against, "0 % of cells", "0.1 %")
