"""Variables that another program dropped from an atlas are restored bit for bit from its spec and verdicts."""

import netCDF4
import pytest
import xarray as xr
from messages import assert_facts

import sweep
from sweep.atlas.selection import as_atlas

SPEC = sweep.SweepSpec(roll_rate="2:4:9", tilt="1deg:4deg:4", boundary="refined:1e-6")


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas with edges and curves."""
    return sweep.run(SPEC)


def test_an_atlas_that_lacks_nothing_is_returned_itself(atlas):
    """A complete atlas is returned itself, not as a copy."""
    assert as_atlas(atlas) is atlas


def test_what_was_left_out_is_found_again(atlas):
    """Dropped variables come back bit for bit, with their attributes; `history` has a line about it."""
    for names in [
        ["boundary_roll_rate"],
        ["boundary_roll_rate_status"],
        ["critical_roll_rate", "predicted_roll_rate"],
        ["curve_point_count"],
        ["alpha", "gravity"],
    ]:
        part = atlas.drop_vars(names)
        found = as_atlas(part)
        assert set(found.variables) == set(atlas.variables)
        for name in atlas.variables:
            xr.testing.assert_identical(found[name].variable, atlas[name].variable)
        assert len(found.attrs["history"].splitlines()) == len(atlas.attrs["history"].splitlines()) + 1
        assert not set(names) & set(part.variables)


def test_a_file_without_its_boundary_has_one(atlas, tmp_path, command):
    """``ncks -v`` keeps only the cells: the commands find the boundary again from the verdicts."""
    whole, part = tmp_path / "whole.nc", tmp_path / "part.nc"
    sweep.save(atlas, whole)
    atlas[["ending", "stability", "tilt_min", "tilt_max"]].to_netcdf(part, engine="netcdf4")
    with netCDF4.Dataset(part) as file:
        assert not [name for name in file.variables if name.startswith(("boundary", "curve"))]
    tables = []
    for each in (whole, part):
        status, out, _ = command(f"boundary {each}")
        assert status == 0
        tables.append(out)
    assert tables[0] == tables[1]


def test_a_missing_value_of_its_own_is_packing(atlas, tmp_path, command):
    """A missing_value equal to the fill value changes nothing; any other would mask valid numbers and is refused."""
    path = tmp_path / "atlas.nc"
    sweep.save(atlas, path)
    with netCDF4.Dataset(path, "a") as file:
        file["tilt_min"].missing_value = file["tilt_min"]._FillValue
    assert command(f"info {path}")[0] == 0
    with netCDF4.Dataset(path, "a") as file:
        file["tilt_min"].missing_value = 0.0
    status, _, err = command(f"info {path}")
    assert status == 2
    assert_facts(err, str(path), "tilt_min", "missing_value", "_FillValue")
