"""An entry point that computes the dependent rates of cells (`kernels.disk.steady`)."""

from kernels.disk.arrays import ALPHA, GRAVITY, PRECESSION_RATE, RADIUS, ROLL_RATE, TILT
from kernels.disk.steady import (
    both_precession_rates,
    centred_roll_rate,
    steady_roll_rate,
    wobble_precession_rate,
)
from kernels.jit import kernel
from kernels.native.entry import entry

#: Kinds of rates: given, or a rate that keeps the tilt constant.
GIVEN, SLOW, FAST, STEADY, WOBBLE = range(5)

_both, _roll, _wobble, _centred = (
    kernel(each)
    for each in (both_precession_rates, steady_roll_rate, wobble_precession_rate, centred_roll_rate)
)


@entry(precession="int64", roll="int64", starts="float64[:, ::1], written")
def complete(precession, roll, starts):
    """Fill the rates of cells that keep their tilts constant; not finite if there is no such rate.

    Parameters
    ----------
    precession : int
        GIVEN, SLOW, FAST or WOBBLE.
    roll : int
        GIVEN, STEADY or WOBBLE.
    starts : float64[len(PARAMETERS), n], written
        Rows as in `kernels.disk.arrays`.
    """
    for i in range(starts.shape[1]):
        tilt, alpha, radius, gravity = (
            starts[TILT, i],
            starts[ALPHA, i],
            starts[RADIUS, i],
            starts[GRAVITY, i],
        )
        if precession == WOBBLE:
            starts[PRECESSION_RATE, i] = _wobble(tilt, alpha, radius, gravity)
        elif precession != GIVEN:
            slow, fast = _both(tilt, starts[ROLL_RATE, i], alpha, radius, gravity)
            starts[PRECESSION_RATE, i] = slow if precession == SLOW else fast
        if roll == WOBBLE:
            starts[ROLL_RATE, i] = _centred(tilt, starts[PRECESSION_RATE, i])
        elif roll != GIVEN:
            starts[ROLL_RATE, i] = _roll(tilt, starts[PRECESSION_RATE, i], alpha, radius, gravity)
