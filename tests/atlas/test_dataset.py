import json
import math

import numpy as np
import pytest
import xarray as xr
from messages import refused

import sweep
from sweep.atlas.dataset import edge_status, spec_of
from sweep.engine.grid import chunk_shape
from sweep.errors import RequestError
from sweep.model.disk.tables import PARAMETERS, SETTINGS, VARIABLES
from sweep.model.quantity import FILL
from sweep.request.spec import SweepSpec

ROLLING = SweepSpec.preset("rolling").replace(roll_rate="2:4:9", tilt="0.1deg:1.5deg:5:log")
CIRCLING = SweepSpec.preset("circling").replace(tilt="5deg:15deg:3", precession_rate="0.1:5:12")
EDGE_NAMES = ("boundary_{}", "boundary_{}_halfwidth", "predicted_{}", "critical_{}", "boundary_{}_status")

#: Two values for each parameter as an axis.
PAIRS = {
    "tilt": "1deg,2deg",
    "tilt_rate": "0,0.1",
    "precession_rate": "0,1",
    "roll_rate": "2,4",
    "alpha": "0.5,1",
    "radius": "20cm,50cm",
    "gravity": "1.62,9.81",
}


@pytest.fixture(scope="module")
def rolling():
    """Return a small atlas of released disks."""
    return sweep.run(ROLLING)


@pytest.fixture(scope="module")
def circling():
    """Return a small atlas of steady motions."""
    return sweep.run(CIRCLING)


def test_a_run_takes_the_name_of_a_preset_or_a_file_with_changes(tmp_path, rolling):
    """A spec, a preset and a TOML file, each with or without changes, give the same atlas."""
    path = tmp_path / "sweep.toml"
    path.write_text(ROLLING.to_toml(), encoding="utf-8")
    changes = {"roll_rate": "2:4:9", "tilt": "0.1deg:1.5deg:5:log"}
    for found in (
        sweep.run("rolling", **changes, threads=1),
        sweep.run(path),
        sweep.run(str(path)),
        sweep.run(SweepSpec.preset("rolling"), **changes),
    ):
        xr.testing.assert_equal(found, rolling)
        assert found.attrs["sweep_fingerprint"] == rolling.attrs["sweep_fingerprint"]
    # a departure limit of 5 deg moves the coin's critical rate, sqrt(g/3R), by 0.3 %
    coin = sweep.run("rolling", radius="12mm", tilt="0.01deg")
    assert float(coin.boundary_roll_rate) == pytest.approx(math.sqrt(9.81 / (3 * 0.012)), rel=0.005)


@pytest.mark.parametrize(
    ("spec", "changes", "facts"),
    [
        ("roling", {}, ["roling", "rolling?"]),
        ("absent.toml", {}, ["absent.toml", "No such file"]),
        ("rolling", {"radus": 1}, ["radus", "radius?"]),
        ("rolling", {"model": "bead"}, ["model", 'model = "disk"']),
        ("rolling", {"mass": 1}, ["mass", "eulerdisk simulate"]),
        ("rolling", {"self": 1}, ["self"]),
        (ROLLING, {"self": 1}, ["self"]),
        (ROLLING, {"radius": -1}, ["radius > 0"]),
        (None, {}, ["SweepSpec", ".toml", "None"]),
        (3, {}, ["SweepSpec", ".toml", "3"]),
    ],
)
def test_a_run_of_nothing_that_is_a_spec_is_refused(tmp_path, spec, changes, facts):
    """Runs of an invalid spec are refused, in memory and to a file, with a hint; nothing is written."""
    for run in (sweep.run, lambda spec, **changes: sweep.run_to_file(spec, tmp_path / "a.nc", **changes)):
        with refused(*facts) as caught:
            run(spec, **changes)
        assert caught.value.hint
    assert list(tmp_path.iterdir()) == []


def test_every_variable_of_the_table_is_there(rolling, circling):
    """Measures have all axes, edges of a rate have the other axes, and parameters are coordinates."""
    assert dict(rolling.sizes) == {"roll_rate": 9, "tilt": 5}
    assert set(rolling.data_vars) == {*VARIABLES, *(name.format("roll_rate") for name in EDGE_NAMES)}
    assert set(rolling.coords) == set(PARAMETERS)
    edges = [name.format(edge + "precession_rate") for name in EDGE_NAMES for edge in ("", "lower_")]
    assert set(circling.data_vars) == {*VARIABLES, "roll_rate", *edges}
    assert set(circling.coords) == set(PARAMETERS) - {"roll_rate"}
    for dataset, others in ((rolling, ("tilt",)), (circling, ("tilt",))):
        for name, variable in dataset.data_vars.items():
            assert variable.dims == (
                others if name.startswith(("bound", "pred", "crit")) else tuple(dataset.sizes)
            )


def test_variables_are_described_by_the_table(rolling):
    """Each variable has the type, units, long name and flags of the table; each measure points to its ending."""
    for name, quantity in VARIABLES.items():
        variable = rolling[name]
        assert variable.dtype == quantity.dtype
        assert variable.attrs["long_name"] == quantity.long_name
        assert variable.attrs["cell_methods"] == "roll_rate: tilt: point"
        if quantity.flags is None:
            assert (variable.attrs["units"], variable.attrs["ancillary_variables"]) == (
                quantity.units,
                "ending",
            )
            continue
        assert "units" not in variable.attrs
        assert (
            dict(zip(variable.flag_values.tolist(), variable.flag_meanings.split(), strict=True))
            == quantity.flags
        )
        assert variable.flag_values.dtype == np.int8
        assert set(np.unique(variable)) <= set(quantity.flags)
    for name, quantity in PARAMETERS.items():
        comment = {"comment": quantity.description} if quantity.description else {}
        assert rolling[name].attrs == {"long_name": quantity.long_name, "units": quantity.units} | comment
    for name in EDGE_NAMES[:4]:
        assert rolling[name.format("roll_rate")].attrs["units"] == "rad s-1"


def test_attributes_are_plain_text_and_numbers():
    """Every name and attribute is ASCII and of a type of the classic model, whatever the title."""
    dataset = sweep.run(SweepSpec(title="Münze ☃", tilt=[0.1]))
    assert dataset.attrs["title"] == "M\\xfcnze \\u2603"
    for name, variable in {**dataset.variables, "": dataset}.items():
        assert name.isascii()
        for key, value in variable.attrs.items():
            assert key.isascii()
            assert isinstance(value, str | float | np.int32 | np.ndarray), (name, key)
            assert not isinstance(value, str) or value.isascii(), (name, key)


def test_provenance(monkeypatch):
    """The attributes state how the atlas was made and contain everything to make it again."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    found = sweep.run(ROLLING).attrs
    assert found["Conventions"] == "CF-1.11, ACDD-1.3"
    assert SweepSpec.from_canonical(found["sweep_spec"]) == ROLLING
    assert found["sweep_fingerprint"] == ROLLING.fingerprint()
    assert (found["date_created"], found["history"]) == (
        "1970-01-02T00:00:00Z",
        "1970-01-02T00:00:00Z sweep.run",
    )
    assert found["criterion"] == "departure:5deg"
    assert {name: found[name] for name in SETTINGS} == {name: getattr(ROLLING, name) for name in SETTINGS}
    assert json.loads(found["versions"]).keys() >= {"numba", "numpy", "xarray", "netCDF4"}
    assert sweep.__version__ in found["source"]
    assert len(found["kernel_hash"]) == 64


def test_cells_stand_where_their_coordinates_say(rolling):
    """A cell selected by its coordinates equals a run with exactly these values."""
    for rate, tilt in ((0, 0), (8, 0), (3, 4)):
        cell = rolling.isel(roll_rate=rate, tilt=tilt)
        alone = sweep.run(ROLLING.replace(roll_rate=float(cell.roll_rate), tilt=float(cell.tilt)))
        for name in VARIABLES:
            np.testing.assert_array_equal(cell[name], alone[name])


def test_any_parameter_can_be_an_axis():
    """Each of the seven parameters can be an axis, with its values as coordinate and no invalid cell."""
    for name in PARAMETERS:
        dataset = sweep.run(SweepSpec(**{"tilt": "1deg", "roll_rate": 3, name: PAIRS[name]}))
        assert dict(dataset.sizes) == {name: 2}
        np.testing.assert_array_equal(dataset[name], getattr(spec_of(dataset), name).array())
        assert dataset.ending.attrs["flag_meanings"].split()[int(dataset.ending[0])] == "bounded"
        assert float(dataset.peak_tilt[0]) != float(dataset.peak_tilt[1])


def test_any_number_of_axes():
    """With one to seven axes or a single cell, the dimensions are the axes in the given order."""
    for count in range(8):
        names = [*reversed(PARAMETERS)][:count]
        dataset = sweep.run(
            SweepSpec(
                **{name: PAIRS[name] for name in names}, **({} if "tilt" in names else {"tilt": "1deg"})
            )
        )
        assert dataset.ending.dims == tuple(names)
        assert dataset.ending.shape == (2,) * count
        assert set(dataset.coords) == set(PARAMETERS)
        scalars = " ".join(name for name in PARAMETERS if name not in names)
        assert dataset.ending.encoding.get("coordinates", "") == scalars


def test_the_boundary_is_that_of_the_verdicts(rolling):
    """The boundary minus and plus its half-width gives the last unstable and the first stable rate of each row."""
    rates = rolling.roll_rate.values
    for row in range(5):
        verdicts = rolling.stability.values[:, row]
        last, first = rates[verdicts == 2].max(), rates[verdicts == 1].min()
        assert float(rolling.boundary_roll_rate[row]) == (last + first) / 2
        assert float(rolling.boundary_roll_rate_halfwidth[row]) == (first - last) / 2


def test_the_critical_rates_are_the_analytic_ones(rolling):
    """The squared critical roll rate is g/3R, or g/4R for a hoop; for a spinning disk it is 4g/5R, or 2g/3R."""
    np.testing.assert_allclose(rolling.critical_roll_rate, math.sqrt(9.81 / 1.5), rtol=1e-14)
    for words, factors in (
        ({"roll_rate": "1:4:4"}, [1 / 3, 1 / 4]),
        ({"precession_rate": "1:4:4"}, [4 / 5, 2 / 3]),
    ):
        dataset = sweep.run(SweepSpec(tilt="1deg", alpha="0.5,1", radius=2.0, **words))
        squares = dataset[f"critical_{next(iter(words))}"] ** 2 * 2.0 / 9.81
        np.testing.assert_allclose(squares, factors, rtol=1e-14)


def test_a_steady_roll_rate_is_stored_per_cell(circling):
    """The computed roll rate satisfies the condition of steady circling in every cell."""
    tilt, turn = circling.tilt, circling.precession_rate
    # uniform disk: 4 g sin + (2 + alpha) R turn^2 sin(2 tilt) + 4 (1 + alpha) R roll turn cos = 0
    residue = (
        4 * 9.81 * np.sin(tilt)
        + 2.5 * 0.5 * turn**2 * np.sin(2 * tilt)
        + 6 * 0.5 * circling["roll_rate"] * turn * np.cos(tilt)
    )
    assert float(abs(residue).max()) < 1e-13
    assert circling["roll_rate"].dims == ("tilt", "precession_rate")


def test_the_encoding_is_the_profile_of_the_file(rolling):
    """Only measured floats have a fill value; chunks follow from the grid, and everything uses zlib."""
    for name, variable in rolling.variables.items():
        measured = variable.dtype.kind == "f" and name not in PARAMETERS
        assert variable.encoding["_FillValue"] == (FILL if measured else None), name
        assert variable.encoding["dtype"] == variable.dtype
        if name in VARIABLES:
            assert variable.encoding["chunksizes"] == chunk_shape((9, 5))
            assert variable.encoding["zlib"]
            assert variable.encoding["shuffle"]


def test_ways_to_run_change_nothing(monkeypatch):
    """The number of threads and the block size do not change the dataset."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    whole = sweep.run(ROLLING)
    xr.testing.assert_identical(whole, sweep.run(ROLLING, threads=1, block_cells=7))


def test_a_part_of_an_atlas_is_not_an_atlas(rolling):
    """`spec_of` refuses a part of an atlas, because the stored spec describes the whole."""
    assert spec_of(rolling) == ROLLING
    for part, facts in (
        (rolling.isel(tilt=slice(2)), ["not the whole atlas", "'tilt': 5", "'tilt': 2"]),
        (rolling.isel(tilt=0), ["not the whole atlas", "'tilt': 5"]),
        (
            rolling.transpose(),
            ["order", "roll_rate, tilt", "tilt, roll_rate", "transpose('roll_rate', 'tilt'"],
        ),
    ):
        with pytest.raises(RequestError) as caught:
            spec_of(part)
        assert all(fact in str(caught.value) for fact in facts), str(caught.value)


def test_an_unknown_row_status_is_an_error_of_the_file():
    """An unknown status code is refused by name, like an unknown ending."""
    atlas = sweep.run(sweep.SweepSpec(roll_rate="2:3:4", tilt="1deg:2deg:3")).copy(deep=True)
    atlas["boundary_roll_rate_status"][1] = 114
    with refused("boundary_roll_rate_status", "114", "0, 1"):
        edge_status(atlas, "roll_rate", "upper")
