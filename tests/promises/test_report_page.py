"""docs/report.md says which command or test shows each statement: they exist, and its numbers are those found."""

import re
from pathlib import Path

import numpy as np
import pytest

import sweep

CHECKOUT = Path(__file__).resolve().parents[2]
PAGE = (CHECKOUT / "docs" / "report.md").read_text(encoding="utf-8")


def test_every_test_that_it_names_exists():
    """A statement that refers to a test refers to one that is there."""
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE)
    assert len(named) >= 10
    for path, name in named:
        assert f"def {name}(" in (CHECKOUT / path).read_text(encoding="utf-8"), name


def test_every_link_and_script_exists():
    """Pictures lie beside the page, scripts in the checkout."""
    assert all((CHECKOUT / "docs" / target).is_file() for target in re.findall(r"\]\(([^)]+)\)", PAGE))
    assert all((CHECKOUT / script).is_file() for script in re.findall(r"scripts/\w+\.py", PAGE))


@pytest.mark.compiled
def test_its_numbers():
    """Extreme tilts, the swing of H.e3 and the friction coefficients are the ones that the page states."""
    rolling, steady = (sweep.simulate(tilt_rate=0.01, roll_rate=rate) for rate in (2.0, 3.0))
    spinning, fast = (sweep.simulate(tilt_rate=0.1, precession_rate=rate) for rate in (3.5, 4.5))
    assert np.degrees(np.abs(steady["tilt"]).max()) < 0.24
    assert np.degrees(np.abs(fast["tilt"]).max()) < 2.7
    assert np.degrees(np.abs(spinning["tilt"]).max()) == pytest.approx(28.66, abs=0.005)
    assert np.ptp(rolling["vertical_momentum"].values) == pytest.approx(1.03, abs=0.005)
    assert float(rolling["friction_needed"].max()) == pytest.approx(0.45, abs=0.005)
    assert float(spinning["friction_needed"].max()) == pytest.approx(0.25, abs=0.005)
    assert set(np.unique(sweep.simulate(tilt=0.1, tilt_rate=0.1)["contact"])) == {0, 1, 2}
