"""Sources of cell values: ranges and lists along an axis, and random values with their generator."""

import hashlib
from unittest import mock

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from messages import refused
from scipy import stats

from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import PARAMETERS
from sweep.request import sources
from sweep.request.sources import Distribution, Range, Values, philox
from sweep.request.values import read_distribution
from sweep.request.words import read_word

FINITE = st.floats(allow_nan=False, allow_infinity=False)


def test_a_linear_range_is_even():
    """Five values from 0 to 1 are the quarters."""
    assert Range(0.0, 1.0, 5).array().tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]


def test_a_logarithmic_range_has_one_ratio():
    """Four values from 1 to 1000 are powers of ten."""
    np.testing.assert_allclose(
        Range(1.0, 1000.0, 4, "log").array(), [1, 10, 100, 1000], rtol=1e-14
    )  # Rounding.


@example(5e-324, 4.9e-272, 263, "log")
@example(0.0, 5e-323, 300, "linear")
@given(FINITE, FINITE, st.integers(2, 500), st.sampled_from(["linear", "log"]))
def test_every_accepted_range_is_a_coordinate(start, stop, count, spacing):
    """Every accepted range has exact ends, its count, and strictly increasing finite values."""
    # Most random pairs would be refused because of their order or signs.
    start, stop = sorted(map(abs, (start, stop)) if spacing == "log" else (start, stop))
    try:
        axis = Range(start, stop, count, spacing)
    except RequestError:
        assume(False)
    values = axis.array()
    assert values.dtype == np.float64
    assert (values[0], values[-1], len(values)) == (start, stop, count)
    assert (np.diff(values) > 0).all()
    assert np.isfinite(values).all()


NORMAL = st.floats(-1e300, 1e300, allow_subnormal=False)


@given(NORMAL, NORMAL, st.integers(2, 500), st.sampled_from(["linear", "log"]), st.data())
def test_chosen_values_of_a_long_range(start, stop, count, spacing, data):
    """Single values of a range too long to create are bit-identical to those of the whole range."""
    start, stop = sorted(map(abs, (start, stop)) if spacing == "log" else (start, stop))
    try:
        axis = Range(start, stop, count, spacing)
    except RequestError:
        assume(False)
    places = data.draw(st.lists(st.integers(0, count - 1)))
    with mock.patch.object(sources, "_MANY", 1):
        assert axis.at(places).tobytes() == axis.array()[np.array(places, int)].tobytes()


@given(st.lists(FINITE, min_size=1, unique=True).map(sorted))
def test_a_list_has_its_values(numbers):
    """Listed values are the coordinate, bit for bit; the ends are its first and last value."""
    axis = Values(tuple(numbers))
    assert axis.array().tolist() == numbers
    assert axis.ends().tolist() == [numbers[0], numbers[-1]]
    assert len(axis) == len(numbers)


def test_minus_zero_is_zero():
    """-0 and 0 are the same value, so equal axes have the same text."""
    assert str(Range(-1.0, -0.0, 3)) == "-1.0:0.0:3"
    assert str(Values((-0.0, 1.0))) == "0.0,1.0"


def test_axes_made_in_python_are_checked():
    """An axis created in Python obeys the same rules as one read from text."""
    for kind, *words in [
        (Range, "a", 2.0, 3), (Range, None, 2.0, 3), (Range, 1.0, 2.0, 3.0), (Range, 1.0, 2.0, True),
        (Values, 3), (Values, ("a",)),
    ]:  # fmt: skip
        with pytest.raises(RequestError):
            kind(*words)


WORDS = np.arange(1000)
MASK = 2**64 - 1


def philox_block(counter, key):
    """Return the four words of Philox 4x64-10 for a counter, from Salmon et al., SC11, section 3.3."""
    words, (k0, k1) = [counter >> (64 * i) & MASK for i in range(4)], key
    for _ in range(10):
        left, right = 0xD2E7470EE14C6C93 * words[0], 0xCA5A826395121157 * words[2]
        words = [right >> 64 ^ words[1] ^ k0, right & MASK, left >> 64 ^ words[3] ^ k1, left & MASK]
        k0, k1 = k0 + 0x9E3779B97F4A7C15 & MASK, k1 + 0xBB67AE8584CAA73B & MASK
    return words


def referee(stream, number):
    """Return a word of a stream by its number; NumPy counts the blocks of a generator from 1."""
    digest = hashlib.sha256(stream.encode()).digest()
    key = int.from_bytes(digest[:8], "little"), int.from_bytes(digest[8:16], "little")
    return philox_block(number // 4 + 1, key)[number % 4]


def test_the_referee_is_philox():
    """It gives the known answers of the authors' library Random123 (kat_vectors, philox4x64 10)."""
    assert philox_block(0, (0, 0)) == [
        0x16554D9ECA36314C,
        0xDB20FE9D672D0FDC,
        0xD7E772CEE186176B,
        0x7E68B68AEC7BA23B,
    ]


def test_words_are_those_of_philox():
    """Close, distant, unordered, repeated and beyond 2**32: any numbers give the referee's words."""
    numbers = np.array([0, 1, 2, 3, 4, 7, 129, 130, 131, 5000, 4, 2**31 - 1, 2**40 + 3, 6, 0])
    expected = [referee("7:tilt", int(each)) for each in numbers]
    assert philox("7:tilt", numbers).tolist() == expected
    assert philox("7:tilt", numbers[:0]).size == 0


def test_a_value_depends_on_its_number_alone():
    """Any subset of the starts, in any order, has the same bits as the whole."""
    for text in ["uniform:2:4", "loguniform:0.001:10", "normal:1:0.2"]:
        given = read_distribution(text, PARAMETERS["roll_rate"])
        whole = given.at(np.arange(20_000), "0:roll_rate")
        for part in (
            slice(0, 1),
            slice(7, 8200),
            slice(19_999, None),
            slice(None, None, -1),
            slice(3, None, 977),
        ):
            assert np.array_equal(given.at(np.arange(20_000)[part], "0:roll_rate"), whole[part])


def test_streams_are_independent():
    """Other seeds and parameters give other values, without a visible rank correlation."""
    given = Distribution("uniform", 0.0, 1.0)
    columns = [
        given.at(np.arange(20_000), stream) for stream in ("0:tilt", "1:tilt", "0:roll_rate", "10:tilt")
    ]
    correlations = stats.spearmanr(np.array(columns), axis=1).statistic[np.triu_indices(4, 1)]
    assert np.abs(correlations).max() < 4.0 / np.sqrt(20_000)


def test_values_have_the_distribution():
    """A Kolmogorov-Smirnov test and the tails of 100,000 values agree with SciPy's distribution."""
    for text, expected in [
        ("uniform:2:4", stats.uniform(2.0, 2.0)),
        ("uniform:-1deg/s:1deg/s", stats.uniform(-np.pi / 180, np.pi / 90)),
        ("loguniform:0.001:10", stats.loguniform(0.001, 10.0)),
        ("normal:1:0.2", stats.norm(1.0, 0.2)),
        ("normal:60rpm:1rpm", stats.norm(2 * np.pi, np.pi / 30)),
    ]:
        values = read_distribution(text, PARAMETERS["roll_rate"]).at(np.arange(100_000), "3:roll_rate")
        assert stats.kstest(values, expected.cdf).pvalue > 1e-3
        low, high = np.quantile(values, (1e-3, 1 - 1e-3))
        assert expected.cdf(low) == pytest.approx(1e-3, rel=0.4)
        assert expected.sf(high) == pytest.approx(1e-3, rel=0.4)


def test_values_stay_inside():
    """No value of a bounded distribution is outside its bounds, however close they are."""
    for kind in ("uniform", "loguniform"):
        beside = [(low, np.nextafter(low, np.inf)) for low in np.linspace(0.1, 50.0, 100).tolist()]
        for low, high in (*beside, (0.1, 0.1 * (1 + 1e-15)), (1e-300, 1e300)):
            values = Distribution(kind, low, high).at(WORDS, "s")
            assert low <= values.min() <= values.max() <= high


def test_a_distribution_reads_as_it_is_written():
    """The text in SI gives the same bits."""
    for text in ("uniform:0.1deg:5deg", "normal:1deg:0.2deg", "loguniform:1e-5deg:1deg"):
        given = read_distribution(text, PARAMETERS["tilt"])
        assert read_distribution(str(given), PARAMETERS["tilt"]) == given


def test_what_is_no_distribution():
    """The message names the input and the remedy."""
    for name, text, facts in [
        ("tilt", "uniform:1deg:90deg", ["90 deg", "|tilt| < 90 deg"]),
        ("tilt", "normal:95deg:1deg", ["95 deg", "|tilt| < 90 deg"]),
        ("tilt", "uniform:1:2", ["radians"]),
        ("alpha", "uniform:0:1", ["0", "0 < alpha <= 1"]),
        ("alpha", "normal:1.2:0.1", ["1.2", "0 < alpha <= 1"]),
        ("tilt", "uniform:2deg:1deg", ["low < high"]),
        ("tilt", "uniform:1deg:1deg", ["one number"]),
        ("tilt", "normal:1deg:0", ["deviation", "0"]),
        ("tilt", "normal:1deg:-1deg", ["deviation", "0"]),
        ("tilt", "loguniform:0:1deg", ["0"]),
        ("tilt", "uniform:1deg", ["uniform:LOW:HIGH", "normal:MEAN:DEVIATION"]),
        ("tilt", "uniform:1deg:2deg:3", ["uniform:LOW:HIGH", "normal:MEAN:DEVIATION"]),
        ("tilt", "gauss:1deg:2deg", ["uniform:LOW:HIGH", "normal:MEAN:DEVIATION"]),
        ("tilt", "normal:1deg:0.2", ["unit"]),
        ("tilt", "normal:1deg:0.2m", ["m", "deg", "arcmin"]),
        ("tilt", "uniform:nan:1deg", ["finite", "nan"]),
        ("roll_rate", "uniform:0:1e301", ["1e300"]),
    ]:
        with refused(*facts) as caught:
            read_word(name, text, DISK)
        assert str(caught.value).startswith(f"{name}={text}: ")
