"""The benchmark: its contenders do the task, its count and its record are right, and the README shows the record."""

import copy

import numpy as np
import pytest
from bench import libraries, loops, problem, record, roofline


def test_the_readme_shows_the_record():
    """The table of the README is what docs/benchmark.json renders; `scripts/benchmark.py --readme` puts it there."""
    assert record.block_in() == record.readme_block(record.read())


def test_the_record_is_written_into_a_readme(tmp_path):
    """Only what stands between the markers is replaced."""
    readme = tmp_path / "README.md"
    readme.write_text("above\n<!-- benchmark -->\nold\n<!-- end of benchmark -->\nbelow\n", encoding="utf-8")
    record.write_readme(record.read(), readme)
    assert record.block_in(readme) == record.readme_block(record.read())
    lines = readme.read_text(encoding="utf-8").splitlines()
    assert (lines[0], lines[-1]) == ("above", "below")
    assert "old" not in lines


@pytest.mark.parametrize(("share", "status"), [(1.3, 0), (0.81, 0), (0.79, 1)])
def test_a_loss_of_more_than_a_fifth_fails(capsys, share, status):
    """A ratio at 81 % of the recorded one passes, at 79 % it ends with 1 and is named."""
    recorded = record.read()
    found = copy.deepcopy(recorded)
    found["kernel"][0]["ratio"]["median"] *= share
    assert record.report_losses(found, recorded) == status
    assert ("own steps: " in capsys.readouterr().err) == bool(status)


def test_a_contender_that_is_not_installed_is_no_loss(capsys):
    """What was not run is not compared."""
    recorded = record.read()
    found = copy.deepcopy(recorded)
    found["field"]["contenders"] = found["field"]["contenders"][:3]
    assert record.report_losses(found, recorded) == 0


@pytest.mark.compiled
def test_the_multiply_adds_of_a_step():
    """One step has 77 multiply-adds, counted by hand.

    Slopes: 5 in each of four stages (oT; 1 + T^2; do; the bracket and the sum of the acceleration). Arguments of three
    stages: 5 each. Sums of slopes: 5 in each stage. Angles: 5 (half w; rate, half and whole; whole; last: 2 more than
    its w); w in three stages. Results: 5 for S, C, T, o and p; the sum of accelerations 4 and two for w. The step by
    i_tilt, whose double is one multiply-add with it, and the step from its half, twice: 3.
    """
    slopes, arguments, sums = 4 * 5, 3 * 5, 4 * 5
    angles, rates = 1 + 2 + 1 + 1, 3
    assert roofline.multiply_adds() == slopes + arguments + sums + angles + rates + 5 + (4 + 2) + 3


@pytest.mark.compiled
@pytest.mark.parametrize("name", ["eulerdisk rk4", "NumPy RK4", "SciPy DOP853", "SciPy LSODA"])
def test_a_contender_does_the_task(name):
    """At its finest setting a contender finds the exact peak tilts to 1e-8 rad."""
    known = {each.name: each for each in [*loops.contenders(True), *libraries.contenders(True)]}
    given = problem.some(problem.starts(("roll_rate=2:4:40", "tilt=0.1deg:5deg:30:log")), 12)
    seconds, found = known[name].prepare()(given, known[name].settings[-1])
    assert seconds > 0.0
    assert np.abs(found - problem.peaks(given)).max() <= 1e-8
