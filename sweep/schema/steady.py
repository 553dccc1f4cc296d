"""The table of what is measured about steady motions, beside what linear theory says of them."""

from collections.abc import Mapping

from sweep.schema import Quantity, Tolerance, table

_RATE = Tolerance(1e-6, 1e-6, "measured over a short while, good to the square of the kick")

# fmt: off
STEADY: Mapping[str, Quantity] = table(
    Quantity("stability_coefficient", "k", "s-2", "coefficient of small oscillations about the steady motion",
             _RATE, "from linear theory, without integration: the motion is stable where it is positive"),
    Quantity("measured_coefficient", "k", "s-2", "coefficient of small oscillations as trajectories show it",
             _RATE, "from a short trajectory kicked up and down; no theory of the coefficient enters"),
    Quantity("growth_rate", r"\sqrt{-k}", "s-1", "rate at which a kick to the steady motion grows", _RATE,
             "root of minus measured_coefficient; missing where a kick does not grow"),
    Quantity("nutation_frequency", r"\sqrt{k}", "rad s-1", "angular frequency of nutation", _RATE,
             "2 pi over nutation_period; missing where the cell has no period"),
)
# fmt: on
