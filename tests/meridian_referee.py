"""The rigid body of `body_referee` for any smooth meridian, by its support function of the sine of the tilt."""

from dataclasses import dataclass, field

import body_referee
from body_referee import UP
from numpy.polynomial import Polynomial


@dataclass(frozen=True)
class Body(body_referee.Body):
    """The sum of the base class's body and one with the support function `more`.

    Support functions add up for sums of sets, and their gradient is the lowest point.
    """

    more: Polynomial = field(default_factory=lambda: Polynomial([0.0]))

    def contact(self, n, n_rate):
        """Return the contact point from the center of mass, and its rate if the axis moves with `n_rate`."""
        r, r_rate = super().contact(n, n_rate)
        sine, sine_rate, slope = n[2], n_rate[2], self.more.deriv()
        across, across_rate = n - sine * UP, n_rate - sine_rate * UP
        r = r - self.more(sine) * UP - slope(sine) * across
        bend = slope.deriv()(sine) * sine_rate
        return r, r_rate - slope(sine) * (sine_rate * UP + across_rate) - bend * across
