"""An open file shows what xarray shows of it: xarray is the referee."""

import netCDF4
import numpy as np
import pytest
import xarray as xr

import sweep
from sweep.commands.report import boundary_table, describe
from sweep.files.atlas_file import AtlasFile
from sweep.files.reading import open_atlas, opened_file

SPECS = {
    "curves": {"roll_rate": "2:4:7", "tilt": "1deg,2deg,4deg", "boundary": "refined:1e-3", "contact": "yes"},
    "falls": {"roll_rate": "0:3:6", "tilt": "20deg"},
    "exact": {"precession_rate": "0.5:4:6", "tilt": "5deg,10deg", "method": "exact"},
    "cell": {"tilt": "1deg", "roll_rate": 3},
}


def assert_same(path):
    """Assert that every variable of a file is to `AtlasFile` what it is to xarray."""
    with (
        AtlasFile(path) as file,
        xr.open_dataset(path, engine="netcdf4", decode_times=False) as dataset,
    ):
        assert dict(file.sizes) == dict(dataset.sizes)
        assert file.encoding["source"] == dataset.encoding["source"]
        assert {*file.variables} == {*dataset.variables}
        np.testing.assert_equal(file.attrs, dataset.attrs)
        for name, expected in dataset.variables.items():
            found = file[name]
            assert (found.dims, found.shape, found.dtype) == (
                expected.dims,
                expected.shape,
                expected.dtype,
            ), name
            assert found.values.dtype == expected.dtype, name
            np.testing.assert_array_equal(found.values, expected.values, err_msg=name)
            np.testing.assert_equal(found.attrs, expected.attrs, err_msg=name)
            for part in (0,) * found.values.ndim, (slice(1, None),) * found.values.ndim:
                np.testing.assert_array_equal(found[part], expected[part].values, err_msg=name)


@pytest.fixture
def path(tmp_path):
    """Return where a test writes its file."""
    return tmp_path / "a.nc"


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
def test_every_variable_of_an_atlas_is_that_of_xarray(path, spec):
    """Names, dimensions, types, attributes and values of whole variables and of parts; missing ones are NaN."""
    sweep.run_to_file(sweep.SweepSpec(**spec), path)
    assert_same(path)


@pytest.mark.filterwarnings("ignore:.*multiple fill values")
@pytest.mark.parametrize("kind", ["i1", "u2", "i4", "f4", "f8", ">f8", ">i2"])
@pytest.mark.parametrize(
    "attributes",
    [
        {},
        {"_FillValue": 3},
        {"missing_value": 5},
        {"_FillValue": 3, "missing_value": 5},
        {"scale_factor": 0.5},
        {"_FillValue": 3, "add_offset": 2.0, "scale_factor": 0.25},
    ],
    ids=lambda attributes: " ".join(attributes) or "plain",
)
def test_encoded_variables_are_decoded_as_by_xarray(path, kind, attributes):
    """Fill values, scales and offsets of other programs, in every type of numbers."""
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("x", 8)
        stored = file.createVariable(
            "stored",
            kind,
            ("x",),
            fill_value=attributes.get("_FillValue"),
            endian=(">" in kind and "big") or "native",
        )
        stored.set_auto_maskandscale(False)
        for name in attributes.keys() - {"_FillValue"}:
            value = attributes[name]
            stored.setncattr(name, stored.dtype.type(value) if name == "missing_value" else value)
        stored[:] = np.arange(8)
    with AtlasFile(path) as file, xr.open_dataset(path, engine="netcdf4", decode_times=False) as dataset:
        assert file["stored"].dtype.kind == dataset["stored"].dtype.kind
        assert file["stored"].dtype.isnative
        np.testing.assert_array_equal(file["stored"].values, dataset["stored"].values)


def test_truths_are_no_numbers(path):
    """What xarray writes as a truth is read as one."""
    xr.Dataset({"a": ("x", [True, False])}).to_netcdf(path, engine="netcdf4")
    with AtlasFile(path) as file:
        assert file["a"].dtype == bool
        assert file["a"].values.tolist() == [True, False]


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
def test_reports_are_the_same_of_a_dataset(path, spec):
    """A report says the same of an open file and of a dataset, whichever reads it."""
    sweep.run_to_file(sweep.SweepSpec(**spec), path)
    with opened_file(path) as file, open_atlas(path) as dataset:
        assert describe(file) == describe(dataset)
        assert boundary_table(file) == boundary_table(dataset)


def test_a_file_is_closed(path):
    """After the ``with`` block another process may write; what was read stays."""
    sweep.run_to_file(sweep.SweepSpec(**SPECS["cell"]), path)
    with opened_file(path) as file:
        values = file["tilt_max"].values
    netCDF4.Dataset(path, "a").close()
    np.testing.assert_array_equal(file["tilt_max"].values, values)
