import math
import re

import lossy_runner
import numpy as np
import pytest
from messages import assert_facts, refused

import sweep
from sweep.commands.report import boundary_table, describe
from sweep.model.quantity import spell_size
from sweep.request.spec import SweepSpec

ROLLING = SweepSpec.preset("rolling").replace(roll_rate="2:4:81", tilt="0.001deg,1deg,4deg")
CIRCLING = SweepSpec.preset("circling").replace(tilt="5deg,10deg,25deg", precession_rate="0.05:5:80")


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Give all atlases the same date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")


def rows(table):
    """Return the lines of a table, split at two or more blanks."""
    return [re.split(r" {2,}", line.strip()) for line in table.splitlines()]


def row(head, text):
    """Return the line of a description that begins with a word."""
    (line,) = (line for line in text.splitlines() if re.match(rf" *{head} ", line))
    return line


@pytest.mark.compiled
def test_losses_that_are_not_there_are_not_told():
    """Losses that are 0 in every cell and unlimited friction are left out; a 0 in an axis is shown."""
    words = (
        "tilt=80deg,85deg precession_rate=wobble contour_friction=0,15um rolling_friction=1um air_law=none "
        "air_viscosity=0 air_density=0 criterion=departure:5deg duration=0.1s"
    )
    with lossy_runner.general_kernels():
        told = describe(sweep.run(SweepSpec.from_words("toy", words.split())))
    (fixed,) = (line for line in told.splitlines() if line.startswith("fixed"))
    assert "rolling_friction 1e-06 m" in fixed
    assert "tilt_rate 0 rad s-1" in fixed
    for name in ("pivoting_friction", "contour_damping", "air_viscosity", "air_density", "unlimited"):
        assert name not in fixed
    assert_facts(row("contour_friction", told), "0 to 1.5e-05 m", "2 values", "listed")


def test_an_atlas_in_words():
    """A report gives grid, fixed values, criterion, endings, verdicts, errors, boundary and origin."""
    dataset = sweep.run(ROLLING)
    text = describe(dataset)
    assert dataset.title in text
    assert_facts(row("grid", text), "81 x 3 = 243 cells")
    assert_facts(row("roll_rate", text), "2 to 4 rad s-1", "81 values", "linear")
    assert_facts(row("tilt", text), "0.001 to 4 deg", "3 values", "listed")
    assert_facts(row("fixed", text), "radius 0.5 m", "gravity 9.81 m s-2", "alpha 0.5")
    assert_facts(row("criterion", text), "5 deg")
    assert_facts(row("method", text), "rk4", "duration 300 s", "step auto")
    assert_facts(row("ending", text), "243 bounded")
    stable, unstable = (int((dataset.stability == code).sum()) for code in (1, 2))
    assert_facts(row("stability", text), f"{stable} stable", f"{unstable} unstable")
    low, high = (float(np.degrees(end)) for end in (dataset.peak_tilt.min(), dataset.peak_tilt.max()))
    assert_facts(row("peak tilt", text), f"{low:.6g} to {high:.6g} deg")
    assert_facts(text, f"{float(dataset.tilt_error.max()):.1e} rad")
    # the row of 4 degrees is not stable anywhere on the axis
    found, missed = (line for line in text.splitlines() if "of 3 rows" in line)
    assert_facts(found, "2 of 3 rows", "roll_rate")
    assert_facts(missed, "1 of 3 rows", "roll_rate", "unstable throughout")
    assert_facts(row("made", text), "1970-01-01T00:00:00Z sweep.run")
    assert ROLLING.fingerprint()[:16] in text


def test_an_atlas_of_one_cell():
    """An atlas of one cell is described as such, without a boundary."""
    dataset = sweep.run(SweepSpec(tilt="1deg", roll_rate=3))
    text = describe(dataset)
    assert_facts(row("grid", text), "one cell")
    assert "boundary" not in text
    assert_facts(boundary_table(dataset), "no boundary", "precession_rate", "roll_rate")


def test_a_line_in_words():
    """One axis has no product, plain numbers no unit; angles are in degrees, the tolerance in radians."""
    text = describe(sweep.run(SweepSpec(tilt="1deg", roll_rate=3, alpha=[0.5, 1.0])))
    assert row("grid", text).split() == ["grid", "2", "cells"]
    assert_facts(row("alpha", text), "0.5 to 1,", "2 values", "listed")
    assert_facts(text, "fall_tilt 85 deg", "tolerance 1e-08 rad")


def test_sizes_of_errors_have_the_units_of_their_variables():
    """A pure number has no unit, and small sizes are powers of ten."""
    of_system = describe(sweep.run("henon_heiles", u="-1:1:8", v="-1:1:8", duration=20))
    assert not re.search(r"\de[+-]\d+ 1\b|e[+-]00", of_system)
    assert_facts(row("errors", describe(sweep.run("kapitza", shake="80:120:5"))), "rad", "rad s-1")
    assert spell_size(1.6, "1") == "1.6"
    assert spell_size(0.91) == "0.91"
    assert spell_size(6.7e-10, "rad") == "6.7e-10 rad"


def test_a_boundary_without_a_rate_is_told_as_curves():
    """An atlas over tilts and kicks lists the points of its curves; without curves it says how to get them."""
    spec = SweepSpec(roll_rate=3, tilt="0.1deg:3deg:6", tilt_rate="0.001:1:7")
    coarse = sweep.run(spec)
    assert_facts(boundary_table(coarse), "--refine WIDTH", "curves")
    assert "curves" not in describe(coarse)
    fine = sweep.refine(coarse, 1e-6)
    head, *lines = rows(boundary_table(fine))
    assert head == ["curve", "tilt [deg]", "+-", "tilt_rate [rad s-1]", "+-"]
    assert [line[0] for line in lines] == ["1 open"] * fine.sizes["curve_point"]
    for i, line in enumerate(lines):
        place = [math.degrees(fine.curve_tilt[i]), float(fine.curve_tilt_rate[i])]
        assert [float(line[1]), float(line[3])] == pytest.approx(place, abs=1e-6)
        assert (line[2] == "0") != (line[4] == "0")
    points = fine.sizes["curve_point"]
    assert_facts(row("curves", describe(fine)), "1", f"{points} points", "0 closed", "tilt", "tilt_rate")


def test_an_atlas_without_numbers():
    """If no cell could be computed, the report says so."""
    dataset = sweep.run(SweepSpec(roll_rate="steady", tilt="10deg", precession_rate="-1:1:3"))
    text = describe(dataset.where(dataset.tilt > 1.0).fillna({"ending": 6, "stability": 0}))
    assert "3 invalid" in text
    assert_facts(row("peak tilt", text), "no cell")
    assert "within -" in text


def test_all_endings_are_counted():
    """Each ending and verdict that occurs is counted by name, and the steady roll rate is named."""
    text = describe(
        sweep.run(CIRCLING.replace(precession_rate="-1:1:3", tilt="10deg,25deg", tilt_rate="0,1e-4"))
    )
    assert "2 x 3 x 2 = 12 cells" in text
    counts = re.search(r"^ending +(.*)$", text, re.MULTILINE)[1]
    assert sum(map(int, re.findall(r"\d+", counts))) == 12
    assert "4 invalid" in counts
    assert "4 steady" in counts
    assert_facts(text, "roll_rate steady", "computed")
    assert_facts(row("criterion", text), "10", "perturbation")


def test_the_boundary_table_holds_the_numbers_of_the_dataset():
    """Each row has one tilt with the measured, predicted and critical rate, to the printed digits."""
    dataset = sweep.run(ROLLING)
    head, *lines = rows(boundary_table(dataset))
    assert head == [
        "tilt [deg]",
        "boundary_roll_rate [rad s-1]",
        "+-",
        "predicted_roll_rate",
        "critical_roll_rate",
        "row",
    ]
    assert len(lines) == 3
    assert [line[-1] for line in lines] == ["found", "found", "unstable throughout"]
    names = [
        "boundary_roll_rate",
        "boundary_roll_rate_halfwidth",
        "predicted_roll_rate",
        "critical_roll_rate",
    ]
    for i, (tilt, *numbers, _) in enumerate(lines):
        assert float(tilt) == pytest.approx(math.degrees(dataset.tilt[i]), rel=1e-5)
        assert numbers == [
            f"{v:.6f}" if np.isfinite(v) else "-" for v in (float(dataset[name][i]) for name in names)
        ]
    # 4 degrees cannot be stable within 5 at these rates, 0.001 degrees can
    assert lines[2][1] == "-"
    assert lines[0][1] != "-"


def test_both_edges_of_circling_have_a_table():
    """The two edges of the circling band have a table each, without rows beyond the end of the band."""
    dataset = sweep.run(CIRCLING)
    upper, lower = boundary_table(dataset).split("\n\n")
    for table, name in ((upper, "boundary_precession_rate"), (lower, "boundary_lower_precession_rate")):
        head, *lines = rows(table)
        assert head[1] == f"{name} [rad s-1]"
        assert [line[1] for line in lines] == [
            f"{v:.6f}" if np.isfinite(v) else "-" for v in dataset[name].values
        ]
        assert lines[2][1:] == [*["-"] * 4, "stable throughout"]
    assert "stable below precession_rate" in describe(dataset)
    notes = [line for line in describe(dataset).splitlines() if "no boundary" in line]
    assert len(notes) == 2
    for line in notes:
        assert_facts(line, "1 of 3 rows", "precession_rate", "stable throughout")


def test_why_there_is_no_boundary():
    """If no row has a boundary, the reason is printed instead of the table."""
    dataset = sweep.run(ROLLING.replace(roll_rate="3.5:4:5", tilt="0.1deg,1deg"))
    said = "\nboundary    no boundary: stable throughout, along roll_rate (stable above)\n"
    assert said in describe(dataset)
    assert [row[-1] for row in rows(boundary_table(dataset))] == ["row", *["stable throughout"] * 2]


def test_the_boundary_table_of_any_number_of_axes():
    """Without another axis than the rate the table has one row; otherwise it has one row per combination."""
    for count in [0, 1, 2, 3]:
        others = dict(list({"tilt": "1deg,2deg", "alpha": "0.5,0.8,1", "radius": "0.5,1"}.items())[:count])
        dataset = sweep.run(SweepSpec(**{"roll_rate": "1:9:17", "tilt": "1deg", **others}))
        table = boundary_table(dataset)
        head, *lines = rows(table)
        assert head[:count] == ["tilt [deg]", "alpha", "radius [m]"][:count]
        assert len(lines) == math.prod((2, 3, 2)[:count])
        measured = dataset.boundary_roll_rate
        for line in lines:
            where = dict(zip(others, map(float, line), strict=False))
            if "tilt" in where:
                where["tilt"] = math.radians(where["tilt"])
            assert line[count] == f"{float(measured.sel(where, method='nearest') if where else measured):.6f}"
        # numbers are aligned with their headers
        columns = [match.start() for match in re.finditer(r"\S+( \S+)*", table.splitlines()[0])][: count + 1]
        for line in table.splitlines()[1:]:
            assert [match.start() for match in re.finditer(r"\S+", line)][: count + 1] == columns


def test_a_narrow_bracket_is_told_with_its_digits():
    """A boundary bisected to 1e-9 is printed with all known digits."""
    fine = sweep.refine(sweep.run(ROLLING.replace(tilt="0.1deg,1deg")), 1e-9)
    _, *lines = rows(boundary_table(fine))
    for i, (_, measured, half, *_) in enumerate(lines):
        assert re.fullmatch(r"\d\.\d{11,12}", measured), measured
        assert float(measured) == pytest.approx(float(fine.boundary_roll_rate[i]), abs=1e-11)
        assert re.fullmatch(r"\d\.\de-10", half), half


def test_a_report_on_a_part_is_refused():
    """`describe` refuses a selection, because its text would be about the whole."""
    part = sweep.run(ROLLING).isel(tilt=0)
    for function in (describe, boundary_table):
        with refused("whole atlas"):
            function(part)
