"""A selection from an atlas has its own spec and equals a run of that spec bit for bit."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from messages import assert_facts, refused

import sweep
from sweep.checks.compare import compare
from sweep.checks.verify import findings_of
from sweep.files.netcdf import save
from sweep.files.reading import open_atlas, opened
from sweep.request.spec import SweepSpec

SPECS = {
    "three axes": SweepSpec(alpha="0.5,0.7,1", roll_rate="1:4:16", tilt="0.5deg:4deg:5:log"),
    "circling": SweepSpec.preset("circling").replace(tilt="5deg:25deg:4", precession_rate="0.5:5:21"),
    "refined": SweepSpec(alpha="0.5,1", roll_rate="1:4:8", tilt="1deg:4deg:4", boundary="refined:1e-3"),
    "two controls": SweepSpec(roll_rate="-1:3:9", precession_rate="0:4:7", tilt="2deg", contact="yes"),
    "exact": SweepSpec(roll_rate="2:3:9", tilt="1deg:4deg:4", method="exact"),
}


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Give all atlases of one spec the same date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")


@pytest.fixture(scope="module")
def atlases():
    """Return one atlas of each spec."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", "0")
        return {name: sweep.run(spec) for name, spec in SPECS.items()}


def _places(count):
    """Draw one index, a slice with a stride, or several increasing indices."""
    one = st.integers(0, count - 1)
    part = st.tuples(one, one, st.integers(1, 3)).map(
        lambda each: slice(min(each[:2]), max(each[:2]) + 1, each[2])
    )
    return one | part | st.sets(one, min_size=1).map(sorted)


@st.composite
def _selections(draw):
    """Draw the name of an atlas and indices along some of its axes."""
    name = draw(st.sampled_from([*SPECS]))
    axes = {axis: _places(len(getattr(SPECS[name], axis))) for axis in SPECS[name].axes}
    return name, {axis: draw(places) for axis, places in axes.items() if draw(st.booleans())}


@pytest.mark.slow_lane
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(_selections())
def test_it_is_as_if_run(atlases, selection):
    """Cells, boundary, coordinates, attributes and encodings equal those of a run of the selection's own spec."""
    name, places = selection
    part = atlases[name].isel(places)
    found = part.eulerdisk.atlas
    fresh = sweep.run(part.eulerdisk.spec).assign_attrs(history=found.history)
    xr.testing.assert_identical(found.drop_attrs(deep=False), fresh.drop_attrs(deep=False))
    assert found.attrs == fresh.attrs
    for each, variable in fresh.variables.items():
        assert found[each].encoding == variable.encoding, each
    expected = {axis: atlases[name][axis].values[chosen] for axis, chosen in places.items()}
    for axis, values in expected.items():
        np.testing.assert_array_equal(found[axis].values, values)


@pytest.mark.slow_lane
@pytest.mark.parametrize("way", ["sweep.save", "to_netcdf"])
@pytest.mark.parametrize(
    ("name", "places"),
    [
        ("three axes", {"alpha": 1}),
        ("three axes", {"alpha": [0, 2], "roll_rate": slice(3, 12)}),
        ("circling", {"precession_rate": slice(4, 19, 2)}),
        ("refined", {"alpha": 0, "roll_rate": slice(1, 7)}),
        ("two controls", {"precession_rate": 3}),
        ("exact", {"tilt": [1, 2]}),
    ],
)
def test_a_saved_selection_is_an_atlas_for_every_check(atlases, tmp_path, way, name, places):
    """Saved either way, a selection passes verification and is identical to a run of its own spec."""
    part, path = atlases[name].isel(places), tmp_path / "part.nc"
    if way == "sweep.save":
        save(part, path)
        assert open_atlas(path).attrs["sweep_spec"] == part.eulerdisk.spec.canonical()
    else:
        part.to_netcdf(path, format="NETCDF4_CLASSIC", engine="netcdf4")
    fresh = sweep.run(part.eulerdisk.spec)
    with opened(path) as found, opened(path, indexed=False) as read:
        assert compare(found, fresh).identical
        assert findings_of(found).passed
        assert [*read["ending"].dims] == [*fresh["ending"].dims]
        assert read.attrs["sweep_spec"] == fresh.attrs["sweep_spec"]


def test_in_memory_it_is_verified_compared_and_judged_anew(atlases):
    """`compare`, `verify` and `reclassify` accept a selection in memory."""
    part = atlases["three axes"].isel(alpha=2, tilt=slice(1, 4))
    fresh = sweep.run(part.eulerdisk.spec)
    assert compare(part, fresh).identical
    assert (sweep.verify(part)["audit"] == sweep.verify(fresh)["audit"]).all()
    again = sweep.reclassify(part, "departure:2deg")
    xr.testing.assert_equal(again, sweep.reclassify(fresh, "departure:2deg"))


def test_the_boundary_is_that_of_the_cells_that_are_left(atlases):
    """A row cut off below its boundary has no boundary, although the whole atlas has one."""
    whole = atlases["three axes"]
    assert np.isfinite(whole.isel(alpha=2, tilt=slice(4)).eulerdisk.boundary()["measured"]).all()
    assert not np.isfinite(
        whole.isel(alpha=2, tilt=slice(4), roll_rate=slice(4)).eulerdisk.boundary()["measured"]
    ).any()


def test_the_history_says_what_was_taken(atlases):
    """The file's history states that it is a part, and which part."""
    part = atlases["three axes"].isel(alpha=0).eulerdisk.atlas
    assert part.attrs["history"].endswith("1970-01-01T00:00:00Z selected alpha=0.5")


def test_a_title_of_the_users_is_kept():
    """The user's title is kept; an automatic title follows the selection."""
    atlas = sweep.run(SweepSpec(title="Mine", roll_rate="1:3:4", precession_rate="0,1"))
    assert atlas.isel(precession_rate=0).eulerdisk.atlas.title == "Mine"
    plain = sweep.run(SweepSpec(roll_rate="1:3:4", precession_rate="0,1"))
    assert_facts(plain.title, "Rolling", "precessing")
    part = plain.isel(precession_rate=0).eulerdisk.atlas.title
    assert_facts(part, "Rolling")
    assert "precessing" not in part


def test_variables_of_the_users_are_kept(atlases):
    """Variables that users added to the cells are kept."""
    atlas = atlases["three axes"].assign(mine=atlases["three axes"]["peak_tilt"] * 2.0)
    part = atlas.isel(alpha=0).eulerdisk.atlas
    np.testing.assert_array_equal(part["mine"], 2.0 * part["peak_tilt"])


REFUSED = {
    "coordinate": (lambda atlas: atlas.isel(alpha=0, drop=True), ["lost", "alpha"]),
    "backwards": (lambda atlas: atlas.isel(alpha=[2, 0]), ["increasing"]),
    "twice": (lambda atlas: atlas.isel(alpha=[0, 0]), ["increasing"]),
    "fractions": (lambda atlas: atlas.interp(roll_rate=[2.51, 2.6]), ["atlas.eulerdisk.interp"]),
    "one fraction": (lambda atlas: atlas.interp(roll_rate=1.01), ["atlas.eulerdisk.interp"]),
    "nothing": (lambda atlas: atlas.isel(alpha=slice(0, 0)), ["no cells"]),
    "turned": (
        lambda atlas: atlas.isel(roll_rate=slice(None, None, -1)),
        ["roll_rate", "other values"],
    ),
    "turned and cut": (
        lambda atlas: atlas.isel(roll_rate=slice(None, None, -1), alpha=1),
        ["roll_rate", "order"],
    ),
    "shuffled and cut": (lambda atlas: atlas.isel(tilt=[1, 0, 2, 3, 4], alpha=0), ["tilt", "order"]),
    "renamed values": (
        lambda atlas: atlas.assign_coords(tilt=atlas.tilt * 2.0),
        ["tilt", "other values"],
    ),
    "renamed and cut": (
        lambda atlas: atlas.assign_coords(tilt=atlas.tilt * 2.0).isel(alpha=0),
        ["tilt"],
    ),
    "another disk": (lambda atlas: atlas.assign_coords(radius=0.1), ["radius", "other values"]),
    "between": (
        lambda atlas: atlas.interp(roll_rate=np.linspace(1.1, 3.9, 16), method="nearest"),
        ["roll_rate"],
    ),
}


@pytest.mark.parametrize(("make", "facts"), REFUSED.values(), ids=REFUSED)
def test_what_is_no_selection_is_refused(atlases, tmp_path, make, facts):
    """Invalid selections are refused by the accessor and before anything is saved."""
    part = make(atlases["three axes"])
    for ask in (
        lambda: part.eulerdisk.spec,
        lambda: part.eulerdisk.plot(),
        lambda: save(part, tmp_path / "part.nc"),
    ):
        with refused(*facts):
            ask()
    assert not [*tmp_path.iterdir()]


def test_the_accessor_interpolates_measures_and_takes_flags_from_the_nearest_cell(atlases):
    """Interpolation is exact for a linear measure; flags come from the nearest cell."""
    atlas = atlases["three axes"].copy(deep=True)
    atlas["peak_tilt"] = (2.0 * atlas["roll_rate"] - 3.0 * atlas["tilt"] + atlas["alpha"]).transpose(
        "alpha", "roll_rate", "tilt"
    )
    found = atlas.eulerdisk.interp(roll_rate=[1.53, 2.47], tilt="2deg", alpha=0.66)
    expected = 2.0 * np.array([1.53, 2.47]) - 3.0 * np.radians(2.0) + 0.66
    np.testing.assert_allclose(found["peak_tilt"], expected, rtol=1e-13)
    near = atlas.sel(roll_rate=[1.53, 2.47], tilt=np.radians(2.0), alpha=0.66, method="nearest")
    for name in ("ending", "stability", "steps"):
        assert found[name].dtype == atlas[name].dtype
        np.testing.assert_array_equal(found[name], near[name])
    assert "sweep_spec" not in found.attrs
    assert_facts(repr(found.eulerdisk), "not a stability atlas")


def test_interp_takes_the_words_of_a_cell(atlases):
    """`interp` accepts a scaled rate or a speed and converts it for the atlas's disk (sqrt(9.81/0.5) and 1/0.5)."""
    atlas = atlases["three axes"]
    for word, value, rate in (
        ("speed", "100cm/s", 2.0),
        ("speed", [0.9, 1.0], [1.8, 2.0]),
        ("scaled_roll_rate", 0.5, 0.5 * np.sqrt(9.81 / 0.5)),
    ):
        found = atlas.eulerdisk.interp(**{word: value})
        np.testing.assert_allclose(found["roll_rate"], rate, rtol=1e-14)
        expected = atlas.eulerdisk.interp(roll_rate=rate)["peak_tilt"]
        np.testing.assert_allclose(found["peak_tilt"], expected, rtol=1e-12)


def test_a_data_array_gives_points(atlases):
    """DataArrays give points along their own dimension, not a grid, as in xarray."""
    atlas = atlases["three axes"].isel(alpha=0).eulerdisk.atlas
    rates, tilts = [1.53, 2.47, 2.0], np.radians([1.2, 1.9, 1.5])
    points = {"roll_rate": xr.DataArray(rates, dims="point"), "tilt": xr.DataArray(tilts, dims="point")}
    found = atlas.eulerdisk.interp(**points)
    assert found.sizes == {"point": 3}
    for i, (rate, tilt) in enumerate(zip(rates, tilts, strict=True)):
        single = atlas.eulerdisk.interp(roll_rate=rate, tilt=tilt)
        for name in ("peak_tilt", "stability", "steps"):
            np.testing.assert_allclose(found[name][i], single[name], rtol=1e-12)
    for wrong, facts in (
        ({"roll_rate": xr.DataArray([2.0, 99.0], dims="point")}, ["roll_rate", "1 rad s-1", "4 rad s-1"]),
        ({"speed": xr.DataArray([1.0], dims="point")}, ["speed", "roll_rate"]),
    ):
        with refused(*facts):
            atlas.eulerdisk.interp(**wrong)


def test_places_that_are_none_are_refused(atlases):
    """Values outside an axis and unknown axes are refused."""
    for raw, facts in [
        ({"roll_rate": 0.9}, ["roll_rate", "1 rad s-1", "4 rad s-1"]),
        ({"radius": 0.5}, ["radius"]),
        ({"roll_rate": "2m"}, ["roll_rate=2m", "rad/s"]),
        ({"rol_rate": 2}, ["rol_rate", "roll_rate?"]),
        ({"tilt": np.nan}, ["tilt", "finite"]),
        ({"tilt": 1.5}, ["radians", "tilt=1.5deg"]),
        ({"speed": 1, "roll_rate": 2}, ["speed", "roll_rate"]),
        ({"sped": 1}, ["sped", "speed?"]),
    ]:
        with refused(*facts):
            atlases["three axes"].eulerdisk.interp(**raw)


def test_a_list_with_other_starts_is_no_selection():
    """A reversed list of starts, or one with other parameters than its spec draws, is refused."""
    atlas = sweep.run("rolling", roll_rate="uniform:2:4", tilt="normal:1deg:0.2deg", samples=6)
    assert atlas.isel(start=[1, 3]).eulerdisk.spec.size == 2
    for part in (
        atlas.isel(start=slice(None, None, -1)),
        atlas.assign_coords(tilt=atlas.tilt * 2.0),
        atlas.assign_coords(tilt=atlas.tilt * 2.0).isel(start=[1, 3]),
    ):
        with refused("other values", "order"):
            _ = part.eulerdisk.atlas
