import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sweep.engine.cells import scale, starts, steady_tilt
from sweep.schema import PARAMETERS

from sweep.engine.grid import Span
from sweep.request.spec import SweepSpec

#: Values of each parameter that any disk may have.
VALUES = {
    "tilt": [0.1, 0.2, 0.4],
    "tilt_rate": [-0.1, 0.3],
    "precession_rate": [-2.0, 1.0, 3.0],
    "roll_rate": [0.5, 1.5],
    "alpha": [0.25, 0.5, 1.0],
    "radius": [0.25, 2.0],
    "gravity": [1.6, 9.81],
}


@given(st.data())
def test_cells_are_in_the_order_of_c(data):
    """Any span of any grid, with any parameters as axes, is that piece of the meshed axes, last axis fastest."""
    axes = data.draw(
        st.permutations(list(VALUES)).flatmap(lambda names: st.sampled_from([names[:n] for n in range(8)]))
    )
    spec = SweepSpec(**{name: VALUES[name] for name in axes})
    start = data.draw(st.integers(0, spec.size - 1))
    stop = data.draw(st.integers(start, spec.size))
    meshed = dict(zip(axes, np.meshgrid(*(VALUES[name] for name in axes), indexing="ij"), strict=True))
    found = starts(spec, Span(start, stop))
    assert list(found) == list(PARAMETERS)
    for name, values in found.items():
        expected = (
            meshed[name].ravel()[start:stop] if name in axes else [PARAMETERS[name].default] * (stop - start)
        )
        assert values.dtype == np.float64
        np.testing.assert_array_equal(values, expected)


def test_a_circling_cell_rolls_at_its_steady_rate():
    """At 10 degrees and 0.5 rad/s the uniform disk of half a metre rolls at -4.6851 rad/s, as printed."""
    found = starts(SweepSpec(roll_rate="steady", tilt="10deg", precession_rate=0.5), Span(0, 1))
    assert found["roll_rate"] == pytest.approx(-4.6851, abs=5e-5)


def test_a_rate_that_does_not_exist_is_not_finite():
    """Without precession no roll rate keeps the tilt: that cell, and only that one, has none."""
    found = starts(SweepSpec(roll_rate="steady", tilt="10deg", precession_rate="-1:1:3"), Span(0, 3))
    assert np.isfinite(found["roll_rate"]).tolist() == [True, False, True]


def test_the_motion_that_is_disturbed():
    """A circling disk is disturbed at its own tilt, any other one upright."""
    released = SweepSpec(tilt=[0.1, 0.2])
    assert steady_tilt(released, starts(released, Span(0, 2))).tolist() == [0.0, 0.0]
    circling = released.replace(roll_rate="steady", precession_rate=1)
    assert steady_tilt(circling, starts(circling, Span(0, 2))).tolist() == [0.1, 0.2]


def test_the_scale_of_the_perturbation():
    """A release is worth its tilt; a kick e is worth e/W, with W^2 = 2g/((2+alpha)R) = 15.696 / s^2 by hand."""
    released = SweepSpec(tilt=-0.1)
    assert scale(released, starts(released, Span(0, 1))).tolist() == [0.1]
    for kicked in (
        SweepSpec(tilt_rate=1e-4),
        SweepSpec(tilt=0.1, tilt_rate=1e-4, roll_rate="steady", precession_rate=1),
    ):
        # relative tolerance: a handful of roundings
        assert scale(kicked, starts(kicked, Span(0, 1))) == pytest.approx(1e-4 / math.sqrt(15.696), rel=1e-14)
