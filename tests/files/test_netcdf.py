import netCDF4
import numpy as np
import pytest
import xarray as xr
from messages import refused

import sweep
from sweep.checks.compare import compare
from sweep.engine.grid import chunk_shape
from sweep.files.netcdf import save
from sweep.files.reading import open_atlas
from sweep.model.disk.tables import PARAMETERS, VARIABLES
from sweep.model.quantity import FILL
from sweep.progress.timetable import COMPUTING
from sweep.request.spec import SweepSpec
from sweep.runs.run import run_to_file

#: Specs with and without falls, steady and released, of 0 to 3 axes, and one with an impossible cell.
SPECS = {
    "rolling": SweepSpec.preset("rolling").replace(roll_rate="2:4:40", tilt="0.1deg:30deg:50:log"),
    "circling": SweepSpec.preset("circling").replace(tilt="5deg:15deg:5", precession_rate="-1:1:5"),
    "falling": SweepSpec(roll_rate="0:3:6", tilt="20deg"),
    "cell": SweepSpec(tilt="1deg", roll_rate=3),
    "cube": SweepSpec(alpha="0.5,1", tilt="1deg,2deg", precession_rate="3:6:7", radius=1),
}


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Give all files of one spec the same date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture
def path(tmp_path):
    """Return the path where a test writes its atlas."""
    return tmp_path / "atlas.nc"


@pytest.mark.slow_lane
@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
def test_the_file_is_the_dataset(path, spec):
    """An atlas written block by block, and a saved one, read back as the dataset that `run` returns."""
    computed = sweep.run(spec)
    run_to_file(spec, path, command="sweep.run", block_cells=7)
    with open_atlas(path) as read:
        xr.testing.assert_identical(read, computed)
        save(read, path.with_name("again.nc"))
    save(computed, path, overwrite=True)
    for name in ("atlas.nc", "again.nc"):
        with open_atlas(path.with_name(name)) as read:
            xr.testing.assert_identical(read, computed)


@pytest.mark.slow_lane
@pytest.mark.parametrize("written", ["by blocks", "from memory", "read and saved"])
@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
def test_the_profile_of_the_file(path, spec, written):
    """Every file has the classic model, plain types, packed cells, and a fill value only on measured floats."""
    run_to_file(spec, path)
    if written == "from memory":
        save(sweep.run(spec), path, overwrite=True)
    if written == "read and saved":
        with open_atlas(path) as read:
            save(read, path, overwrite=True)
    with netCDF4.Dataset(path) as file:
        assert file.data_model == "NETCDF4_CLASSIC"
        assert {name: len(dimension) for name, dimension in file.dimensions.items()} == dict(
            zip(spec.axes, spec.shape, strict=True)
        )
        assert not any(dimension.isunlimited() for dimension in file.dimensions.values())
        assert not file.groups
        for name, variable in file.variables.items():
            assert variable.dtype.str in ("|i1", "<i4", "<f4", "<f8"), name
            measured = variable.dtype.kind == "f" and not (name in PARAMETERS and variable.ndim < 2)
            assert getattr(variable, "_FillValue", None) == (
                variable.dtype.type(FILL) if measured else None
            ), name
            if name in VARIABLES and spec.axes:
                assert tuple(variable.chunking()) == chunk_shape(spec.shape)
                assert variable.filters()["zlib"]
                assert variable.filters()["shuffle"]
            scalars = {each for each in PARAMETERS if each in file.variables and file[each].ndim == 0}
            if name not in PARAMETERS:
                assert set(variable.coordinates.split()) == scalars, name


def test_values_that_are_missing(path):
    """NaN in memory is netCDF's own fill value in the file and is read as NaN."""
    spec = SPECS["falling"]
    run_to_file(spec, path)
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        raw = file["fall_time"][:]
    fell = sweep.run(spec)["ending"].values == 4
    assert 0 < fell.sum() < fell.size
    np.testing.assert_array_equal(raw == FILL, ~fell)
    with open_atlas(path) as read:
        np.testing.assert_array_equal(np.isnan(read.fall_time), ~fell)


def test_flags_stay_small_integers(path):
    """netCDF4 and xarray read flags as int8, and the file gives the meaning of each code."""
    run_to_file(SPECS["falling"], path)
    with netCDF4.Dataset(path) as file, open_atlas(path) as read:
        for name in ("ending", "stability"):
            assert file[name].dtype == read[name].dtype == file[name].flag_values.dtype == np.int8
            assert set(np.unique(read[name])) <= set(file[name].flag_values)
            assert len(file[name].flag_values) == len(file[name].flag_meanings.split())


@pytest.mark.parametrize("spec", [SPECS["rolling"], SPECS["cube"]], ids=["rolling", "cube"])
def test_the_bytes_of_a_file_depend_on_the_grid_alone(path, spec):
    """The number of threads and the block size do not change a byte of the file."""
    run_to_file(spec, path)
    whole = path.read_bytes()
    for how in ({"threads": 1}, {"block_cells": 1 + spec.size // 3}, {"block_cells": 11}):
        run_to_file(spec, path, overwrite=True, **how)
        assert path.read_bytes() == whole, how


def test_a_grid_of_many_chunks(path, monkeypatch):
    """A grid of several chunks is written from blocks that do not align with them."""
    monkeypatch.setattr("sweep.engine.grid.chunk_shape.__defaults__", (64,))
    monkeypatch.setattr("sweep.engine.grid.chunks.__defaults__", (64,))
    spec = SPECS["rolling"]
    run_to_file(spec, path, command="sweep.run", block_cells=37)
    with netCDF4.Dataset(path) as file:
        assert file["tilt_max"].chunking() == [1, 50]
    with open_atlas(path) as read:
        xr.testing.assert_identical(read, sweep.run(spec))


def test_progress_counts_every_block(path):
    """After each block, including the last, the caller gets the number of finished cells and of all cells."""
    heard = []
    run_to_file(SPECS["rolling"], path, block_cells=900, progress=heard.append)
    assert [(each.done, each.size) for each in heard if each.stage == COMPUTING] == [
        (0, 2000),
        (900, 2000),
        (1800, 2000),
        (2000, 2000),
    ]


def test_the_history_says_what_was_run(path):
    """The history contains the command after the time, converted to ASCII."""
    run_to_file(SPECS["cell"], path, command="eulerdisk run Münze.toml")
    with open_atlas(path) as read:
        assert read.attrs["history"] == "2023-11-14T22:13:20Z eulerdisk run M\\xfcnze.toml"


def test_a_selection_of_a_file_can_be_saved(tmp_path):
    """A part of an atlas that was read from a file is saved with chunks of its own shape."""
    sweep.save(sweep.run(sweep.SweepSpec(roll_rate="2:4:9", tilt="1deg:5deg:8")), tmp_path / "a.nc")
    with sweep.open_atlas(tmp_path / "a.nc") as atlas:
        sweep.save(atlas.isel(roll_rate=slice(3)), tmp_path / "b.nc")
        with sweep.open_atlas(tmp_path / "b.nc") as part:
            assert part.tilt_max.equals(atlas.tilt_max.isel(roll_rate=slice(3)))


@pytest.mark.parametrize("value", [{"a": 1}, None, ["a", 1]])
def test_what_netcdf_does_not_hold_is_refused(tmp_path, value):
    """An attribute that netCDF cannot store is named, and no file is written."""
    atlas = sweep.run(sweep.SweepSpec(roll_rate="2:4:3", tilt="1deg,2deg")).copy()
    atlas["tilt_max"].attrs["mine"] = value
    with refused("a.nc", "netCDF classic"):
        sweep.save(atlas, tmp_path / "a.nc")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        (lambda atlas: atlas.eulerdisk.interp(roll_rate=2.413), ["eulerdisk.interp"]),
        (lambda atlas: atlas.drop_vars("stability"), ["lacks stability"]),
        (lambda atlas: atlas.drop_vars(["tilt_min", "ending"]), ["lacks ending, tilt_min"]),
        (lambda atlas: atlas.mean("tilt"), ["floats", "mean", "xarray"]),
        (lambda atlas: atlas.where(atlas.tilt > 0.03, drop=True), ["floats", "isel", "sel"]),
        (lambda atlas: atlas.tilt_min, ["DataArray"]),
    ],
)
def test_what_is_no_atlas_any_more_is_refused(change, facts, tmp_path):
    """A dataset that is no longer an atlas is refused by every function for atlases, and nothing is written."""
    atlas = sweep.run("rolling", roll_rate="2:4:5", tilt="1deg:4deg:4")
    other = change(atlas)
    for ask in (
        lambda: sweep.save(other, tmp_path / "a.nc"),
        lambda: sweep.reclassify(other, "departure:2deg"),
        lambda: sweep.refine(other),
        lambda: sweep.verify(other),
        lambda: compare(other, atlas),
        lambda: compare(atlas, other),
    ):
        with refused(*facts):
            ask()
    assert not list(tmp_path.iterdir())


def test_a_dataset_is_no_spec():
    """``run`` refuses a dataset: the message says how to get its spec and does not print the dataset."""
    atlas = sweep.run("rolling", roll_rate=3, tilt="1deg")
    with refused("dataset", "atlas.eulerdisk.spec"):
        sweep.run(atlas)
    assert sweep.run(atlas.eulerdisk.spec).eulerdisk.spec == atlas.eulerdisk.spec
