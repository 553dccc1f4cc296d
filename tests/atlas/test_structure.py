"""Opening an atlas checks its structure: every missing, renamed or altered part is named."""

import netCDF4
import numpy as np
import pytest
import xarray as xr
from messages import assert_facts, missing, refused

import sweep
from sweep.atlas.structure import check_structure
from sweep.errors import LeftOutWarning, RequestError
from sweep.files.reading import open_atlas

SPEC = sweep.SweepSpec.preset("rolling").replace(
    roll_rate="2:4:7", tilt="1deg,2deg,4deg", contact="yes", boundary="refined:1e-3"
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the path of an atlas with all kinds of variables."""
    path = tmp_path_factory.mktemp("structure") / "whole.nc"
    sweep.run_to_file(SPEC, path)
    return path


@pytest.fixture
def edited(whole, tmp_path):
    """Return a function that edits a copy of the file and returns the message from opening it."""

    def change(edit):
        path = tmp_path / "edited.nc"
        path.write_bytes(whole.read_bytes())
        with netCDF4.Dataset(path, "a") as file:
            edit(file)
        with pytest.raises(RequestError) as refused:
            open_atlas(path)
        return str(refused.value).removeprefix(f"{path}: ")

    return change


def test_every_unit_and_flag_is_looked_at(whole):
    """Every variable that loses or changes its units or flags is named."""
    with open_atlas(whole) as atlas:
        for name, found in atlas.variables.items():
            if name in SPEC.model.parameters:
                # coordinates are checked by their numbers instead
                continue
            for attribute in {"units", "flag_values", "flag_meanings"}.intersection(found.attrs):
                kept = found.attrs.pop(attribute)
                for wrong in ({}, {attribute: "furlong"}, {attribute: 5.0}):
                    found.attrs.update(wrong)
                    with refused(f"{name}"):
                        check_structure(atlas, SPEC, "here")
                found.attrs[attribute] = kept
        check_structure(atlas, SPEC, "here")


def test_every_part_of_a_group_is_missed(whole):
    """A missing variable of an edge or of the curves is reported by name, because the others of its group exist."""
    with open_atlas(whole) as atlas:
        starts = ("boundary_", "predicted_", "critical_", "curve_")
        grouped = [str(name) for name in atlas.data_vars if str(name).startswith(starts)]
        assert len(grouped) >= 10
        for name in grouped:
            with pytest.raises(RequestError) as caught:
                check_structure(atlas.drop_vars(name), SPEC, "here")
            told = str(caught.value)
            assert not missing(told, [name]) or not missing(told, ["curve_point_count"]), told


@pytest.mark.parametrize("value", [np.nan, np.inf, 1.0, -1.0])
def test_coordinates_are_finite_and_increasing(edited, value):
    """Coordinates that are not finite or not increasing are refused before any lookup."""

    def edit(file):
        file["roll_rate"][1:3] = value

    assert_facts(edited(edit), "roll_rate", "finite")
    assert_facts(edited(lambda file: file["gravity"].assignValue(np.nan)), "gravity", "finite")


def test_a_coordinate_has_each_value_once(edited):
    """Files that were concatenated with a common row are refused."""

    def edit(file):
        file["roll_rate"][2] = file["roll_rate"][1]

    assert_facts(edited(edit), "roll_rate", "increasing")


def test_three_problems_are_named_and_the_others_counted(edited):
    """If five variables have wrong units, the message names three and adds "2 more"."""
    wrong = ("peak_tilt", "tilt_min", "tilt_max", "nutation_period", "amplification")

    def edit(file):
        for name in wrong:
            file[name].units = "kg"

    told = edited(edit)
    assert sum(not missing(told, [name]) for name in wrong) == 3
    assert_facts(told, "2 more")


def test_an_axis_that_runs_backwards(edited):
    """A reversed axis is refused with the call that sorts it."""

    def edit(file):
        file["roll_rate"][:] = file["roll_rate"][::-1]

    assert_facts(edited(edit), "roll_rate", "dataset.sortby('roll_rate')")


def test_dimensions_and_types(edited):
    """A variable with other dimensions or another type is named."""

    def retyped(file, kind, dims):
        file.renameVariable("peak_tilt", "old_peak")
        file.createVariable("peak_tilt", kind, dims).units = "rad"

    assert_facts(edited(lambda file: retyped(file, "f8", ("tilt",))), "peak_tilt", "dimensions")
    assert_facts(edited(lambda file: retyped(file, "f8", ("tilt", "tilt"))), "peak_tilt", "dimensions")
    assert_facts(edited(lambda file: retyped(file, "i4", ("roll_rate", "tilt"))), "peak_tilt", "f8", "int32")

    assert "packed" in edited(lambda file: file["tilt_max"].setncattr("scale_factor", 2.0))
    assert_facts(edited(lambda file: file.setncattr("title", 5.0)), "title", "text")


@pytest.mark.parametrize(
    ("kind", "dims", "why"),
    [
        ("f8", ("time",), ["dimensions", "time"]),
        ("f8", ("tilt", "time"), ["dimensions", "tilt, time"]),
        ("S1", ("tilt",), ["numbers"]),
        (str, ("tilt",), ["number", "text"]),
        (str, (), ["number", "text"]),
    ],
)
def test_what_no_atlas_has_is_left_out(whole, tmp_path, kind, dims, why):
    """A variable that another program added, with another type or other dimensions, is skipped with a warning."""
    path = tmp_path / "added.nc"
    # NETCDF4, because the classic model has no strings
    with netCDF4.Dataset(whole) as file, netCDF4.Dataset(path, "w") as copy:
        copy.setncatts({name: file.getncattr(name) for name in file.ncattrs()})
        for name, dimension in file.dimensions.items():
            copy.createDimension(name, len(dimension))
        for name, found in file.variables.items():
            attributes = {each: found.getncattr(each) for each in found.ncattrs()}
            fill = attributes.pop("_FillValue", None)
            made = copy.createVariable(name, found.dtype, found.dimensions, fill_value=fill)
            made.setncatts(attributes)
            made[...] = found[...]
        copy.createDimension("time", 3)
        copy.createVariable("time", "f8", ("time",))
        copy.createVariable("sst", kind, dims)
    with pytest.warns(LeftOutWarning) as told:
        found = open_atlas(path)
    (text,) = [str(each.message) for each in told]
    assert_facts(text, str(path), "sst", *why, "1 more")
    with found, open_atlas(whole) as atlas:
        xr.testing.assert_identical(found, atlas)


def test_the_points_of_curves_add_up(edited):
    """The point counts of the curves must add up to the number of points."""

    def edit(file):
        file["curve_point_count"][0] += 1

    assert_facts(edited(edit), "curve_point_count")


def test_counts_that_wrap_do_not_add_up(whole):
    """64-bit counts are refused if they add up only by overflow."""
    with open_atlas(whole) as atlas:
        points, largest = atlas.sizes["curve_point"], np.iinfo(np.int64).max
        counts = np.array([largest, largest, points + 2])
        curves = {
            "curve_point_count": atlas["curve_point_count"]
            .variable[:1]
            .isel(curve=[0, 0, 0])
            .copy(data=counts),
            "curve_closed": atlas["curve_closed"].variable[:1].isel(curve=[0, 0, 0]),
        }
        changed = atlas.drop_dims("curve").assign(curves)
        with refused("curve_point_count"):
            check_structure(changed, SPEC, "here")


def test_a_selection_is_read(tmp_path):
    """A part of an atlas with a shortened, reordered or dropped axis can be read."""
    atlas = sweep.run(SPEC.replace(alpha=[0.5, 1.0]))
    for number, part in enumerate(
        (
            atlas.isel(alpha=0),
            atlas.isel(tilt=slice(1)),
            atlas.isel(alpha=1, tilt=0),
            atlas.transpose(..., "roll_rate"),
        )
    ):
        sweep.save(part.drop_encoding(), tmp_path / f"{number}.nc")
        with open_atlas(tmp_path / f"{number}.nc") as found:
            assert {name: found.sizes[name] for name in found.ending.dims} == {**part.ending.sizes}
