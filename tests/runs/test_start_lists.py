"""Runs of random starts, from the words to the file and through every command: one atlas like any other."""

import json
import os
import subprocess
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

import sweep
from sweep.engine.grid import starts_at
from sweep.errors import RequestError
from sweep.model.disk.tables import ENDINGS
from sweep.runs import array_jobs, forecast
from sweep.runs.run import run_to_file

WORDS = "rolling roll_rate=uniform:2:4 tilt=normal:1deg:0.2deg samples=3000 seed=7"
SPEC = sweep.SweepSpec.from_words(WORDS.split()[0], WORDS.split()[1:])


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Files of one spec bear one date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture(scope="module")
def reference(tmp_path_factory):
    """Return the bytes of the file of an undisturbed run."""
    path = tmp_path_factory.mktemp("reference") / "a.nc"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", "1700000000")
        run_to_file(SPEC, path)
    return path.read_bytes()


@pytest.mark.parametrize(("threads", "block_cells"), [(1, 1), (1, 7), (2, 1000), (1, 3000)])
def test_blocks_and_threads_change_no_byte(tmp_path, reference, threads, block_cells):
    """However a run is cut and shared out, its file is the same."""
    cut = 40 if block_cells == 1 else SPEC.samples
    spec = SPEC if cut == SPEC.samples else SPEC.replace(samples=cut)
    run_to_file(spec, tmp_path / "a.nc", threads=threads, block_cells=block_cells)
    if spec is SPEC:
        assert (tmp_path / "a.nc").read_bytes() == reference
    else:
        with sweep.open_atlas(tmp_path / "a.nc") as atlas:
            whole = sweep.run(SPEC).isel(start=slice(0, cut))
            assert np.array_equal(atlas.peak_tilt, whole.peak_tilt)
            assert np.array_equal(atlas.tilt, whole.tilt)


def test_a_killed_run_goes_on(tmp_path, reference):
    """Kill -9 in the middle, then the same command: the file of an undisturbed run, and no block computed twice."""
    script = (
        "import os, signal, sys\n"
        "from sweep import SweepSpec\n"
        "from sweep.runs.run import run_to_file\n"
        "def stop(status):\n"
        "    if status.done >= 1500: os.kill(os.getpid(), signal.SIGKILL)\n"
        f"spec = SweepSpec.from_words('rolling', {WORDS.split()[1:]!r})\n"
        "run_to_file(spec, 'a.nc', block_cells=500, progress=stop)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment, check=False)
    assert done.returncode == -9
    said = []
    run_to_file(SPEC, tmp_path / "a.nc", block_cells=500, say=said.append)
    assert any(each.startswith("going on: ") for each in said)
    assert (tmp_path / "a.nc").read_bytes() == reference


def test_other_random_starts_are_another_run(tmp_path):
    """A folder of another seed is refused, and the words that differ are named."""
    journal = array_jobs.prepare(SPEC, tmp_path / "a.nc")
    assert journal.spec == SPEC
    with pytest.raises(RequestError, match="seed: 7 there, 8 here"):
        run_to_file(SPEC.replace(seed=8), tmp_path / "a.nc")


def test_commands(command):
    """Run, look, verify, explain, draw, export, repeat, compare: what each says of a list."""
    assert command(f"run {WORDS} -o a.nc")[0] == 0
    status, text, _ = command("info a.nc")
    assert status == 0
    assert "starts      3000 random starts, seed 7" in text
    assert (
        "  tilt              normal, 1 deg +- 0.2 deg\n  roll_rate         uniform, 2 rad s-1 to 4 rad s-1"
        in text
    )
    with sweep.open_atlas("a.nc") as atlas:
        share = atlas.eulerdisk.unstable_share
        value, low, high = share.percentages()
        assert (
            f"unstable    {value} % of 3000 starts with a verdict; 95 % interval {low} to {high} % (Wilson)"
            in text
        )
        tilt = np.degrees(float(atlas.tilt[17]))
    status, text, _ = command("verify a.nc")
    assert (status, text.splitlines()[-1][:31]) == (0, "verified: 3000 of 3000 cells wi")
    assert "normal:0.017453292519943295:0.003490658503988659 of the spec" in text
    status, text, _ = command("explain a.nc start=17 --plot cell.png")
    assert status == 0
    assert "start 17 (18 of 3000)" in text
    assert f"tilt {tilt:.10g} deg" in text
    status, text, _ = command("boundary a.nc")
    assert (status, text.startswith("This atlas has no boundary: a list of starts")) == (0, True)
    done = command("plot a.nc -o a.png")
    assert done[0] == 0, done[2]
    assert command("export a.nc --to csv")[0] == 0
    head, first, *_ = Path("a.csv").read_text().splitlines()
    row = dict(zip(head.split(","), first.split(","), strict=True))
    with sweep.open_atlas("a.nc") as atlas:
        assert (float(row["tilt"]), float(row["roll_rate"])) == (atlas.tilt[0], atlas.roll_rate[0])
    assert command("run --from a.nc -o b.nc")[0] == 0
    status, text, _ = command("compare b.nc a.nc")
    assert (status, text.splitlines()[0]) == (0, "identical: 3000 cells, all 20 variables bit for bit")
    status, text, _ = command(f"plan {WORDS}")
    assert (status, text.splitlines()[0]) == (0, "cells    3000 (random starts)")


def test_refusals_of_commands(command):
    """What a list has not is refused in a sentence."""
    assert command("run rolling roll_rate=uniform:2:4 tilt=1deg samples=5 -o a.nc")[0] == 0
    for line, says in (
        ("explain a.nc", "none was given for start. Add start=2"),
        ("explain a.nc tilt=1deg start=1", ""),
        ("explain a.nc roll_rate=3 start=1", "roll_rate is another number in every start"),
        ("explain a.nc start=7", "outside the atlas"),
        ("explain a.nc starts=7", "Did you mean start?"),
        ("boundary a.nc --refine 1e-6", "no rows in which a boundary is sought"),
        ("plot a.nc -o x.png --regimes", "--regimes draws maps"),
        ("plot a.nc -o x.png --friction 1", "--friction hatches cells of a map"),
    ):
        status, _, errors = command(line)
        assert status == (2 if says else 0)
        assert says in errors
    assert not Path("x.png").exists()


def test_lists_that_can_be_compared(command):
    """More starts of one seed hold the fewer ones; of another seed, or a grid, nothing is common."""
    random = "roll_rate=uniform:2:4 tilt=1deg"
    lists = {"few": "samples=30", "more": "samples=50", "other": "samples=30 seed=1"}
    for name, words in lists.items():
        assert command(f"run rolling {random} {words} -o {name}.nc")[0] == 0
    assert command("run rolling roll_rate=2:4:30 tilt=1deg -o grid.nc")[0] == 0
    assert "they differ in start" in command("compare more.nc few.nc")[2]
    status, text, _ = command("compare more.nc few.nc --common")
    assert (status, text.splitlines()[0]) == (0, "within tolerance: 30 common cells")
    assert "they differ in seed (1 and 0)" in command("compare other.nc few.nc")[2]
    assert "A list of starts and a grid have no cells in common" in command("compare grid.nc few.nc")[2]


def test_starts_outside_end_invalid(command):
    """A normal tilt reaches beyond 90 degrees: these cells are invalid, without verdict, and counted apart."""
    status, _, errors = command("run rolling roll_rate=3 tilt=normal:88deg:2deg samples=400 -o a.nc")
    with sweep.open_atlas("a.nc") as atlas:
        outside = np.abs(atlas.tilt.values) >= np.pi / 2
        assert 0 < outside.sum() < 200
        assert np.array_equal(atlas.ending.values == ENDINGS.code("invalid"), outside)
        share = atlas.eulerdisk.unstable_share
    assert share.failed == outside.sum()
    assert share.decided == 400 - outside.sum()
    assert status == 1
    assert f"{outside.sum()} of 400 cells could not be computed" in errors
    assert f"left out: {outside.sum()} failed" in command("info a.nc")[1]


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [("tilt", 0.02, "tilt"), ("start", 5000, "start"), ("roll_rate", np.nan, "roll_rate")],
)
def test_a_changed_start_is_found(command, name, value, says):
    """Verify names the variable and the start; compare refuses the file."""
    assert command("run rolling roll_rate=uniform:2:4 tilt=normal:1deg:0.2deg samples=50 -o a.nc")[0] == 0
    assert command("run --from a.nc -o b.nc")[0] == 0
    with netCDF4.Dataset("a.nc", "a") as file:
        file.set_auto_maskandscale(False)
        file[name][49] = value
    status, text, errors = command("verify a.nc")
    assert status in (1, 2)
    assert says in (text + errors)
    if status == 1:
        assert "wrong in 1 of 50: start 49" in text
    status, text, errors = command("compare a.nc b.nc")
    assert status == 2
    assert f"The coordinate {says} has other values" in errors


def test_exact_method_and_another_criterion():
    """The exact reduction serves lists, and verdicts follow from the stored extremes alone."""
    exact, stepped = sweep.run(SPEC.replace(method="exact")), sweep.run(SPEC)
    assert np.array_equal(exact.tilt, stepped.tilt)
    np.testing.assert_allclose(exact.tilt_max, stepped.tilt_max, rtol=0, atol=1e-8)
    changed = sweep.reclassify(stepped, "departure:20deg")
    fresh = sweep.run(SPEC.replace(criterion="departure:20deg"))
    assert np.array_equal(changed.stability, fresh.stability)
    assert changed.eulerdisk.spec == fresh.eulerdisk.spec


def test_in_the_file(tmp_path):
    """CF: the listed parameters are auxiliary coordinates of every cell variable, without fill value."""
    run_to_file(SPEC.replace(samples=20), tmp_path / "a.nc")
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        assert file["start"].dtype == np.int32
        assert file["tilt"].dimensions == ("start",)
        assert "_FillValue" not in file["tilt"].ncattrs()
        assert file["peak_tilt"].coordinates.split()[:2] == ["tilt", "roll_rate"]
        assert file["peak_tilt"].cell_methods == "start: point"
        assert not hasattr(file["tilt"], "coordinates")
    with sweep.open_atlas(tmp_path / "a.nc") as atlas:
        assert {"start", "tilt", "roll_rate", "alpha"} <= set(atlas.coords)
        # the file says all that is needed to make it again
        assert atlas.eulerdisk.spec == SPEC.replace(samples=20)


def test_the_next_start_is_no_neighbour(command):
    """On a grid an ending may flip beside a cell that has it; of a list the next start says nothing."""
    for name in ("a", "b"):
        words = "rolling tilt=normal:40deg:30deg roll_rate=1 samples=60"
        assert command(f"run {words} --max-failed 100 -o {name}.nc")[0] == 0
    with netCDF4.Dataset("b.nc", "a") as file:
        file.set_auto_maskandscale(False)
        codes = file["ending"][:]
        bounded, fell = ENDINGS.code("bounded"), ENDINGS.code("fell")
        place = np.flatnonzero((codes[:-1] == bounded) & (codes[1:] == fell))[0]
        file["ending"][place] = fell
    status, text, _ = command("compare b.nc a.nc")
    assert status == 1
    assert text.startswith("DIFFERENT")


def test_many_samples_are_cheap_to_ask_for():
    """A request for 2e9 starts is read, and its last starts are drawn, without making them all."""
    spec = SPEC.replace(samples=2e9)
    some = np.array([5, 2_000_000_000 - 1])
    starts = starts_at(spec, some)
    assert np.array_equal(starts["tilt"][:1], starts_at(SPEC, some[:1])["tilt"])
    assert np.isfinite(starts["tilt"]).all()
    assert forecast.coarse(spec, 1000).size == 1000
    # the first ones are as good as others, and drawn together
    assert forecast.coarse(spec, 1000).start.array().tolist() == list(range(1000))


@pytest.mark.parametrize(
    "spec",
    [
        SPEC.replace(samples=60),
        SPEC.replace(starts={"roll_rate": np.linspace(2.0, 4.0, 60), "tilt": np.linspace(0.01, 0.03, 60)}),
    ],
    ids=["random", "table"],
)
def test_a_selection_is_a_list(command, spec):
    """Some starts are an atlas of their own, which keep their numbers: saved, verified, compared, repeated."""
    run_to_file(spec, "a.nc")
    with sweep.open_atlas("a.nc") as atlas:
        some = atlas.isel(start=[3, 17, 40]).eulerdisk.atlas.load()
        assert some.eulerdisk.spec.start.array().tolist() == [3, 17, 40]
        sweep.save(some, "some.nc")
        many = atlas.isel(start=atlas.stability.values == 2).eulerdisk.atlas
        assert many.eulerdisk.unstable_share.stable == 0
    assert command("verify some.nc")[0] == 0
    assert command("run --from some.nc -o again.nc")[0] == 0
    status, text, _ = command("compare again.nc some.nc")
    assert (status, text.splitlines()[0]) == (0, "identical: 3 cells, all 20 variables bit for bit")
    assert command("explain some.nc start=17")[0] == 0
    assert command("plot a.nc start=0:20 -o part.png")[0] == 0


def test_one_start_of_a_list_is_a_cell(tmp_path):
    """It has no dimension and no number, and its parameters are those of the start."""
    atlas = sweep.run(SPEC.replace(samples=20))
    one = atlas.isel(start=5).eulerdisk.atlas
    assert one.eulerdisk.spec.axes == ()
    assert one.eulerdisk.spec.tilt == float(atlas.tilt[5])
    assert "start" not in one.variables
    sweep.save(one, tmp_path / "one.nc")
    with sweep.open_atlas(tmp_path / "one.nc") as stored:
        assert int((sweep.verify(stored).audit != 1).sum()) == 0


def test_between_starts_nothing_is_known():
    """Interpolation is refused: the next start of a list may lie anywhere."""
    with pytest.raises(RequestError, match="Between the starts of a list nothing is known"):
        sweep.run(SPEC.replace(samples=20)).eulerdisk.interp(start=3.5)


def test_from_a_start_to_its_motion(command):
    """Explain ends with the command that follows the start, and the command does."""
    assert command(f"run {WORDS.replace('3000', '20')} -o a.nc")[0] == 0
    line = command("explain a.nc start=7")[1].splitlines()[-1]
    assert line.split(maxsplit=1)[1] == "eulerdisk simulate --from a.nc start=7 -o path.nc"
    assert command("simulate --from a.nc start=7 -o path.nc")[0] == 0
    with sweep.open_atlas("a.nc") as atlas, xr.open_dataset("path.nc") as motion:
        assert float(motion.tilt[0]) == float(atlas.tilt[7])
    assert command("run rolling roll_rate=2:4:3 tilt=1deg -o grid.nc")[0] == 0
    status, _, errors = command("simulate --from grid.nc start=2 -o other.nc")
    assert (status, "start is no word of this request" in errors) == (2, True)


def test_lists_as_json(command):
    """Info --json has the distributions, the share and its interval."""
    assert command(f"run {WORDS.replace('3000', '50')} -o a.nc")[0] == 0
    found = json.loads(command("info a.nc --json")[1])
    assert found["listed"]["roll_rate"] == "uniform:2.0:4.0"
    share = found["unstable_share"]
    assert share["unstable"] + share["stable"] == 50
    assert share["interval"][0] < share["value"] < share["interval"][1]
    assert [axis["name"] for axis in found["axes"]] == ["start"]
    assert command("boundary a.nc --to json")[0] == 0
