"""docs/losses.md is runnable: its commands and the times of its table are computed here."""

import math
import re
from fractions import Fraction
from pathlib import Path

import pytest
from latex_formula import Page, lines

import sweep
from sweep.model.lossy_disk.model import LOSSY_DISK

CHECKOUT = Path(__file__).resolve().parents[2]
PAGE = (CHECKOUT / "docs" / "losses.md").read_text(encoding="utf-8")
THEORY = Page("losses-theory.md")

#: The disk of the table, as its text describes it.
TOY = {
    "tilt": math.pi / 2 - 0.1, "precession_rate": "wobble", "roll_rate": "wobble",
    "alpha": 0.5, "radius": 0.03755, "mass": 0.4387, "duration": 300.0,
}  # fmt: skip


def table(heading):
    """Return the rows of the table that begins with a heading, each a list of cells."""
    lines = PAGE[PAGE.index(f"| {heading} |") :].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def test_the_page_names_every_loss():
    """The table of laws has every coefficient that a request may give, and no other."""
    named = set(re.findall(r"`(\w+)`", "".join(row[1] for row in table("law"))))
    assert named == {name for name in LOSSY_DISK.parameters if name.endswith(("friction", "damping"))} - {
        "friction"
    } | {"air_viscosity", "air_density", "mass"}


@pytest.mark.compiled
@pytest.mark.parametrize(("words", "said"), [(row[0], row[1]) for row in table("losses")])
def test_its_times_are_those_of_the_program(words, said):
    """Each time of the table comes out of the words beside it, to its last digit."""
    given = dict(word.split("=") for word in words.strip("`").split())
    motion = sweep.simulate(**TOY, **given)
    seconds = said.removesuffix(" s")
    assert f"{float(motion['elapsed_time'][-1]):.2f}" == seconds


def test_the_exponents_of_the_precession_rate_are_half_those_of_the_inclination():
    """In every row of the closed forms: precession^2 is proportional to 1/inclination."""
    section = PAGE[PAGE.index("## How it ends") :]
    pairs = re.findall(r"^\| [\w, ]+ \| ([\d/]+) \| −([\d/]+) \|", section, flags=re.MULTILINE)
    assert len(pairs) == 5
    assert all(Fraction(tilt) == 2 * Fraction(rate) for tilt, rate in pairs)


@pytest.mark.parametrize("place", range(5))
def test_its_times_to_flat_are_those_of_the_theory(place):
    """For any disk and for the uniform one, as printed, they are those of docs/losses-theory.md."""
    row = table(
        r"law | inclination $\propto (t_f-t)^n$ | precession rate $\propto (t_f-t)^{-n/2}$ | $t_f$ from $a_0$"
    )
    of_any, uniform = (lines(f"t = {cell.strip('$')}")[0] for cell in row[place][3:])
    known = {"a_0": 0.07, "c": 0.2, "k": 0.3, "q": 0.4}
    for alpha in (0.5, 0.8):
        theory = THEORY.formulas["times"][place].value({**known, "alpha": alpha})
        assert of_any.value({**known, "alpha": alpha}) == pytest.approx(theory)
    assert uniform.value(known) == pytest.approx(of_any.value({**known, "alpha": 0.5}), rel=3e-3)


def test_its_drags_are_those_of_the_theory():
    """Both q, as printed, are those of docs/losses-theory.md."""
    known = {"pi": math.pi, "mu": 2.0, "rho": 3.0, "R": 0.4, "g": 5.0, "m": 0.6}
    found = [lines(text)[0].value(known) for text in re.findall(r"\$(q = [^$]+)\$", PAGE)]
    assert found == pytest.approx([line.value(known) for line in THEORY.formulas["coefficients"][1:]])


@pytest.mark.compiled
def test_its_commands_run(command, tmp_path):
    """Every command runs and leaves the files that it names."""
    (block,) = re.findall(r"^```bash\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    for line in block.splitlines():
        status, _, err = command(line.removeprefix("eulerdisk "))
        assert status == 0, (line, err)
    assert {each.name for each in tmp_path.iterdir()} >= {"toy.nc", "toy.png", "stop.nc", "stop.png"}
