"""`explain` repeats a cell bit for bit, compares it with exact values and states its verdict in words."""

import json
import math
import re

import netCDF4
import numpy as np
import pytest
import referee
from messages import assert_facts, assert_in_order, refused, row

import sweep
from sweep.checks.explain import explain
from sweep.checks.explanation import _fold
from sweep.figures.disk import cell_plot
from sweep.model.disk import theory

ROLLING = sweep.SweepSpec.preset("rolling").replace(roll_rate="1:4:7", tilt="0.01deg:40deg:6:log")
KICKED = sweep.SweepSpec(
    tilt=0.0,
    tilt_rate="0.01:10:4:log",
    roll_rate="8:20:9",
    radius="2cm",
    duration="0.5s",
    criterion="amplification:10",
)
CIRCLING = sweep.SweepSpec.preset("circling").replace(precession_rate="0.05:5:12", tilt="1deg:25deg:9")


def start(**changed):
    """Return one start in the form the modules of a cell expect, by default of a disk of the report."""
    disk = {"tilt": 0.0, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 0.0}
    return disk | {"alpha": 0.5, "radius": 0.5, "gravity": 9.81} | changed


def test_the_exact_values_are_those_of_the_literature():
    """The report gives the turning points of published starts and the error of the cell."""
    for given, degrees in [
        ({"tilt_rate": 0.01, "roll_rate": 2.0}, (-41.6082, 41.6082)),
        ({"tilt_rate": 0.1, "precession_rate": 3.5}, (-28.6591, 28.6591)),
        ({"tilt": 0.5, "precession_rate": 4.5}, (28.6479, 79.3831)),
    ]:
        found = explain(sweep.run(sweep.SweepSpec(**given)), {})
        exact = found.text[found.text.index("\nexact ") :]
        for name, value in zip(("tilt_min", "tilt_max"), degrees, strict=True):
            line = row(exact, f"  {name}")
            assert float(line.split()[1]) == pytest.approx(value, abs=5.1e-5), (given, degrees)
            off = re.search(r"(\S+) rad\b", line)[1]
            assert float(off) < 1e-8, (given, degrees)


def test_every_cell_is_repeated_to_the_bit(tmp_path):
    """A cell is run again from the file only: all its values have the same bits, and the report says so."""
    for spec, given in [
        (ROLLING, {"roll_rate": 2.4, "tilt": "1deg"}),
        (ROLLING, {"roll_rate": 1, "tilt": "40deg"}),
        (KICKED, {"roll_rate": 14, "tilt_rate": 0.01}),
        (KICKED, {"roll_rate": 8, "tilt_rate": 10}),
        (CIRCLING, {"precession_rate": 4, "tilt": "10deg"}),
        (ROLLING.replace(roll_rate=3.0, tilt="1deg"), {}),
    ]:
        sweep.run_to_file(spec, tmp_path / "a.nc", overwrite=True)
        with sweep.open_atlas(tmp_path / "a.nc") as atlas:
            found = explain(atlas, given)
        assert (found.exactly, found.repeated) == (True, True), (spec, given)
        told = row(found.text, "repeated")
        assert_facts(told, "same kernels", "every value", "bit for bit")
        assert "tolerance" not in told


def test_lines_of_theory_have_their_numbers():
    """The critical rate is for no perturbation; the predicted one, for 1 deg and a limit of 5 deg, is higher."""
    atlas = sweep.run("rolling", roll_rate="2:3:5", tilt="1deg,2deg")
    text = explain(atlas, {"roll_rate": 2.5, "tilt": "1deg"}).text
    numbers = {}
    for word in ("no perturbation", "this criterion"):
        (line,) = (line for line in text.splitlines() if word in line)
        numbers[word] = float(line.split()[0])
    assert numbers["no perturbation"] == pytest.approx(math.sqrt(9.81 / (3.0 * 0.5)), abs=6e-6)
    edge = atlas.eulerdisk.boundary().isel(tilt=0)
    assert numbers["this criterion"] == pytest.approx(float(edge.predicted), abs=6e-6)
    assert numbers["this criterion"] > 3.0


def test_the_words_say_why():
    """Each kind of ending and verdict has its reason, and moving cells get a figure."""
    for spec, given, verdict, because in [
        (ROLLING, {"roll_rate": 2.0, "tilt": "1.45deg"}, "unstable", ["tilt", "44.7295 deg", "5 deg"]),
        (ROLLING, {"roll_rate": 4, "tilt": "0.01deg"}, "stable", ["tilt", "5 deg", "turning points"]),
        (ROLLING, {"roll_rate": 1, "tilt": "40deg"}, "unstable", ["fall_tilt", "85 deg", "0.391097 s"]),
        (KICKED, {"roll_rate": 14, "tilt_rate": 0.01}, "undecided", ["0.28924 deg", "0.5 s"]),
        (
            KICKED,
            {"roll_rate": 20, "tilt_rate": 0.01},
            "stable",
            ["0.28924 deg", "10", "perturbation", "0.028924 deg"],
        ),
        (ROLLING.replace(roll_rate=3.0, tilt="0"), {}, "undecided", ["steady motion"]),
        (
            CIRCLING.replace(tilt=0.1, precession_rate="-1,0,1"),
            {"precession_rate": 0},
            "undecided",
            ["start"],
        ),
    ]:
        found = explain(sweep.run(spec), given)
        assert row(found.text, "verdict").split()[1] == verdict, (spec, given, verdict, because)
        assert_facts(row(found.text, "verdict"), str(spec.criterion))
        assert_facts(row(found.text, "because"), *because)


def test_linear_theory():
    """Period and reach of small motions agree with the exact extremes; for k < 0 the report gives the growth."""
    atlas = sweep.run(ROLLING)
    told = row(explain(atlas, {"roll_rate": 3.5, "tilt": "0.01deg"}).text, "linear")
    assert_in_order(told, "oscillations", "1.69729 s", "1.69729 s")
    # the tilt of a uniform disk grows as exp(t sqrt(4/5 (g/R - 3 s^2)))
    grown = math.log(2.0) / math.sqrt(0.8 * (9.81 / float(atlas["radius"]) - 3.0 * 2.0**2))
    told = row(explain(atlas, {"roll_rate": 2, "tilt": "1deg"}).text, "linear")
    assert_facts(told, "< 0", "doubles", f"{grown:.4g} s")
    for given, spec in [
        (start(tilt=1e-5, roll_rate=3.5), ROLLING),
        (start(tilt=1e-5, precession_rate=5.0, alpha=1.0), ROLLING),
        (start(tilt_rate=1e-5, roll_rate=3.0), KICKED),
    ]:
        reach = theory.small_reach(spec, given, theory.coefficient(spec, given))
        assert reach == pytest.approx(referee.extremes(referee.starts(**given)).peak[0], rel=1e-5)
    both = explain(sweep.run(ROLLING.replace(precession_rate=1.0)), {"roll_rate": 2, "tilt": "1deg"}).text
    assert_facts(row(both, "linear"), "no upright steady motion")


def test_the_row_has_its_boundaries():
    """The measured, predicted and critical rates of the cell's row equal those of the atlas."""
    atlas = sweep.run(CIRCLING)
    cell = {"precession_rate": 4, "tilt": "10deg"}
    text = explain(atlas, cell).text
    for name in ("boundary", "predicted", "critical"):
        for edge in ("", "lower_"):
            value = float(atlas[f"{name}_{edge}precession_rate"].values[3])
            assert f"{value:.6g} rad s-1" in text, name


def test_a_long_line_is_not_broken_before_a_unit():
    """Wrapping a long line never separates a number from its unit, even a unit of two words."""
    for before in range(90, 120):
        line = "x " * (before // 2) + "2.5508 rad s-1, 1.25 deg, 12 s, 0.1 m and 15 words"
        folded = _fold(line)
        assert " ".join(folded.split()) == line
        for kept in ("2.5508 rad s-1", "1.25 deg", "12 s", "0.1 m"):
            assert kept in folded


def test_a_row_without_a_boundary_says_why():
    """The report states why a row has no boundary, as the atlas does."""
    text = explain(sweep.run(ROLLING.replace(roll_rate="1:2:5")), {"roll_rate": 1, "tilt": "1deg"}).text
    told = row(text, "boundary")
    assert_facts(told, "none", "tilt", "stable above roll_rate", "unstable throughout", "1")


def test_the_command(command, tmp_path):
    """`explain` prints the report, draws the figure on request, and refuses an invalid cell before drawing."""
    sweep.run_to_file(ROLLING, "a.nc")
    status, out, err = command("explain a.nc roll_rate=2.4 tilt=1deg --plot a.png")
    assert (status, err) == (0, "")
    assert out.startswith("cell ")
    assert_facts(row(out, "cell"), "roll_rate 2.5 rad s-1", "4 of 7")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    for line, facts in (
        ("explain a.nc roll_rate=2.4 --plot b.png", ["roll_rate, tilt", "tilt=1.45deg"]),
        ("explain a.nc roll_rate=2 tilt=1deg --plot b.xyz", [".png"]),
    ):
        status, _, err = command(line)
        assert status == 2
        assert_facts(err, *facts)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nc", "a.png"]


def test_a_cell_that_was_tampered_with(command, tmp_path):
    """A value that no run gives is named and the status is 1; a difference in the last bit is only noted."""
    sweep.run_to_file(ROLLING, "a.nc")
    line = "explain a.nc roll_rate=2.5 tilt=0.01deg"
    with netCDF4.Dataset("a.nc", "a") as file:
        file["tilt_max"][3, 0] = np.nextafter(file["tilt_max"][3, 0], 2.0)
        file.kernel_hash = "0" * 64
    status, out, _ = command(line)
    assert status == 0
    assert_facts(row(out, "repeated"), "not", "bit", "tilt_max", "within", "kernels", "000000000000")
    with netCDF4.Dataset("a.nc", "a") as file:
        file["tilt_max"][3, 0] = 0.5
    status, out, _ = command(line)
    assert status == 1
    assert_facts(row(out, "repeated"), "tilt_max", "DIFFER", "beyond")


def test_a_measure_that_the_atlas_lacks():
    """A measure that was dropped from the atlas is left out of the report; the rest is repeated."""
    atlas = sweep.run(ROLLING)
    cell = {"roll_rate": 3.5, "tilt": "0.1deg"}
    whole = explain(atlas, cell)
    part = explain(atlas.drop_vars(["nutation_period", "amplification", "steps"]), cell)
    assert part.exactly
    assert math.isnan(part.stored["nutation_period"])
    lost = [line.split()[0] for line in whole.text.splitlines() if line not in part.text.splitlines()]
    assert lost == ["amplification", "nutation_period", "steps", "nutation_period", "linear"]
    assert cell_plot.figure(part).axes
    with refused("tilt_max"):
        explain(atlas.drop_vars("tilt_max"), cell)


def test_the_figure_has_the_extremes_and_the_limit():
    """The tilt in the figure spans the atlas's extremes, and the criterion's limit is visible."""
    found = explain(sweep.run(ROLLING), {"roll_rate": 2.5, "tilt": "1.5deg"})
    left, right = cell_plot.figure(found).axes
    curve, *lines = left.get_lines()
    drawn = sorted({round(float(line.get_ydata()[0]), 6) for line in lines})
    degrees = [math.degrees(found.stored[name]) for name in ("tilt_min", "tilt_max")]
    assert drawn == sorted(round(each, 6) for each in (*degrees, -5.0, 5.0))
    np.testing.assert_allclose([curve.get_ydata().min(), curve.get_ydata().max()], degrees, atol=1e-3)
    assert (left.get_xlabel(), right.get_xlabel()) == ("time (s)", "x (m)")


def test_run_from_repeats_a_run_from_the_file_alone(command, tmp_path):
    """`run --from` needs only the file and gives the same bits; changes are allowed, a second spec is not."""
    sweep.run_to_file(ROLLING, "a.nc")
    with sweep.open_atlas("a.nc") as atlas:
        before = atlas.load()
    status, _, err = command("run --from a.nc -o b.nc")
    assert (status, err.count("\n")) == (0, 1)
    assert_facts(err, "b.nc", "42 cells")
    with sweep.open_atlas("b.nc") as again:
        assert again.attrs["sweep_fingerprint"] == before.attrs["sweep_fingerprint"]
        for name in before.variables:
            assert again[name].values.tobytes() == before[name].values.tobytes(), name
        assert again.attrs["history"].endswith("eulerdisk run --from a.nc -o b.nc")
    assert command("run --from a.nc alpha=1 tilt=1deg -o c.nc")[0] == 0
    with sweep.open_atlas("c.nc") as changed:
        spec = ROLLING.replace(alpha=1.0, tilt="1deg")
        assert json.loads(changed.attrs["sweep_spec"]) == json.loads(spec.canonical())
        assert changed.attrs["history"].endswith("eulerdisk run --from a.nc alpha=1 tilt=1deg -o c.nc")
    for line, facts in [
        ("run rolling --from a.nc -o d.nc", ["SPEC", "rolling", "--from a.nc"]),
        ("run -o d.nc", ["SPEC", "--from", "eulerdisk run rolling"]),
        ("run --from missing.nc -o d.nc", ["missing.nc", "no such file"]),
        ("run --from a.nc rol_rate=2 -o d.nc", ["rol_rate", "roll_rate?"]),
    ]:
        status, out, err = command(line)
        assert (status, out) == (2, "")
        assert_facts(err, *facts)
    with netCDF4.Dataset("a.nc", "a") as file:
        file.kernel_hash = "0" * 64
    assert_facts(command("run --from a.nc -o e.nc")[2], "a.nc", "kernels")
