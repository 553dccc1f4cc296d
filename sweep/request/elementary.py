"""Logarithm, exponential and normal quantile of IEEE additions, products, quotients and roots alone.

NumPy and SciPy call the C library for these, whose last bits depend on the library and on the processor. The starts of
a random sample must not: NumPy rounds each single operation here as IEEE 754 says, on every processor.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from sweep.model.quantity import Array

#: ln 2 as a sum: the first part has 32 trailing zero bits, so that its product with an exponent is exact.
_LN2_HIGH, _LN2_LOW = float.fromhex("0x1.62e42fee00000p-1"), float.fromhex("0x1.a39ef35793c76p-33")

#: Coefficients of artanh(s) / s in s^2, for s^2 < 0.0295: the next term is 2e-20.
_ARTANH = [1.0 / (2 * k + 1) for k in range(12)]

#: Coefficients of exp(r) for |r| < 0.35: the next term is 5e-19.
_EXP = [1.0]
for _k in range(1, 15):
    _EXP.append(_EXP[-1] / _k)

# Wichura, algorithm AS 241 (PPND16), Appl. Statist. 37 (1988) 477: numerator and denominator near the middle, in the
# tails, and far out
_MIDDLE = (
    (3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3, 1.3731693765509461125e4,
     4.5921953931549871457e4, 6.7265770927008700853e4, 3.3430575583588128105e4, 2.5090809287301226727e3),
    (1.0, 4.2313330701600911252e1, 6.8718700749205790830e2, 5.3941960214247511077e3,
     2.1213794301586595867e4, 3.9307895800092710610e4, 2.8729085735721942674e4, 5.2264952788528545610e3),
)  # fmt: skip
_TAIL = (
    (1.42343711074968357734e0, 4.63033784615654529590e0, 5.76949722146069140550e0, 3.64784832476320460504e0,
     1.27045825245236838258e0, 2.41780725177450611770e-1, 2.27238449892691845833e-2, 7.74545014278341407640e-4),
    (1.0, 2.05319162663775882187e0, 1.67638483018380384940e0, 6.89767334985100004550e-1,
     1.48103976427480074590e-1, 1.51986665636164571966e-2, 5.47593808499534494600e-4, 1.05075007164441684324e-9),
)  # fmt: skip
_FAR = (
    (6.65790464350110377720e0, 5.46378491116411436990e0, 1.78482653991729133580e0, 2.96560571828504891230e-1,
     2.65321895265761230930e-2, 1.24266094738807843860e-3, 2.71155556874348757815e-5, 2.01033439929228813265e-7),
    (1.0, 5.99832206555887937690e-1, 1.36929880922735805310e-1, 1.48753612908506148525e-2,
     7.86869131145613259100e-4, 1.84631831751005468180e-5, 1.42151175831644588870e-7, 2.04426310338993978564e-15),
)  # fmt: skip


def log(values: npt.ArrayLike) -> Array:
    """Return the natural logarithm of positive normal numbers, same shape, to 3 units in the last place."""
    fraction, exponent = np.frexp(np.asarray(values, np.float64))
    # from [1/2, 1) to [sqrt(1/2), sqrt(2))
    small = fraction < 0.7071067811865476
    fraction = np.where(small, 2.0 * fraction, fraction)
    exponent = exponent - small
    ratio = (fraction - 1.0) / (fraction + 1.0)
    rest = 2.0 * ratio * _polynomial(_ARTANH, ratio * ratio)
    return np.asarray(exponent * _LN2_HIGH + (rest + exponent * _LN2_LOW))


def exp(values: npt.ArrayLike) -> Array:
    """Return the exponential of numbers from -700 to 700, same shape, to 2 units in the last place."""
    given = np.asarray(values, np.float64)
    exponent = np.rint(given / (_LN2_HIGH + _LN2_LOW))
    rest = (given - exponent * _LN2_HIGH) - exponent * _LN2_LOW
    return np.asarray(np.ldexp(_polynomial(_EXP, rest), exponent.astype(np.int32)))


def normal_quantile(share: npt.ArrayLike) -> Array:
    """Return the value below which a standard normal variable lies with a probability.

    Parameters
    ----------
    share : array_like
        Probabilities, 0 < share < 1.

    Returns
    -------
    array, same shape
        To a relative error of 1e-15.

    Notes
    -----
    Wichura, algorithm AS 241 (PPND16), Appl. Statist. 37 (1988) 477.
    """
    given = np.asarray(share, np.float64)
    distance = given - 0.5
    middle = np.abs(distance) <= 0.425
    found = distance * _ratio(_MIDDLE, np.where(middle, 0.180625 - distance * distance, 0.0))
    outside = ~middle
    if outside.any():
        found[outside] = _tails(given[outside])
    return found


def _tails(share: Array) -> Array:
    nearer = np.where(share < 0.5, share, 1.0 - share)
    depth = np.sqrt(-log(nearer))
    size = np.where(depth <= 5.0, _ratio(_TAIL, depth - 1.6), _ratio(_FAR, depth - 5.0))
    return np.where(share < 0.5, -size, size)


def _ratio(coefficients: tuple[Sequence[float], Sequence[float]], x: Array) -> Array:
    above, below = coefficients
    return _polynomial(above, x) / _polynomial(below, x)


def _polynomial(coefficients: Sequence[float], x: Array) -> Array:
    """Return a polynomial by Horner's rule, lowest coefficient first."""
    value = np.full_like(x, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        value *= x
        value += coefficient
    return value
