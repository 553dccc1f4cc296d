import random

import numpy as np
import pytest
from mpmath import mp, mpf

from kernels import double_double
from kernels.disk.arrays import PARAMETERS

pytestmark = pytest.mark.compiled

#: Relative error of one operation: eight times what is proved of the worst of them.
ERROR = 2.0**-99


def compiled(name, scalar=False):
    """Return an operation as a function of (high, low) pairs, or of doubles."""
    from numba import njit

    operation = getattr(double_double, name).compiled
    if scalar:
        return njit(lambda a: operation(a))
    return njit(lambda a, b: operation(a, b))


def pairs(rng, n):
    """Numbers of 31 digits and of both signs, from 1e-5 to 1e5."""
    found = []
    for _ in range(n):
        high = rng.choice((-1.0, 1.0)) * 10.0 ** rng.uniform(-5, 5)
        found.append(double_double.plus.py_func(high, high * rng.uniform(-1.0, 1.0) * 2.0**-54))
    return found


def exact(pair):
    """A pair as a number of many digits."""
    return mpf(pair[0]) + mpf(pair[1])


@pytest.mark.parametrize(
    ("name", "truth"),
    [
        ("add", lambda a, b: a + b),
        ("subtract", lambda a, b: a - b),
        ("multiply", lambda a, b: a * b),
        ("divide", lambda a, b: a / b),
    ],
)
def test_operations_keep_31_digits(name, truth):
    """Each operation on random numbers agrees with 60 digits to 1.6e-30, also where a sum loses half of its digits."""
    rng, operation = random.Random(), compiled(name)
    numbers = pairs(rng, 400)
    near = [(-a * (1.0 + rng.uniform(-1e-8, 1e-8)), b) for a, b in numbers[:100]]
    with mp.workdps(60):
        for a, b in [*zip(numbers[:200], numbers[200:], strict=True), *zip(numbers, near, strict=False)]:
            right = truth(exact(a), exact(b))
            found = operation(a, b)
            assert abs(exact(found) - right) <= ERROR * abs(right), (a, b)
            assert found[0] + found[1] == found[0]


def test_operations_with_doubles():
    """A product with a double, a quotient by one, a square root, a sum and a product of doubles."""
    rng = random.Random()
    scale, shrink, root = compiled("scale"), compiled("shrink"), compiled("square_root", scalar=True)
    plus, times = compiled("plus"), compiled("times")
    with mp.workdps(60):
        for a, b in zip(pairs(rng, 200), pairs(rng, 200), strict=True):
            (factor, _), size = b, (abs(a[0]), np.copysign(a[1], a[0] * a[1]))
            assert abs(exact(scale(a, factor)) / (exact(a) * factor) - 1) <= ERROR
            assert abs(exact(shrink(a, factor)) / (exact(a) / factor) - 1) <= ERROR
            assert abs(exact(root(size)) / mp.sqrt(exact(size)) - 1) <= ERROR
            assert exact(plus(a[0], factor)) == mpf(a[0]) + mpf(factor)
            assert abs(exact(times(a[0], factor)) - mpf(a[0]) * mpf(factor)) <= 2.0**-104 * abs(a[0] * factor)


def test_sine_and_cosine():
    """Sine and cosine of angles from 1e-8 to pi/2, of both signs, next to pi/4 and pi/2 too."""
    rng, both = random.Random(), compiled("sine_cosine", scalar=True)
    angles = [rng.choice((-1, 1)) * 10 ** rng.uniform(-8, 0.19) for _ in range(200)]
    with mp.workdps(60):
        for angle in [*angles, 0.25 * np.pi, np.nextafter(0.25 * np.pi, 1), 1.57079, 0.0]:
            sine, cosine = both(float(angle))
            assert abs(exact(sine) - mp.sin(angle)) <= ERROR * abs(mp.sin(angle))
            assert abs(exact(cosine) - mp.cos(angle)) <= ERROR * mp.cos(angle)


def test_height_of_a_saddle_keeps_its_digits():
    """V - h at a place beside the saddle is that of 50 digits, though it is 1e-13 of what it is the difference of."""
    import turning_reference as digits
    from numba import njit

    from kernels.disk.exact.saddle_height import height_at

    function, rng = height_at.compiled, np.random.default_rng()
    height = njit(lambda u, alpha, starts: function(u, alpha, starts, 0))
    with mp.workdps(50):
        for _ in range(5):
            start = [
                *rng.uniform(0.02, 1.4, 1),
                0.0,
                *rng.normal(0.0, 0.4, 2),
                rng.uniform(0.02, 1.0),
                0.3,
                9.81,
            ]
            place = rng.uniform(-0.3, 0.3)
            tilt = mp.asin(mpf(place))
            motion, _ = digits.reduce(start)
            rise = digits.potential(motion, tilt) - motion[3]
            if rise <= 0:
                start[0], place, rise = -start[0], place, mpf(1)
            # a rate that all but reaches the place
            unit = mpf(start[6]) / mpf(start[5])
            start[1] = float(mp.sqrt(2 * abs(rise) * unit / (1 + mpf(start[4]) / 2))) * (1.0 + 1e-13)
            motion, _ = digits.reduce(start)
            truth = digits.potential(motion, tilt) - motion[3]
            slope = digits.slope(motion, tilt) * mp.cos(tilt)
            found, pull = height(place, start[4], np.array(start).reshape(len(PARAMETERS), 1))
            assert abs(found / truth - 1) <= 1e-14
            assert abs(pull - slope) <= 1e-14 * (1 + abs(slope))
