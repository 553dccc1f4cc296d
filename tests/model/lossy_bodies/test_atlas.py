"""Atlases of bodies with losses: what `verify` reports, and how a wobble ends."""

from unittest import mock

import numpy as np
import pytest
from lossy_body_referee import WITH_ALL_LAWS

import sweep
from sweep.checks.verify import findings, verify
from sweep.engine.grid import starts_at
from sweep.model.kernel import Kernel
from sweep.model.lossy_bodies.model import LossyBodies
from sweep.model.lossy_bodies.theory import wobble_time
from sweep.model.lossy_disk import theory as of_disk
from sweep.request.spec import SweepSpec

EDGE = {"body": "rim", "thickness": "12.8mm", "fillet": "2mm", "radius": "37.55mm", "mass": "438.7g"}
WOBBLE = {"precession_rate": "wobble", "roll_rate": "wobble", "criterion": "aloft:1s", "tilt": "89.5deg"}
LAWS = (
    {"contour_friction": "1um"},
    {"rolling_friction": "30um"},
    {"contour_damping": "1e-9"},
    {"air_law": "moffatt", "air_viscosity": "1e-7"},
)


@pytest.fixture(autouse=True)
def _one_kernel():
    """Use one kernel with all laws: every set of laws has its own, which takes seconds to compile."""
    kernel = Kernel("kernels.lossy_bodies.integrate", WITH_ALL_LAWS)
    with mock.patch.object(LossyBodies, "integrator", return_value=kernel):
        yield


def test_verify_agrees_and_finds_a_wrong_loss():
    """Cells are self-consistent, and a sample matches half the step and DOP853; a wrong loss is reported."""
    spec = SweepSpec(
        **EDGE, tilt="5deg:70deg:6", tilt_rate=0.3, scaled_precession_rate="0.3:1.2:3", roll_rate=0.2,
        rolling_friction="50um", pivoting_friction="20um", contour_friction="30um", contour_damping="1e-7",
        air_law="moffatt", air_viscosity="18uPa s", criterion="departure:20deg", duration="1s",
    )  # fmt: skip
    atlas = sweep.run(spec)
    endings = spec.model.endings
    assert {endings.of(code).name for code in np.unique(atlas["ending"])} >= {
        "flat",
        "horizon",
        "edge_change",
    }
    found = verify(atlas, seed=3)
    assert findings(found).passed
    assert "by DOP853" in found.attrs["audit_sample"]
    wrong = atlas.copy(deep=True)
    wrong["contour_loss"].values[...] *= 1.001
    assert not findings(verify(wrong, seed=3)).passed


def _start(spec):
    return {name: float(values[0]) for name, values in starts_at(spec, np.arange(1)).items()}


@pytest.mark.parametrize("law", LAWS)
def test_a_wobble_near_flat_takes_its_leading_order(law):
    """From half a degree on the wobble lasts as long as the leading-order theory says."""
    spec = SweepSpec(**EDGE, **WOBBLE, **law, duration="2000s")
    assert float(sweep.run(spec)["end_time"]) == pytest.approx(wobble_time(spec, _start(spec)), rel=4e-3)
    mirrored = spec.replace(tilt="-89.5deg")
    assert wobble_time(mirrored, _start(mirrored)) == pytest.approx(
        wobble_time(spec, _start(spec)), rel=1e-12
    )


@pytest.mark.parametrize("law", LAWS)
def test_without_thickness_that_is_the_thin_disks(law):
    """A torus without a tube wobbles as long as the thin disk's closed forms say; air needs a face."""
    size = {"radius": "37.55mm", "mass": "438.7g"}
    thin = SweepSpec(**size, **WOBBLE, **law)
    words = {"body": "torus", "tube": 0.0} if "air_law" not in law else {"body": "rounded", "thickness": 0.0}
    spec = SweepSpec(**words, **size, axial_moment=0.5, transverse_moment=0.25, **WOBBLE, **law)
    assert wobble_time(spec, _start(spec)) == pytest.approx(of_disk.wobble_time(thin, _start(thin)), rel=1e-5)


def test_no_critical_rate_where_nothing_is_in_balance():
    """An arc about its center has a critical rate; with an offset there is no upright balance and no line."""
    words = {
        "body": "arc",
        "fillet": 0.2,
        "axial_moment": 0.4,
        "transverse_moment": 0.3,
        "roll_rate": "1:4:4",
    }
    spec = SweepSpec(**words, rolling_friction="10um", tilt="1deg", duration="1s")
    for offset, known in ((0.0, True), (0.1, False)):
        found = spec.replace(offset=offset)
        assert bool(found.model.lines(found, "roll_rate", starts_at(found, np.arange(4)))) == known, offset
