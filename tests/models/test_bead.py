"""A bead on a hoop turning about its vertical diameter, as a ten-line system, against closed forms.

These are the Jacobi integral angle'^2/2 - hoop_rate^2 sin(angle)^2/2 - (g/R) cos(angle) for the turning
points, the frequency sqrt(g/R - hoop_rate^2) of small oscillations and the critical rate sqrt(g/R).
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import sweep
from sweep.engine.compute import compute

pytestmark = pytest.mark.compiled

FILE = Path(__file__).with_name("bead.py")
CHECKOUT = FILE.parents[2]
CRITICAL = np.sqrt(9.81 / 0.5)


def turning_points(angle, rate, hoop_rate, radius, gravity):
    """Find the two angles around a start where the Jacobi integral leaves no kinetic energy, by bisection."""
    hoop, pull = hoop_rate**2, gravity / radius

    def kinetic(x):
        rise = 0.5 * hoop * (np.sin(x) ** 2 - np.sin(angle) ** 2) + pull * (np.cos(x) - np.cos(angle))
        return 0.5 * rate**2 + rise

    found = []
    for side in (-1.0, 1.0):
        steps = angle + side * np.linspace(1e-9, 4.0, 40001)
        beyond = int(np.argmax(kinetic(steps) < 0.0))
        found.append(brentq(kinetic, steps[beyond - 1], steps[beyond], xtol=1e-14))
    return found


def test_the_system_is_ten_lines():
    """The file has at most ten lines after its import, and the engine has no code for it."""
    text = FILE.read_text(encoding="utf-8")
    assert len(text[text.index("@system") :].splitlines()) <= 10
    for path in (*CHECKOUT.glob("sweep/**/*.py"), *CHECKOUT.glob("kernels/**/*.py")):
        other = path.read_text(encoding="utf-8").lower()
        assert not [name for name in ("bead", "hoop_rate") if name in other], path


def test_it_turns_where_the_jacobi_integral_says(rng):
    """Random starts followed for many oscillations match both turning points to 2e-10 rad."""
    n = 60
    starts = {
        "angle": rng.uniform(-1.2, 1.2, n),
        "rate": rng.uniform(-1.0, 1.0, n),
        "hoop_rate": rng.uniform(0.0, 8.0, n),
        "radius": 10.0 ** rng.uniform(-1.0, 0.5, n),
        "gravity": 10.0 ** rng.uniform(0.0, 1.2, n),
    }
    found = compute(sweep.SweepSpec(model=str(FILE), duration="60s"), starts)
    ran = np.flatnonzero(found["ending"] == 1)
    assert ran.size > 0.9 * n
    for i in ran:
        start = {name: float(values[i]) for name, values in starts.items()}
        ends = [found["lowest"][i], found["highest"][i]]
        np.testing.assert_allclose(ends, turning_points(**start), rtol=0.0, atol=2e-10, err_msg=str(start))
    assert np.nanmax(found["conserved_change"]) < 1e-10


def test_it_swings_with_the_frequency_of_small_oscillations():
    """From rest at a small angle it follows the cosine, up to the square of the angle."""
    for hoop_rate in (0.0, 2.0, 4.0):
        cell = sweep.run(str(FILE), angle=1e-5, hoop_rate=hoop_rate)
        expected = 1e-5 * np.cos(np.sqrt(CRITICAL**2 - hoop_rate**2) * 10.0)
        assert float(cell.angle_end) == pytest.approx(expected, abs=1e-13)


@pytest.mark.slow_lane
def test_the_boundary_is_a_lower_edge():
    """For each start it follows from the energy; it approaches sqrt(g/R) as criterion and start shrink."""
    errors = []
    for degrees in (8.0, 4.0, 2.0):
        atlas = sweep.run(
            str(FILE), hoop_rate="4:5:51", angle=[1e-4], criterion=f"highest > {degrees}deg", duration="1000s",
            boundary="refined:1e-9",
        )  # fmt: skip
        edge = atlas.eulerdisk.boundary("hoop_rate", "lower")
        far, near = np.radians(degrees), 1e-4
        energy = 2.0 * CRITICAL**2 * (np.cos(near) - np.cos(far))
        predicted = np.sqrt(energy / (np.sin(far) ** 2 - np.sin(near) ** 2))
        assert float(edge.critical[0]) == pytest.approx(CRITICAL, rel=1e-14)
        assert float(edge.measured[0]) == pytest.approx(predicted, abs=1e-7)
        errors.append(float(edge.measured[0]) - CRITICAL)
    # The edge is a power series in the square of the angle.
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.01)
