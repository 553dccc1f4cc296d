"""The benchmark: its contenders solve the task, counts and records are right, and the page shows the record."""

import copy
import re
from dataclasses import replace

import numpy as np
import pytest
from bench import (
    bodies,
    libraries,
    loops,
    losses,
    lossy_loops,
    planned,
    problem,
    record,
    roofline,
    system_loops,
    systems,
    table,
    ten_systems,
)
from messages import assert_facts, assert_in_order, refused

AMD = "amd-epyc-avx-512"


@pytest.fixture
def records():
    """Return a copy of the records, which a test may change."""
    return copy.deepcopy(record.read_all())


def test_the_page_shows_the_records(records):
    """The table of docs/speed.md is rendered by docs/benchmark; `scripts/benchmark.py --page` writes it."""
    assert table.block_in() == table.page_block(records)


def test_the_readme_says_what_the_records_say(records):
    """It says a third of a microsecond, and over two thousand times as long for SciPy."""
    said = " ".join((record.CHECKOUT / "README.md").read_text(encoding="utf-8").split())
    assert_in_order(
        said, "peak tilt to 1e-8", "a third of a microsecond", "one thread", "two thousand times", "DOP853"
    )
    for found in records.values():
        rows = {row["name"]: row for row in found["field"]["contenders"]}
        assert 0.25 < rows["eulerdisk rk4"]["us_per_cell"]["median"] < 0.4
        assert 2000 < rows["SciPy DOP853"]["ratio"]["median"] < 3000


def test_the_records_are_written_into_a_page(records, tmp_path):
    """Only the text between the markers is replaced."""
    page = tmp_path / "speed.md"
    page.write_text("above\n<!-- benchmark -->\nold\n<!-- end of benchmark -->\nbelow\n", encoding="utf-8")
    table.write_page(records, page)
    assert table.block_in(page) == table.page_block(records)
    lines = page.read_text(encoding="utf-8").splitlines()
    assert (lines[0], lines[-1]) == ("above", "below")
    assert "old" not in lines


def test_every_record_stands_under_the_name_of_its_processor(records):
    """The file name is derived from the machine in the record."""
    assert records
    assert {name: record.kind(found["machine"]) for name, found in records.items()} == {
        name: name for name in records
    }


def test_a_kind_is_the_name_of_a_processor_without_marks():
    """Without clock rate, core count and trademark, the same processor has one record."""
    for processor, vectors, expected in (
        ("Intel(R) Xeon(R) Platinum 8488C", "AVX-512", "intel-xeon-platinum-8488c-avx-512"),
        ("Intel(R) Core(TM) i7-8700K CPU @ 3.70GHz", "AVX2", "intel-core-i7-8700k-avx2"),
        ("AMD EPYC 9R14 96-Core Processor", "AVX-512", "amd-epyc-9r14-avx-512"),
        ("arm64", "", "arm64"),
    ):
        assert record.kind({"processor": processor, "vectors": vectors}) == expected


def test_a_record_is_read_as_it_was_written(records, tmp_path):
    """The file is named after the kind of processor."""
    path = record.write(records[AMD], tmp_path)
    assert path.name == f"{AMD}.json"
    assert record.read_all(tmp_path) == {AMD: records[AMD]}


def test_a_loss_of_more_than_a_fifth_fails(records, capsys):
    """A ratio at 81 % of the same processor's record passes; at 79 % it is named and the status is 1.

    A processor without a record is compared with half the smallest ratio of the others, because vectors and
    memory differ.
    """
    for processor, share, status in (
        (None, 1.3, 0),
        (None, 0.81, 0),
        (None, 0.79, 1),
        ("another", 0.51, 0),
        ("another", 0.49, 1),
    ):
        found = copy.deepcopy(records[AMD])
        ratio = found["kernel"][0]["ratio"]
        if processor:
            found["machine"]["processor"] = processor
            ratio["median"] = min(each["kernel"][0]["ratio"]["median"] for each in records.values())
        ratio["median"] *= share
        assert record.report_losses(found, records) == status, (processor, share)
        assert ("own steps: " in capsys.readouterr().err) == bool(status)


def test_a_contender_that_is_not_installed_is_no_loss(records):
    """Contenders that did not run are not compared."""
    found = copy.deepcopy(records[AMD])
    found["field"]["contenders"] = found["field"]["contenders"][:3]
    assert record.report_losses(found, records) == 0


def test_what_whole_commands_take_is_compared(records, capsys):
    """A run that takes longer relative to its kernels, and a slower command start, are losses."""
    found = copy.deepcopy(records[AMD])
    found["whole"] = {"run": {"cells": 10, "seconds": 3.0, "least_possible": 2.0, "memory_MB": 1.0}}
    found["start"] = {"bare": 0.3, "warm": {"info": 0.5}, "cold": {"run": 5.0}}
    before = {AMD: copy.deepcopy(found)}
    assert record.report_losses(found, before) == 0
    found["whole"]["run"]["seconds"], found["start"]["warm"]["info"] = 4.0, 0.8
    assert record.report_losses(found, before) == 1
    told = capsys.readouterr().err
    assert "run of 10 cells: 0.5, recorded 0.667" in told
    assert "info: 0.375, recorded 0.6" in told


def test_the_time_that_a_plan_states_is_read():
    """The time is in seconds, whatever its unit."""
    assert planned._seconds("blocks   3\ntime     about 12 s (1e6 cells per second)") == 12.0
    assert planned._seconds("time     about 2.5 min") == 150.0


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


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize("name", ["engine", "plain loop", "heyoka"])
def test_a_contender_stops_a_toy(name):
    """At a fine setting it finds the times of the tests' referee to 1e-7."""
    given = problem.some(losses.starts(losses.TASK), 16)
    if name == "heyoka":
        pytest.importorskip("heyoka")
    solve, setting = {
        "engine": (losses._engine, 1e-9), "plain loop": (lossy_loops.plain, 0.03), "heyoka": (lossy_loops.Heyoka, 1e-9),
    }[name]  # fmt: skip
    found, steps = (solve() if name == "heyoka" else solve)(given, setting)
    np.testing.assert_allclose(found, losses._true_times(given), rtol=1e-7)
    assert (steps > 16 * 1000) == (name != "heyoka")


@pytest.mark.release
@pytest.mark.compiled
def test_many_toys_are_flat_and_their_lanes_are_timed():
    """Steps, times and shares are reported; of three equal chunks, one of two threads computes two."""
    found = losses._toys(8)
    assert found["cells"] == 64
    assert found["flat"] == 1.0
    assert found["steps_per_cell"] > 50_000
    assert found["times"][0] < found["times"][1] < found["times"][2]
    assert min(found["share_of_threads"], found["share_of_lanes"]) > 0.0
    assert losses._longest_thread([1.0, 1.0, 1.0], 2) == 2.0


def test_what_losses_cost_is_told_and_compared(records):
    """The table has a line for each contender, and a lower ratio is a loss."""
    found = copy.deepcopy(records[AMD])
    row = {
        "setting": 1e-6,
        "cells": 8,
        "error": 1e-7,
        "us_per_cell": 9.0,
        "steps_per_cell": 5.0,
        "ns_per_step": 2.0,
    }
    found["losses"] = {
        "task": "toys",
        "contenders": [row | {"name": "eulerdisk rk4", "ratio": 1.0}, row | {"name": "a loop", "ratio": 9.0}],
        "toys": {"cells": 4, "threads": 2, "seconds": 1.0, "processor_seconds": 2.0, "share_of_threads": 0.9,
                 "share_of_lanes": 0.8, "steps_per_cell": 7.0, "ns_per_step": 9.0, "repeated": 0.5,
                 "times": [1.0, 2.0, 3.0]},
    }  # fmt: skip
    (line,) = (each for each in table.text(found).splitlines() if "4 toys" in each)
    assert_in_order(line, "4 toys", "2 s", "1 to 3", "2 thread(s)", "1.0 s", "2.0 s")
    assert record.ratios(found)["a loop / eulerdisk rk4, with losses"] == 9.0


def test_what_bodies_cost_is_told_and_compared(records):
    """The table has a line for each body next to the thin disk, from measurements of few cells."""
    found = copy.deepcopy(records[AMD])
    steps = bodies._step_times(40, 1)
    assert steps.keys() == bodies.BODIES.keys() - {"ball", "spheroid"}
    assert all(0.0 < each < 1e5 for each in steps.values())
    row = bodies._errors("rim", 60)
    assert row["other_endings"] == 0
    assert row["largest_error"] < 1e-8
    ball = bodies._errors("ball", 60)
    assert ball.keys() == {"cells", "reduction_us"}
    found["bodies"] = {"ns_per_step": {"disk": 5.0, "rim": 10.0}, "errors": {"rim": row, "ball": ball}}
    assert re.search(r"^ *ball +reduction [0-9.]+ us per cell$", table.text(found), re.MULTILINE)
    assert re.search(r"^ *rim +10\.00 ns +2\.00 times\b", table.text(found), re.MULTILINE)
    assert record.ratios(found)["step of the thin disk / rim"] == 0.5


def systems_row(name="lorenz"):
    """Return a row of systems."""
    cost = {
        "eulerdisk": 2.0,
        "heyoka batch 4": 5.0,
        "heyoka batch 8": 4.0,
        "compiled DOP853": 20.0,
        "SciPy DOP853": 9e3,
    }
    ratio = {each: value / 2.0 for each, value in cost.items()}
    return {"name": name, "compiled_s": 2.0, "us_per_cell": cost, "ratio": ratio, "whole_us_per_cell": 6.0}


def test_what_systems_cost_is_told_and_compared(records):
    """The table has a line, the page has one with the best batch, and a lower ratio is a loss."""
    found = copy.deepcopy(records[AMD])
    found["systems"] = {
        "target": 1e-8, "cells": 1024, "day": "2026-11-24", "rows": [systems_row()], "disk": {"ratio": 1.8},
        "first_s": 4.0, "changed_s": 0.8,
    }  # fmt: skip
    assert_facts(table.text(found), "thin disk", "1.80 times")
    page = table.page_block({AMD: found})
    assert_in_order(page, "4 s", "compile", "0.8 s")
    assert "| lorenz | 2 | 6 | 4 (2 ×) | 20 (10 ×) | 9,000 (4,500 ×) |" in page
    worse = copy.deepcopy(found)
    worse["systems"]["rows"][0]["ratio"]["heyoka batch 8"] = 1.5
    assert record.losses(worse, record.ratios(found)) == [
        "heyoka batch 8 / one pass, lorenz: 1.5, recorded 2"
    ]


def test_the_time_at_an_error_lies_between_two_settings():
    """Costs are interpolated logarithmically between the settings on either side of the error."""
    truth = np.zeros((1, 10))

    def solve(given, setting):
        return truth[:, : given.shape[1]] + 10.0 * setting

    bracket = systems._bracket(solve, truth, truth)
    assert [setting for setting, _ in bracket] == pytest.approx([1e-8, 1e-9])
    assert [error for _, error in bracket] == pytest.approx([1e-7, 1e-8])
    with refused(f"{systems.TARGET:g}", error=RuntimeError):
        systems._bracket(lambda given, setting: truth + 1.0, truth, truth)


@pytest.mark.parametrize("chosen", ten_systems.RANGES, ids=lambda each: each.__name__)
def test_others_integrate_what_was_written(chosen, rng):
    """SciPy, the compiled loop's source and heyoka find the same final states from the same starts."""
    pytest.importorskip("heyoka")
    definition = replace(ten_systems.bare(chosen.definition), duration=0.5)
    given = ten_systems.random_starts(chosen, 8, rng)
    scipy = system_loops.Scipy(definition)(given, 1e-12)
    np.testing.assert_allclose(
        ten_systems.Heyoka(definition, 1e-16, float, 4).ends(given), scipy, atol=1e-9, rtol=1e-9
    )
    precise = ten_systems.Heyoka(definition, 1e-20, np.longdouble).motions(given)[0].T
    np.testing.assert_allclose(precise.astype(float), scipy, atol=1e-9, rtol=1e-9)


@pytest.mark.release
@pytest.mark.compiled
def test_a_pass_and_a_compiled_loop():
    """Both compiled methods agree with SciPy."""
    definition = replace(ten_systems.bare(ten_systems.driven_pendulum.definition), duration=5.0)
    given = ten_systems.random_starts(ten_systems.driven_pendulum, 8, np.random.default_rng(1))
    scipy = system_loops.Scipy(definition)(given, 1e-12)
    for solve in (systems.Pass(definition), system_loops.Loop(definition)):
        np.testing.assert_allclose(solve(given, 1e-12), scipy, atol=1e-9, rtol=1e-9)
