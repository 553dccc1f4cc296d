import numpy as np
import pytest
import referee
import xarray as xr
from messages import refused

import sweep
from kernels.bodies.arrays import LIFTS_OFF, PRESSES, UNRESOLVED_FORCES
from kernels.disk.arrays import PARAMETERS
from kernels.disk.endings import BOUNDED, FELL
from sweep.checks.compare import compare
from sweep.checks.explain import explain
from sweep.model.disk.contact import slipping
from sweep.model.disk.tables import CONTACT_VARIABLES


def circling_atlas():
    """Return an atlas with cells of every kind: bounded, and falling with or without lift-off."""
    spec = sweep.SweepSpec.preset("circling")
    return sweep.run(spec.replace(tilt="1deg:30deg:30", precession_rate="0.1:5:40", contact=True))


@pytest.mark.compiled
def test_an_atlas_holds_the_extremes_of_the_forces():
    """Least normal force and largest friction needed match a dense integration in time to 1e-6 (1 + x)."""
    atlas = circling_atlas()
    ending = atlas["ending"].values
    rng = np.random.default_rng(2)
    checked = 0
    for code in (BOUNDED, FELL):
        for row, column in rng.permutation(np.argwhere(ending == code))[:6]:
            cell = atlas.isel(tilt=row, precession_rate=column)
            normal, needed = referee.contact([float(cell[name]) for name in PARAMETERS], 300.0)
            assert float(cell["least_normal_force"]) == pytest.approx(normal, rel=1e-6, abs=1e-6)
            if normal > 0.0:
                assert cell["contact_state"] == PRESSES
                assert float(cell["friction_needed"]) == pytest.approx(needed, rel=1e-6, abs=1e-6)
            else:
                assert cell["contact_state"] == LIFTS_OFF
                assert np.isnan(cell["friction_needed"])
            checked += 1
    assert checked == 12


@pytest.mark.compiled
def test_presets_leave_no_force_unknown():
    """Every cell of a preset that has a motion also has contact forces."""
    for method in ["rk4", "exact"]:
        for preset, coarse in (
            ("rolling", {"roll_rate": "2:4:60", "tilt": "0.001deg:5deg:25:log"}),
            ("spinning", {"precession_rate": "3:6:60", "tilt": "0.001deg:5deg:25:log"}),
            ("circling", {"precession_rate": "0.01:5:60", "tilt": "0.25deg:30deg:25"}),
        ):
            atlas = sweep.run(sweep.SweepSpec.preset(preset).replace(contact="yes", method=method, **coarse))
            moves = np.isfinite(atlas["tilt_min"])
            assert (np.isin(atlas["contact_state"], (PRESSES, LIFTS_OFF)) == moves).all(), method
            assert (np.isfinite(atlas["least_normal_force"]) == moves).all(), method


@pytest.mark.compiled
def test_the_exact_reduction_gives_the_same_forces():
    """The forces follow from the start, not from the computed tilts: both methods agree bit for bit."""
    spec = sweep.SweepSpec.preset("rolling").replace(roll_rate="1:4:10", tilt="0.5deg:20deg:8", contact="yes")
    stepped, exact = sweep.run(spec), sweep.run(spec.replace(method="exact"))
    bounded = stepped["ending"].values == BOUNDED
    assert bounded.sum() > 40
    for name in CONTACT_VARIABLES:
        assert (stepped[name].values[bounded] == exact[name].values[bounded]).all()


@pytest.mark.compiled
def test_unknown_forces_count_as_slipping():
    """A cell with unresolved forces counts as slipping for any coefficient; contact_state is required."""
    atlas = circling_atlas()
    known = slipping(atlas, 1e9)
    assert not known.all()
    vague = atlas.assign(contact_state=xr.full_like(atlas["contact_state"], UNRESOLVED_FORCES))
    assert slipping(vague, 1e9).all()
    with refused("contact_state"):
        slipping(atlas.drop_vars("contact_state"), 1e9)


@pytest.mark.compiled
def test_contact_forces_are_compared_and_explained():
    """`compare` checks the forces, and `explain` reproduces them bit for bit."""
    spec = sweep.SweepSpec.preset("rolling").replace(roll_rate="1:4:6", tilt="0.5deg,2deg", contact="yes")
    atlas = sweep.run(spec)
    changed = atlas.assign(friction_needed=atlas["friction_needed"] + 0.01)
    assert compare(atlas, atlas).same
    assert not compare(changed, atlas).same
    assert explain(atlas, {"roll_rate": "2.2", "tilt": "2deg"}).exactly


def test_a_cell_that_lifts_off_slips_whatever_the_friction():
    """It needs no particular friction; pressing cells slip if they need more friction than available."""
    cells = {
        "least_normal_force": ("cell", [-0.1, 0.0, 0.5, 0.5]),
        "friction_needed": ("cell", [np.nan, np.nan, 0.3, 0.1]),
        "contact_state": ("cell", [LIFTS_OFF, LIFTS_OFF, PRESSES, PRESSES]),
    }
    assert slipping(xr.Dataset(cells), 0.2).values.tolist() == [True, True, True, False]
