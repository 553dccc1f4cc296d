"""Sampled motions with losses: states, path, ledger, contact forces and what friction holds."""

import math

import lossy_referee as referee
import numpy as np
import pytest
from lossy_follower import energy_of, lost_in, sampled

from kernels.lossy_disk import endings

#: Slides, reverses, is held by contour friction, and slides again.
LIVELY = referee.starts(
    tilt=0.4, tilt_rate=0.3, precession_rate=0.3, roll_rate=0.4, radius=0.1, gravity=9.81, rolling_friction=5e-4,
    pivoting_friction=1e-4, contour_friction=1e-2, contour_damping=1e-4, air_viscosity=1e-4, mass=0.5,
)[:, 0]  # fmt: skip


def test_samples_are_those_of_the_referee():
    """States, heading and losses at any time agree to 1e-8, through holds and reversals."""
    times = np.linspace(0.0, 0.18, 7)
    ending, last, found = sampled(LIVELY, times, air="moffatt", relative_step=0.01)
    assert (ending, last) == (endings.HORIZON, 0.18)
    for i, time in enumerate(times[1:], 1):
        exact = referee.run(LIVELY[:, None], air="moffatt", duration=time)
        state = [found[name][i] for name in ("tilt", "tilt_rate", "precession_rate", "roll_rate")]
        np.testing.assert_allclose(state, exact.state[:, 0], rtol=1e-8, atol=1e-8)
        assert found["heading"][i] == pytest.approx(exact.heading_turned[0], abs=1e-8)
        for law in ("rolling", "pivoting", "contour", "damping", "air"):
            assert found[f"{law}_loss"][i] == pytest.approx(exact.measures[f"{law}_loss"][0], abs=1e-9)


def test_forces_are_newtons_law_of_the_path():
    """Second differences of the center's path, sampled densely, give the contact forces."""
    step = 1e-4
    times = np.arange(0.0, 0.18, step)
    _, _, found = sampled(LIVELY, times, air="moffatt", relative_step=0.01)
    R, g = 0.1, 9.81
    tilt, heading = found["tilt"], found["heading"]
    ahead, across = (
        np.stack([-np.sin(heading), np.cos(heading)]),
        np.stack([np.cos(heading), np.sin(heading)]),
    )
    centre = np.stack([found["contact_x"], found["contact_y"]]) + R * np.sin(tilt) * across
    height = R * np.cos(tilt)
    inner = slice(1, -1)
    moved = np.diff(centre, 2) / step**2 / g
    raised = 1.0 + np.diff(height, 2) / step**2 / g
    # forces jump if friction reverses within a difference
    calm = np.ones(len(times) - 2, bool)
    for name in ("held", "roll_rate", "tilt_rate", "precession_rate"):
        sense = found[name] if name == "held" else np.sign(found[name])
        calm &= (np.diff(sense)[:-1] == 0) & (np.diff(sense)[1:] == 0)
    assert calm.mean() > 0.9
    for ours, newton in (
        (found["normal_force"][inner], raised),
        (found["friction_across"][inner], (moved * across[:, inner]).sum(0)),
        (found["friction_along"][inner], (moved * ahead[:, inner]).sum(0)),
    ):
        np.testing.assert_allclose(ours[calm], newton[calm], atol=2e-5)


def test_the_contact_rests_while_friction_holds_it():
    """If the held bits include the roll rate, the contact point rests; the energy is always balanced."""
    times = np.linspace(0.0, 0.18, 1801)
    _, _, found = sampled(LIVELY, times, air="moffatt", relative_step=0.01)
    held = found["held"].astype(int) & 1 > 0
    assert 10 < held.sum() < len(held)
    assert (found["roll_rate"][held] == 0.0).all()
    both = held[1:] & held[:-1]
    assert (np.diff(found["contact_x"])[both] == 0.0).all()
    assert (np.diff(found["roll_angle"])[both] == 0.0).all()
    lost = lost_in(found)
    assert (np.diff(lost) >= 0.0).all()
    for i in range(0, 1801, 300):
        state = LIVELY.copy()
        state[:4] = [found[name][i] for name in ("tilt", "tilt_rate", "precession_rate", "roll_rate")]
        assert energy_of(state) + lost[i] == pytest.approx(energy_of(LIVELY), abs=1e-10)
    path = np.sum(np.hypot(np.diff(found["contact_x"]), np.diff(found["contact_y"])))
    assert path == pytest.approx(np.trapezoid(np.abs(found["roll_rate"]), times) * 0.1, rel=1e-4)


def test_samples_do_not_change_the_motion():
    """With any number of samples, the end is the same within the step error, and the last sample is the ending."""
    start = referee.starts(tilt=1.3, precession_rate=3.9, roll_rate=-3.75, contour_friction=5e-3)[:, 0]
    ends = []
    for n in (2, 50, 2000):
        ending, last, found = sampled(start, np.linspace(0.0, 100.0, n))
        assert ending == endings.FLAT
        assert found["tilt"][-1] == referee.FLAT_TILT
        ends.append(last)
    exact = referee.run(start[:, None], duration=100.0)
    np.testing.assert_allclose(ends, exact.end_time[0], rtol=1e-7)


def test_a_disk_that_stands_is_sampled_until_it_rests():
    """A held tilt keeps its bits until pivoting friction stops the turning, which ends the motion."""
    start = referee.starts(tilt=0.01, precession_rate=0.5, rolling_friction=0.02, pivoting_friction=1e-3)[
        :, 0
    ]
    ending, last, found = sampled(start, np.linspace(0.0, 1e3, 101))
    assert ending == endings.REST
    assert last < 1e3
    assert len(found["tilt"]) == math.ceil(last / 10.0) + 1
    assert (found["tilt"] == found["tilt"][0]).all()
    assert (found["held"][:-1] == 5.0).all()
    assert found["precession_rate"][-1] == 0.0
