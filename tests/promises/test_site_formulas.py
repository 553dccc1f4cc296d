"""Formulas of the site: what docs/_site/formulas.py repairs in docutils' MathML."""

import sys
from xml.etree import ElementTree

import pytest
from processes import CHECKOUT


@pytest.fixture
def mathml(monkeypatch):
    """Return the function that converts a formula."""
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(CHECKOUT / "docs" / "_site"))
    monkeypatch.delitem(sys.modules, "formulas", raising=False)
    from formulas import mathml

    return lambda text: ElementTree.fromstring(mathml(text, as_block=False))


@pytest.mark.parametrize(
    "text", [r"c |f| N |g|", r"c \lvert f\rvert N \lvert g\rvert", r"\sqrt{|f|} + \frac{n}{|f|}"]
)
def test_bars_of_an_absolute_value_are_brackets(mathml, text):
    """The first opens and the second closes; otherwise browsers space them as the relation "divides"."""
    bars = [each for each in mathml(text).iter("mo") if each.text == "|"]
    assert [each.get("form") for each in bars] == ["prefix", "postfix"] * 2


def test_a_power_of_an_absolute_value_stands_beside_all_of_it(mathml):
    """The base of the power is |f|, not the second bar."""
    formula = mathml(r"R^4 \lvert f\rvert^{5/2}")
    _, power = formula.iter("msup")
    assert "".join(power[0].itertext()) == "|f|"
    assert "".join(formula.itertext()) == "R4|f|5/2"


@pytest.mark.release
def test_root_signs_of_the_font_are_as_wide_as_each_other(mathml, tmp_path):
    """A browser reserves space for the widest one, which would leave a gap after a low root."""
    ttlib = pytest.importorskip("fontTools.ttLib")
    pytest.importorskip("ziamath")
    from formulas import write_font

    write_font(tmp_path / "font.ttf")
    font = ttlib.TTFont(tmp_path / "font.ttf")
    # The base, three larger ones, and the three parts of the largest.
    names = ["uni221A", *(f"uni221A.{each}" for each in ("s1", "s2", "s3", "s4", "x", "t"))]
    assert {font["hmtx"][name][0] for name in names} == {794}
    outlines = [font["glyf"][name].xMax for name in names]
    assert max(outlines) == outlines[0]
