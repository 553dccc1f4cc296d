"""Numbers written by the page, compared with Python's exact decimals and formats."""

import itertools
import math
from decimal import Decimal

from .test_arithmetic import random_doubles

GENERAL = """async asked => {
    const { general } = await import("eulerdisk/compute/spelling");
    return asked.map(([value, digits]) => general(value, digits));
}"""

#: Ticks of axes [center, half, scale, factor, count].
TICKS = """async asked => {
    const { ticksOf } = await import("eulerdisk/ticks");
    return asked.map(([centre, half, scale, factor, count]) => ticksOf({ centre, half, scale }, factor, count));
}"""

READABLE = """async asked => {
    const { readable } = await import("eulerdisk/ticks");
    return asked.map(([value, digits]) => readable(value, digits));
}"""

SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻−", "0123456789--")


def test_numbers_are_spelled_as_by_the_program(node):
    """A number of any size and digits has the text of Python's format "g"."""
    # Python rounds halves to even, JavaScript away from zero
    values = [
        *random_doubles(400),
        0.0,
        -0.0,
        1e5,
        123456.0,
        1234567.0,
        0.0001,
        0.00001,
        9.9999996,
        5e-324,
        1.7e308,
    ]
    asked = [[value, digits] for value in values for digits in (1, 3, 6, 10)]
    found = node.evaluate(GENERAL, asked)
    assert len(found) == len(asked)
    for (value, digits), text in zip(asked, found, strict=True):
        expected = f"{value:.{digits}g}"
        off = [abs(Decimal(value) - Decimal(each)) for each in (text, expected)]
        is_half = Decimal(text) != Decimal(expected) and off[0] == off[1]
        assert text == expected or is_half, value


def test_angles_of_many_turns_are_told_in_turns(node):
    """From ten turns on an angle is given in turns, below in degrees, as in messages of the program."""
    script = """async values => {
        const { spelled } = await import("eulerdisk/compute/spelling");
        const told = { unit: "deg", factor: 180 / Math.PI };
        return values.map((value) => spelled(told, value, 6));
    }"""
    found = node.evaluate(script, [math.radians(30.0), 19.9 * math.pi, 20.0 * math.pi, -50.0 * math.pi])
    assert found == ["30 deg", "3582 deg", "10 turns", "-25 turns"]


def test_readable_numbers_are_the_numbers(node):
    """With superscripts parsed, a number is its value rounded to its digits."""
    asked = [[value, digits] for value in random_doubles(200) for digits in (1, 4, 6)]
    for (value, digits), text in zip(asked, node.evaluate(READABLE, asked), strict=True):
        plain = text.translate(SUPERSCRIPTS).replace("×10", "e")
        assert abs(Decimal(plain) - Decimal(value)) <= abs(Decimal(value)) * Decimal(10) ** (1 - digits) / 2


def windows(rng, count):
    """Return random axes of all widths, as [center, half, scale, factor, approximate number of ticks]."""
    found = []
    for _ in range(count):
        centre = float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-6.0, 6.0))
        half = abs(centre) * float(10.0 ** rng.uniform(-10.0, 3.0))
        factor = float(rng.choice([1.0, 180.0 / math.pi, 1000.0]))
        found.append([centre, half, "linear", factor, float(rng.uniform(2.0, 15.0))])
        found.append(
            [float(rng.uniform(-9, 9)), float(10.0 ** rng.uniform(-9, 1)), "log", factor, found[-1][-1]]
        )
    return found


def read(label, offset, power):
    """Return the exact value of a label."""
    text = label.translate(SUPERSCRIPTS)
    if "10" in text and label[-1] in "⁰¹²³⁴⁵⁶⁷⁸⁹":
        lead, _, exponent = label.rpartition("10")
        return Decimal(lead.rstrip("×") or 1).scaleb(int(exponent.translate(SUPERSCRIPTS)))
    return Decimal(offset.replace("−", "-") or 0) + Decimal(text).scaleb(power)


def test_labels_are_the_values_at_their_places(node, rng, count):
    """The value of a label is at its tick, to 1e-5 of the window; steps are equal or decades."""
    asked = windows(rng, count(300, 5000))
    for (centre, half, scale, factor, most), axis in zip(asked, node.evaluate(TICKS, asked), strict=True):
        labelled = [tick for tick in axis["ticks"] if tick["label"]]
        places = [tick["place"] for tick in axis["ticks"]]
        assert all(-1.0 - 1e-6 <= place <= 1.0 + 1e-6 for place in places), (centre, half, scale)
        assert places == sorted(places)
        values = [read(tick["label"], axis["offset"], axis["power"]) for tick in labelled]
        for tick, value in zip(labelled, values, strict=True):
            at = Decimal(value) / Decimal(factor)
            if scale == "linear":
                place = float((at - Decimal(centre)) / Decimal(half))
            else:
                place = float((at.ln() - Decimal(centre)) / Decimal(half))
            assert abs(tick["place"] - place) < 2e-5, (centre, half, scale, factor, tick)
        is_decades = scale == "log" and 2.0 * half > 1.5 * math.log(10.0)
        if is_decades:
            continue
        steps = {b - a for a, b in itertools.pairwise(values)}
        assert len(steps) <= 1, (centre, half, scale)
        assert len(values) <= 1.5 * most + 2, (centre, half, scale, most)
        assert scale == "log" or len(values) >= 0.6 * most - 1, (centre, half, most)
        for step in steps:
            assert step.normalize().as_tuple().digits in ((1,), (2,), (5,))
            # no tick is missing at either end
            ends = [Decimal(each) * Decimal(factor) for each in (centre - half, centre + half)]
            if scale == "linear":
                assert min(values) - ends[0] < step * Decimal("1.001")
                assert ends[1] - max(values) < step * Decimal("1.001")
