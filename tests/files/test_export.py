"""Exports in other formats have the same numbers, and other programs can read them."""

import csv
import json
import sys

import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest
import xarray as xr
from messages import refused

import sweep
from sweep.cli import main
from sweep.files.export import FORMATS, Format, export
from sweep.files.publish import published
from sweep.model.disk.tables import PARAMETERS, VARIABLES

SPECS = {
    "falling": sweep.SweepSpec(roll_rate="0:3:6", tilt="5deg:40deg:7", title="Münze"),
    "circling": sweep.SweepSpec.preset("circling").replace(tilt="5deg:15deg:3", precession_rate="0:5:12"),
    "refined": sweep.SweepSpec.preset("rolling").replace(
        roll_rate="2:3:5", tilt="0.1deg:1deg:4", alpha=[0.5, 1.0], boundary="refined:1e-6"
    ),
    "cell": sweep.SweepSpec(tilt="1deg", roll_rate=3),
}


@pytest.fixture(params=SPECS)
def atlas(request):
    """Return an atlas: one with falls, one with an invalid cell, one with curves, and one without axes."""
    return sweep.run(SPECS[request.param])


def expected(atlas, kind):
    """Return the expected rows of a table, made by numpy only."""
    ending = atlas["ending"]
    rows = {}
    # curves do not belong to cells, and csv has a separate table for the boundary
    left_out = ("curve_", *(("boundary_", "predicted_", "critical_") if kind == "csv" else ()))
    for name in (*ending.dims, *PARAMETERS, *atlas.data_vars):
        if name in atlas and not name.startswith(left_out):
            variable = atlas[name]
            shape = [count if dim in variable.dims else 1 for dim, count in ending.sizes.items()]
            rows[name] = np.broadcast_to(variable.values.reshape(shape), ending.shape).reshape(-1)
    for name in rows:
        if "flag_meanings" not in atlas[name].attrs:
            continue
        words = np.array(atlas[name].attrs["flag_meanings"].split())
        rows[name] = words[rows[name]]
    return rows


def read_csv(path):
    """Return the columns of a table, read without pandas; an empty field is a missing value."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] or "nan" for row in rows] for name in rows[0]}


@pytest.mark.parametrize("rows", [250_000, 10], ids=["whole", "in parts"])
@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_tables_hold_every_bit(tmp_path, monkeypatch, atlas, kind, rows):
    """There is one row per cell in C order, with all digits, flags as words and gaps for missing values."""
    monkeypatch.setattr("sweep.files.export._ROWS", rows)
    path = tmp_path / f"a.{kind}"
    export(atlas, path, kind)
    truth = expected(atlas, kind)
    read = read_csv(path) if kind == "csv" else pd.read_parquet(path)
    assert list(read)[: atlas.ending.ndim] == list(atlas.ending.dims)
    assert set(read) == set(truth)
    for name, values in truth.items():
        np.testing.assert_array_equal(np.asarray(read[name]).astype(values.dtype), values, err_msg=name)
    apart = [tmp_path / "a.boundary.csv"] if kind == "csv" and _has_boundary(atlas) else []
    assert sorted(tmp_path.iterdir()) == sorted([path, *apart])


def _has_boundary(atlas):
    return any(name.startswith("boundary_") for name in atlas.data_vars)


@pytest.mark.parametrize("name", ["falling", "circling", "refined"])
def test_the_boundary_is_a_table_of_its_own(tmp_path, name):
    """The table has one row per grid row, with all digits and the reason for a missing boundary."""
    atlas = sweep.run(SPECS[name])
    export(atlas, tmp_path / "a.csv", "csv")
    read = read_csv(tmp_path / "a.boundary.csv")
    rows = 0
    for edge in ("upper", "lower"):
        for along in [each for each in atlas.ending.dims if PARAMETERS[each].control]:
            if f"boundary_{'lower_' * (edge == 'lower')}{along}" not in atlas:
                continue
            found = atlas.eulerdisk.boundary(along, edge)
            here = [
                i
                for i, (parameter, side) in enumerate(zip(read["along"], read["edge"], strict=True))
                if (parameter, side) == (along, edge)
            ]
            rows += len(here)
            assert len(here) == found["measured"].size
            for column in ("measured", "halfwidth", "predicted", "critical"):
                values = np.array([float(read[column][i]) for i in here])
                np.testing.assert_array_equal(values, found[column].values.reshape(-1), err_msg=column)
            words = np.array(found["status"].attrs["flag_meanings"].split())[
                found["status"].values.reshape(-1)
            ]
            assert [read["status"][i] for i in here] == words.tolist()
            for axis in found["measured"].dims:
                values = np.broadcast_to(
                    found[axis].values.reshape([-1 if dim == axis else 1 for dim in found["measured"].dims]),
                    found["measured"].shape,
                )
                np.testing.assert_array_equal([float(read[axis][i]) for i in here], values.reshape(-1))
            assert {read[along][i] for i in here} == {"nan"}
    assert rows == len(read["along"])


def test_curves_are_the_boundary_without_a_control(tmp_path):
    """Without a control axis, the boundary table has the points of the curves."""
    spec = sweep.SweepSpec(tilt="0.5deg:6deg:9", tilt_rate="0:0.5:9", roll_rate=3, boundary="refined:1e-3")
    atlas = sweep.run(spec)
    export(atlas, tmp_path / "a.csv", "csv")
    read = read_csv(tmp_path / "a.boundary.csv")
    np.testing.assert_array_equal(np.array(read["tilt"], float), atlas["curve_tilt"].values)
    np.testing.assert_array_equal(
        np.array(read["tilt_rate_halfwidth"], float), atlas["curve_tilt_rate_halfwidth"]
    )
    assert len(read["curve"]) == int(atlas["curve_point_count"].sum()) >= 4


def test_parquet_keeps_units_and_types(tmp_path):
    """The metadata of a parquet file contain the attributes; small integers and floats keep their size."""
    atlas = sweep.run(SPECS["falling"])
    export(atlas, tmp_path / "a.parquet", "parquet")
    schema = pyarrow.parquet.read_schema(tmp_path / "a.parquet")
    for name, quantity in VARIABLES.items():
        metadata = schema.field(name).metadata
        assert metadata[b"long_name"].decode() == quantity.long_name
        if quantity.flags is None:
            assert metadata[b"units"].decode() == quantity.units
            assert schema.field(name).type.to_pandas_dtype() == np.dtype(quantity.dtype)
    assert schema.metadata[b"sweep_spec"].decode() == SPECS["falling"].canonical()


@pytest.mark.slow_lane
def test_zarr_is_the_same_dataset(tmp_path, atlas):
    """A zarr store read by xarray has every value, type and attribute of the atlas."""
    export(atlas, tmp_path / "a.zarr", "zarr")
    with xr.open_zarr(tmp_path / "a.zarr") as read:
        xr.testing.assert_equal(read, atlas)
        assert set(read.coords) == set(atlas.coords)
        for name, variable in atlas.variables.items():
            assert read[name].dtype == variable.dtype
            assert read[name].attrs.keys() == variable.attrs.keys()
        assert read.attrs["sweep_spec"] == atlas.attrs["sweep_spec"]
    assert [path.name for path in tmp_path.iterdir()] == ["a.zarr"]


def test_what_exists_is_replaced_only_when_asked(tmp_path):
    """Overwriting replaces a file or a store, but never a folder that is not a store."""
    atlas = sweep.run(SPECS["cell"])
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    for kind in ("csv", "zarr"):
        path = tmp_path / f"a.{kind}"
        export(atlas, path, kind)
        with refused("exists", "--overwrite"):
            export(atlas, path, kind)
        export(atlas, path, kind, overwrite=True)
    # "." has no file name from which the boundary's file could be named
    with refused("."):
        export(atlas, ".", "csv")
    with refused("zarr store"):
        export(atlas, tmp_path / "mine", "zarr", overwrite=True)
    assert (tmp_path / "mine" / "letter.txt").read_text() == "dear"


def test_a_format_that_cannot_be(tmp_path, monkeypatch):
    """An unknown format and a missing library are refused with advice, and nothing is written."""
    atlas = sweep.run(SPECS["cell"])
    with refused("xls", "csv", "parquet", "zarr"):
        export(atlas, tmp_path / "a.xls", "xls")
    monkeypatch.setattr("sweep.files.export.find_spec", lambda _: None)
    with refused("parquet", "pyarrow", "csv", "pip install pyarrow"):
        export(atlas, tmp_path / "a.parquet", "parquet")
    assert list(tmp_path.iterdir()) == []


def extremes(dataset, path):
    """Write the extreme tilts of an atlas as one line of JSON."""
    with published(path) as unfinished:
        unfinished.write_text(json.dumps([float(dataset.tilt_min.min()), float(dataset.tilt_max.max())]))


def test_a_format_is_one_entry(tmp_path, monkeypatch):
    """A new format needs only a function and a name; checks, replacing and the list of formats follow."""
    monkeypatch.setitem(FORMATS, "extremes", Format(extremes))
    sweep.run_to_file(SPECS["cell"], tmp_path / "a.nc")
    for line, status in (("", 0), ("", 2), ("--overwrite", 0)):
        words = ["eulerdisk", "export", str(tmp_path / "a.nc"), "--to", "extremes", *line.split()]
        monkeypatch.setattr(sys, "argv", words)
        with pytest.raises(SystemExit) as end:
            main()
        assert end.value.code == status
    atlas = sweep.run(SPECS["cell"])
    written = json.loads((tmp_path / "a.extremes").read_text())
    assert written == [float(atlas.tilt_min), float(atlas.tilt_max)]
    with refused("xls", "csv", "parquet", "zarr", "extremes"):
        export(atlas, tmp_path / "a.xls", "xls")


def test_the_command(tmp_path, monkeypatch):
    """Without -o, the table is written next to the atlas."""
    sweep.run_to_file(SPECS["cell"], tmp_path / "a.nc")
    monkeypatch.setattr(sys, "argv", ["eulerdisk", "export", str(tmp_path / "a.nc"), "--to", "csv"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 0
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 2


def test_a_boundary_of_what_was_replaced_does_not_stay(tmp_path):
    """If the new atlas has no boundary, the old boundary table is replaced by its heading only."""
    atlas = sweep.run(SPECS["falling"])
    export(atlas, tmp_path / "a.csv", "csv")
    assert (tmp_path / "a.boundary.csv").exists()
    export(sweep.run(SPECS["cell"]), tmp_path / "a.csv", "csv", overwrite=True)
    heading = "along,edge,measured,halfwidth,predicted,critical,status\n"
    assert (tmp_path / "a.boundary.csv").read_text() == heading
