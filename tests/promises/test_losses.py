"""The lossy disk in sweeps: bits, files, every command, and what `verify` finds."""

from pathlib import Path

import lossy_runner
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from messages import assert_facts, row

import sweep
from sweep.checks.verify import findings, verify
from sweep.engine.compute import arithmetic_hash
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.request.spec import SweepSpec

pytestmark = pytest.mark.compiled

TOY = "toy inclination=5deg:60deg:7 precession_rate=30:80:6 duration=40s criterion=aloft:20s"
COIN = "coin roll_rate=15:60:10 rolling_friction=1um:0.2mm:6:log duration=4s"
#: Every law and every kind of friction, with kernels that other tests also need.
LAWS = {
    "contour": "contour_friction=0,20um air_law=bildsten air_viscosity=2e-5 air_density=1.2 mass=7g",
    "rolling": "rolling_friction=0,20um",
    "all": "contour_friction=20um contour_damping=0,1e-7 rolling_friction=9um pivoting_friction=9um friction=0.3 "
    "air_law=moffatt air_viscosity=1e-4 mass=7g",
}
GRID = "radius=12mm tilt=10deg:85deg:6 precession_rate=20:90:5 roll_rate=wobble duration=3s criterion=departure:30deg"


def spec_of(words):
    """Return the spec of some words; the first may be a preset."""
    first, *others = words.split()
    if "=" in first:
        return SweepSpec(**dict(word.split("=", 1) for word in (first, *others)))
    return SweepSpec.from_words(first, others)


def bits(atlas):
    """Return the bytes of every variable of an atlas."""
    return {name: variable.values.tobytes() for name, variable in atlas.variables.items()}


@pytest.mark.usefixtures("two_threads")
@pytest.mark.parametrize("law", LAWS)
def test_bits_depend_on_the_cell_alone(law):
    """Threads and blocks change no bit; a part of a grid has the same bits as the whole."""
    spec = spec_of(f"{GRID} {LAWS[law]}")
    whole = sweep.run(spec, threads=1)
    assert not np.isin(whole.ending.values, LOSSY_DISK.endings.codes("missing")).any()
    for threads, cells in ((2, 7), (1, 23)):
        assert bits(sweep.run(spec, threads=threads, block_cells=cells)) == bits(whole)
    part = sweep.run(spec.replace(tilt=spec.tilt.at([1, 4]).tolist()))
    for name in LOSSY_DISK.variables:
        np.testing.assert_array_equal(part[name].values, whole[name].isel(tilt=[1, 4]).values)


@pytest.mark.parametrize("law", LAWS)
def test_the_criterion_changes_the_verdict_and_the_breach_alone(law):
    """All other measures are bit-identical, so an atlas can be judged by another criterion."""
    spec = spec_of(f"{GRID} {LAWS[law]}")
    expected = sweep.run(spec)
    for criterion in ("departure:5deg", "amplification:1.2", "aloft:2s", "end_tilt > 45deg"):
        found = sweep.run(spec.replace(criterion=criterion))
        for name in (*LOSSY_DISK.measures, *LOSSY_DISK.counts):
            if name != "breach_time":
                np.testing.assert_array_equal(found[name].values, expected[name].values, err_msg=name)
        judged = sweep.reclassify(expected, criterion)
        np.testing.assert_array_equal(judged.stability.values, found.stability.values)
        assert "breach_time" not in judged


@pytest.mark.slow_lane
@pytest.mark.parametrize("law", LAWS)
def test_an_atlas_is_verified(law):
    """Every resolved cell is self-consistent, and the sample matches its second computation."""
    found = findings(verify(sweep.run(spec_of(f"{GRID} {LAWS[law]}"))))
    assert found.passed, (list(found.wrong), found.counts)
    assert_facts(found.sampled, f"{found.cells} cells", "seed")


@pytest.mark.slow_lane
def test_a_wrong_value_is_found():
    """If one value in one cell changes, `verify` names its variable."""
    atlas = sweep.run(spec_of(f"{GRID} {LAWS['contour']}"))
    place = tuple(np.argwhere(atlas.ending.values == LOSSY_DISK.endings.code("flat"))[0])
    for name, change in {
        "end_time": 1e-3, "tilt_min": -1e-3, "path_length": 1e-2, "contour_loss": 1e-4, "largest_loss": 1,
        "breach_time": 1e-2, "ending": 1, "peak_tilt": 1e-6,
    }.items():  # fmt: skip
        wrong = atlas.copy(deep=True)
        if not np.isfinite(wrong[name].values[place]):
            continue
        wrong[name].values[place] += change
        assert name in [each.name for each in findings(verify(wrong)).wrong], name


def test_cells_are_held_against_themselves_where_the_kernels_are_others(monkeypatch):
    """If other code computed the atlas, ledger, ending and verdict find errors outside the sample."""
    monkeypatch.setattr("sweep.model.lossy_disk.sample.CELLS", 0)
    atlas = sweep.run(spec_of(f"{GRID} {LAWS['contour']}")).assign_attrs(kernel_hash="0" * 64)
    found = findings(verify(atlas, seed=1))
    assert (found.wrong, found.disagreeing, found.compared) == ([], 0, 0)
    place = tuple(np.argwhere(atlas.ending.values == LOSSY_DISK.endings.code("flat"))[0])
    for name, change in {
        "contour_loss": 10.0,
        "end_tilt": 1e-3,
        "end_time": 10.0,
        "tilt_max": -0.1,
        "stability": -1,
    }.items():
        wrong = atlas.copy(deep=True)
        wrong[name].values[place] += change
        assert name in [each.name for each in findings(verify(wrong)).wrong], name


def test_what_the_ledger_leaves():
    """The initial energy minus all losses is the height of the center at the end."""
    atlas = sweep.run(spec_of(f"{GRID} tilt_rate=3 {LAWS['contour']}"))
    start = {name: atlas[name] for name in ("tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha")}
    leaning, turning = start["tilt_rate"], start["precession_rate"] * np.cos(start["tilt"])
    rolling = start["roll_rate"] + start["precession_rate"] * np.sin(start["tilt"])
    of_centre = leaning**2 + rolling**2
    about_it = start["alpha"] * (rolling**2 + 0.5 * (leaning**2 + turning**2))
    energy = np.cos(start["tilt"]) + 0.5 * atlas.radius / atlas.gravity * (of_centre + about_it)
    lost = sum(
        atlas[name] for name in atlas.data_vars if str(name).endswith("_loss") and name != "largest_loss"
    )
    left = energy - lost - np.cos(atlas.end_tilt)
    found = verify(atlas).ledger_difference
    assert np.isfinite(found).sum() > 10
    np.testing.assert_allclose(found, left.transpose(*found.dims), rtol=0.0, atol=1e-10)


@pytest.mark.slow_lane
def test_a_second_computation_finds_what_the_ledger_cannot_see():
    """With other code, a sample with half the step checks measures that no energy balance covers."""
    atlas = sweep.run(spec_of(f"{GRID} {LAWS['contour']}")).assign_attrs(kernel_hash="0" * 64)
    assert findings(verify(atlas, seed=1)).passed
    wrong = atlas.copy(deep=True)
    names = ["heading_turned", "path_length", "breach_time"]
    for name in names:
        wrong[name].values[np.isfinite(wrong[name].values)] *= 1.001
    assert {each.name for each in findings(verify(wrong, seed=1)).wrong} >= {*names}


@pytest.mark.slow_lane
def test_verify_says_that_it_is_a_sample(command):
    """The report and its last line state the number of recomputed cells and the seed, which repeats it."""
    assert command(f"run {TOY} -o a.nc")[0] == 0
    status, out, _ = command("verify a.nc --seed 7 --write audit.nc")
    assert status == 0, out
    assert_facts(out, "42 cells", "7")
    assert_facts(out.splitlines()[-1], "sample")
    with sweep.open_atlas("a.nc") as atlas:
        first, again = verify(atlas, seed=3), verify(atlas, seed=3)
        assert first.attrs["audit_sample"] == again.attrs["audit_sample"]
        np.testing.assert_array_equal(first.time_difference, again.time_difference)


@pytest.mark.slow_lane
def test_every_command_speaks_of_losses(command):
    """All commands handle a lossy atlas; what the model lacks is refused in a sentence."""
    assert command(f"plan {COIN}")[0] == 0
    assert command(f"run {COIN} -o coin.nc")[0] == 0
    out = command("info coin.nc")[1]
    assert_facts(out, "rolling friction", "end time")
    out = command("boundary coin.nc")[1]
    assert "predicted_roll_rate" in out
    status, out, _ = command("explain coin.nc roll_rate=20 rolling_friction=10um")
    assert status == 0, out
    assert_facts(" ".join(out.split()), "friction unlimited", "largest_loss", "bit for bit")
    assert_facts(row(out, "theory"), "roll rate", "16.7717 rad s-1", "8.01251 s")
    assert_facts(row(out, "boundary"), "17.5 rad s-1", "18.6313 rad s-1", "losses", "16.7717 rad s-1")
    assert command("compare coin.nc coin.nc")[0] == 0
    assert command("export coin.nc --to csv -o coin.csv")[0] == 0
    assert "rolling_loss" in Path("coin.csv").read_text().splitlines()[0]
    for name in ("parquet", "zarr"):
        assert command(f"export coin.nc --to {name} -o coin.{name}")[0] == 0
    tables = pd.read_parquet("coin.parquet"), pd.read_csv("coin.csv")
    np.testing.assert_allclose(*(each["end_time"] for each in tables), rtol=1e-14)
    with sweep.open_atlas("coin.nc") as atlas, xr.open_zarr("coin.zarr") as copy:
        xr.testing.assert_equal(copy.load(), atlas.load())
    assert command("plot coin.nc -o coin.png")[0] == 0
    assert command("plot coin.nc --losses -o losses.png")[0] == 0
    assert command("run --from coin.nc -o again.nc")[0] == 0
    assert command("compare again.nc coin.nc --exact")[0] == 0
    assert command("run rolling roll_rate=2:4:5 tilt=1deg,2deg -o disk.nc")[0] == 0
    for line, facts in {
        "plot coin.nc --regimes -o r.png": ["lossy_disk", "--regimes"],
        "plot coin.nc --friction 0.3 -o f.png": ["lossy_disk", "contact forces", "friction=0.3"],
        "compare coin.nc disk.nc": ["lossy_disk and disk"],
        "run coin method=exact -o e.nc": ["method", "exact", "rk4"],
        "run rolling rolling_friction=-1um -o n.nc": ["rolling_friction", ">= 0"],
    }.items():
        status, out, err = command(line)
        assert (status, out, err.count("\n")) == (2, "", 1), line
        assert_facts(err, *facts)
    for name in ("r.png", "f.png", "e.nc", "n.nc"):
        assert not Path(name).exists()


def test_a_row_without_a_line_of_theory_is_said_to_have_none(command):
    """A wobble about a resting center has no critical rate: one line says so, without an estimate."""
    assert command(f"run {TOY} -o toy.nc")[0] == 0
    said = row(command("explain toy.nc inclination=30deg precession_rate=50")[1], "boundary")
    assert_facts(said, "theory", "no line", "inclination")
    assert "limit" not in said


def test_an_axis_with_a_zero_runs_with_losses_and_tends_to_the_disk_without():
    """Cells without a loss have the extremes of the lossless disk, within the stated errors."""
    words = {"tilt": "5deg:30deg:4", "roll_rate": "3.5:6:4", "duration": "60s"}
    with lossy_runner.general_kernels():
        lossy = sweep.run(SweepSpec(**words, contour_friction="0,1um"))
    plain = sweep.run(SweepSpec(**words))
    assert "model" not in plain.eulerdisk.spec.canonical()
    both = plain.ending.values == 1
    assert both.any()
    for name in ("tilt_min", "tilt_max"):
        apart = np.abs(lossy[name].isel(contour_friction=0).values - plain[name].values)
        assert apart[both].max() < 1e-7, name
    assert not lossy.contour_loss.isel(contour_friction=0).values.any()


def test_the_file_is_the_atlas(tmp_path):
    """A file returns all variables, attributes and the spec; unneeded inputs are only in the spec."""
    spec = spec_of(COIN)
    made = sweep.run(spec)
    sweep.save(made, tmp_path / "a.nc")
    with sweep.open_atlas(tmp_path / "a.nc") as found:
        assert found.eulerdisk.spec == spec
        assert found.attrs["kernel_hash"] == arithmetic_hash(spec)
        assert "friction" not in found.variables
        assert bits(found.load()) == bits(made)
        assert found.largest_loss.attrs["flag_meanings"].split()[0] == "none"


@pytest.mark.slow_lane
@pytest.mark.parametrize("kind", ["random", "table"])
def test_lists_of_starts(kind, tmp_path):
    """Arms may be random or from a table; each start keeps its own."""
    words = {
        "tilt": "70deg",
        "precession_rate": 30.0,
        "roll_rate": "wobble",
        "radius": "37mm",
        "duration": "5s",
    }
    if kind == "random":
        spec = SweepSpec(**words, contour_friction="loguniform:1um:100um", samples=20)
    else:
        (tmp_path / "arms.csv").write_text("contour_friction [mm]\n0.01\n0.02\n0\n")
        spec = SweepSpec(**words, starts=tmp_path / "arms.csv")
    atlas = sweep.run(spec)
    assert atlas.eulerdisk.spec.model is LOSSY_DISK
    assert findings(verify(atlas)).passed
