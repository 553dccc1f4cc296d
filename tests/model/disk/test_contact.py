import numpy as np
import pytest

import sweep
from sweep.checks.compare import compare
from sweep.checks.explain import explain
from sweep.model.disk.tables import CONTACT_VARIABLES


def circling_atlas():
    """Return cells of every kind: bounded over a wide range, and falling, some of which lift off."""
    spec = sweep.SweepSpec.preset("circling")
    return sweep.run(spec.replace(tilt="1deg:30deg:30", precession_rate="0.1:5:40", contact=True))


@pytest.mark.compiled
def test_an_atlas_holds_the_extremes_of_the_forces():
    """Least normal force and largest friction needed equal those of the motion sampled finely in time by SciPy."""
    atlas = circling_atlas()
    ending = atlas["ending"].values
    rng = np.random.default_rng(2)
    checked = 0
    for code in (1, 4):
        for row, column in rng.permutation(np.argwhere(ending == code))[:6]:
            cell = atlas.isel(tilt=row, precession_rate=column)
            length = cell["fall_time"] if code == 4 else 1.02 * cell["nutation_period"]
            motion = sweep.simulate(
                tilt=float(cell["tilt"]), tilt_rate=float(cell["tilt_rate"]),
                precession_rate=float(cell["precession_rate"]), roll_rate=float(cell["roll_rate"]),
                duration=float(length), interval=float(length) / 20_000, method="dop853",
            )  # fmt: skip
            normal = float(motion["normal_force"].min()) / 9.81
            assert float(cell["least_normal_force"]) == pytest.approx(normal, abs=1e-5)
            if normal > 1e-3:
                needed = float(motion["friction_needed"].max())
                assert float(cell["friction_needed"]) == pytest.approx(
                    needed, rel=1e-3 if normal < 0.1 else 1e-5
                )
            elif normal < -1e-3:
                assert np.isnan(cell["friction_needed"])
            checked += 1
    assert checked == 12


@pytest.mark.compiled
def test_the_exact_reduction_gives_the_same_forces():
    """The forces follow from start and extreme tilts, so method=exact has those of method=rk4 within the tolerance."""
    spec = sweep.SweepSpec.preset("rolling").replace(roll_rate="1:4:10", tilt="0.5deg:20deg:8", contact="yes")
    stepped, exact = sweep.run(spec), sweep.run(spec.replace(method="exact"))
    for name, quantity in CONTACT_VARIABLES.items():
        assert stepped[name].values == pytest.approx(exact[name].values, abs=quantity.tolerance.absolute)


@pytest.mark.compiled
def test_contact_forces_are_compared_and_explained():
    """A comparison judges the forces, and an explanation of a cell repeats them to the bit."""
    spec = sweep.SweepSpec.preset("rolling").replace(roll_rate="1:4:6", tilt="0.5deg,2deg", contact="yes")
    atlas = sweep.run(spec)
    changed = atlas.assign(friction_needed=atlas["friction_needed"] + 0.01)
    assert compare(atlas, atlas).same
    assert not compare(changed, atlas).same
    assert explain(atlas, {"roll_rate": "2.2", "tilt": "2deg"}).exactly
