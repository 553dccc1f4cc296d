"""Elementary functions of IEEE operations alone, held against 40 digits (mpmath) and the Cephes library (SciPy)."""

import mpmath
import numpy as np
from scipy.special import ndtri

from sweep.request.elementary import exp, log, normal_quantile

RANDOM = np.random.default_rng(1)

#: Of 0.001, 0.3, 0.7, 0.9999.
BITS = {
    "normal": [
        "-0x1.8b8cbb7204470p+1",
        "-0x1.0c7e39582c5fap-1",
        "0x1.0c7e39582c5fap-1",
        "0x1.dc08bb712897ap+1",
    ],
    "log": [
        "-0x1.ba18a998fffa0p+2",
        "-0x1.34378fcbda721p+0",
        "-0x1.6d3c324e13f4fp-2",
        "-0x1.a3738d2cf1cc2p-14",
    ],
    "exp": ["0x1.0041919b7ee34p+0", "0x1.599058c8c1a96p+0", "0x1.01c2a61268987p+1", "0x1.5be7c08be145bp+1"],
}


def worst(found, given, function):
    """Return the largest relative error of some values."""
    with mpmath.workdps(40):
        exact = [function(mpmath.mpf(float(each))) for each in given]
        return max(abs(mpmath.mpf(float(a)) / b - 1) for a, b in zip(found, exact, strict=True) if b)


def test_logarithm():
    """Within 3 units in the last place from the smallest to the largest number, and beside 1."""
    given = np.concatenate([np.exp(RANDOM.uniform(-690, 690, 500)), RANDOM.uniform(0.5, 2.0, 500), [1.0]])
    assert worst(log(given), given, mpmath.log) < 3 * 2.0**-52
    assert log(1.0) == 0.0


def test_exponential():
    """Within one unit in the last place over 600 decades."""
    given = np.concatenate([RANDOM.uniform(-700, 700, 500), RANDOM.uniform(-1, 1, 200), [0.0]])
    assert worst(exp(given), given, mpmath.exp) < 2.0**-52
    assert exp(0.0) == 1.0


def test_normal_quantile():
    """In the middle, in both tails and at the last places that 52 bits reach."""
    tails = 10.0 ** RANDOM.uniform(-16, -0.31, 2000)
    given = np.concatenate([RANDOM.random(2000), tails, 1.0 - tails[tails > 1e-15], [2.0**-53, 1 - 2.0**-53]])
    np.testing.assert_allclose(normal_quantile(given), ndtri(given), rtol=2e-15)
    assert normal_quantile(np.array([0.5]))[0] == 0.0


def test_quantiles_are_symmetric():
    """The two tails are mirror images, bit for bit: no side is favoured by rounding."""
    given = (np.arange(1, 2000) + 0.5) * 2.0**-13
    assert np.array_equal(normal_quantile(given), -normal_quantile(1.0 - given))


def test_bits_are_fixed():
    """The bits that every processor has to find, since each operation is rounded as IEEE 754 says."""
    given = np.array([0.001, 0.3, 0.7, 0.9999])
    assert [each.hex() for each in normal_quantile(given).tolist()] == BITS["normal"]
    assert [each.hex() for each in log(given).tolist()] == BITS["log"]
    assert [each.hex() for each in exp(given).tolist()] == BITS["exp"]
