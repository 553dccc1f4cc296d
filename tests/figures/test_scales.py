"""Numbers on logarithmic axes, and error bars of squared rates."""

import math

import matplotlib.pyplot as plt
import numpy as np

from sweep.figures.panels import _spread
from sweep.figures.scales import readable, set_log_ticks
from sweep.model.quantity import Input


def numbers(low, high):
    """Return the numbers on a logarithmic axis between two ends."""
    figure, axes = plt.subplots()
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    set_log_ticks(axes.xaxis, high / low)
    found = [each for each in axes.xaxis.get_majorticklocs() if low <= each <= high]
    plt.close(figure)
    return found


def test_numbers_of_a_logarithmic_axis():
    """Short axes have even steps, axes of two decades 1, 2, 5, and longer ones powers of ten."""
    short = numbers(1.0, 3.5)
    assert len(short) >= 4
    assert np.allclose(np.diff(short), short[1] - short[0])
    np.testing.assert_allclose(numbers(1.0, 5.0), [1, 2, 5])
    np.testing.assert_allclose(numbers(0.1, 10.0), [0.1, 0.2, 0.5, 1, 2, 5, 10])
    np.testing.assert_allclose(numbers(1e-2, 1e3), [1e-2, 1e-1, 1, 10, 100, 1000])


def test_short_lengths_alone_have_another_unit():
    """Lengths below 10 cm are drawn in mm and below 2 mm in micrometers; speeds keep their unit."""
    for units, largest, scale in (
        ("m", 0.5, 1.0), ("m", 0.05, 1e3), ("m", 1e-3, 1e6), ("m s-1", 0.05, 1.0), ("m s-2", 1e-3, 1.0),
        ("rad", 0.05, math.degrees(1.0)),
    ):  # fmt: skip
        quantity = readable(Input("place", "x", units, "where it is", tolerance=None, default=0.0), largest)
        assert quantity.plot_scale == scale, (units, largest)


def test_error_bars_of_squares():
    """Squaring swaps the ends of a negative rate's bracket; both bars stay positive and on the right side."""
    low, middle, high = np.array([[-2.5, 2.0], [-2.0, 3.0], [-1.5, 4.0]]) ** 2
    np.testing.assert_array_equal(_spread(low, middle, high), [[1.75, 5.0], [2.25, 7.0]])
