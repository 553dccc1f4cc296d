"""Runs of random starts and of tables of starts, from the inputs to the file and through all commands."""

import json
import os
import subprocess
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from messages import assert_facts, assert_in_order, missing, refused, row

import sweep
from sweep.engine.grid import starts_at
from sweep.errors import RequestError
from sweep.model.disk.tables import ENDINGS
from sweep.runs import array_jobs, forecast
from sweep.runs.folder import STARTS
from sweep.runs.journal import Journal
from sweep.runs.partial import write_partial
from sweep.runs.run import run_to_file

WORDS = "rolling roll_rate=uniform:2:4 tilt=normal:1deg:0.2deg samples=600 seed=7"
SPEC = sweep.SweepSpec.from_words(WORDS.split()[0], WORDS.split()[1:])
RANDOM = np.random.default_rng(5)
COLUMNS = {"roll_rate": RANDOM.uniform(2.0, 4.0, 600), "tilt": RANDOM.normal(0.02, 0.005, 600)}
TABLE = sweep.SweepSpec.preset("rolling").replace(starts=COLUMNS)
SPECS = {"random": SPEC, "table": TABLE}


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Give all files of a spec the same date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture(scope="module")
def references(tmp_path_factory):
    """Return the bytes of the files of undisturbed runs."""
    found, path = {}, tmp_path_factory.mktemp("reference") / "a.nc"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SOURCE_DATE_EPOCH", "1700000000")
        for kind, spec in SPECS.items():
            run_to_file(spec, path, overwrite=True)
            found[kind] = path.read_bytes()
    return found


@pytest.mark.usefixtures("two_threads")
def test_blocks_threads_and_jobs_change_no_byte(tmp_path, references):
    """However a run is divided, its file is the same, and nothing else is left."""
    path = tmp_path / "a.nc"
    for kind, spec in SPECS.items():
        for threads, block_cells in [(1, 7), (2, 100)]:
            run_to_file(spec, path, threads=threads, block_cells=block_cells, overwrite=True)
            assert path.read_bytes() == references[kind], (kind, threads, block_cells)
        journal = array_jobs.prepare(spec, path, block_cells=100, command="sweep.run_to_file", overwrite=True)
        assert not spec.starts or (journal.folder / STARTS).read_bytes() == spec.starts.to_bytes()
        for part in (3, 1, 2):
            array_jobs.compute_part(journal.folder, part, 3)
        array_jobs.assemble(journal.folder, overwrite=True)
        assert path.read_bytes() == references[kind], kind
        assert [each.name for each in tmp_path.iterdir()] == ["a.nc"]


def test_a_killed_run_goes_on(tmp_path, references):
    """After kill -9 halfway, the same command gives an undisturbed run's file and repeats no block."""
    script = (
        "import os, signal, sys\n"
        "from sweep import SweepSpec\n"
        "from sweep.runs.run import run_to_file\n"
        "def stop(status):\n"
        "    if status.done >= 300: os.kill(os.getpid(), signal.SIGKILL)\n"
        f"spec = SweepSpec.from_words('rolling', {WORDS.split()[1:]!r})\n"
        "run_to_file(spec, 'a.nc', block_cells=100, progress=stop)\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment, check=False)
    assert done.returncode == -9
    said = []
    run_to_file(SPEC, tmp_path / "a.nc", block_cells=100, say=said.append)
    assert any(each.startswith("resuming: ") for each in said)
    assert (tmp_path / "a.nc").read_bytes() == references["random"]


def test_other_starts_are_another_run(tmp_path, references):
    """A run folder with another seed or table is refused, naming the difference; the same one resumes."""
    path = tmp_path / "a.nc"
    other = TABLE.replace(starts={**COLUMNS, "tilt": COLUMNS["tilt"][::-1]})
    for spec, changed, facts in [
        (SPEC, SPEC.replace(seed=8), ["seed: 7 in the run", "8 now", "rm -r"]),
        (TABLE, other, ["starts: 600 starts of tilt, roll_rate", TABLE.starts.sha256[:12], "rm -r"]),
    ]:
        journal = array_jobs.prepare(spec, path, block_cells=100, command="sweep.run_to_file", overwrite=True)
        array_jobs.compute_part(journal.folder, 1, 2)
        with refused(*facts):
            run_to_file(changed, path, overwrite=True)
        said = []
        run_to_file(spec, path, say=said.append, overwrite=True)
        assert any(not missing(each, ["3 of 6 blocks", "3"]) for each in said)
    assert path.read_bytes() == references["table"]


@pytest.mark.slow_lane
def test_commands_on_random_starts(command):
    """Run, inspect, verify, explain, plot, export, repeat, compare: all work with a list."""
    assert command(f"run {WORDS} -o a.nc")[0] == 0
    status, text, _ = command("info a.nc")
    assert status == 0
    assert_facts(row(text, "starts"), "600", "random", "seed 7")
    assert_facts(row(text, "  tilt"), "normal", "1 deg +- 0.2 deg")
    assert_facts(row(text, "  roll_rate"), "uniform", "2 rad s-1", "4 rad s-1")
    with sweep.open_atlas("a.nc") as atlas:
        value, low, high = atlas.eulerdisk.unstable_share.percentages()
        assert_facts(text, f"{value} % of 600 starts", "95 %", f"{low} to {high} %")
        tilt = np.degrees(float(atlas.tilt[17]))
    status, text, _ = command("verify a.nc")
    assert status == 0
    assert_facts(text.splitlines()[-1], "verified", "600 of 600 cells")
    assert_facts(text, "normal:0.017453292519943295:0.003490658503988659")
    status, text, _ = command("explain a.nc start=17 --plot cell.png")
    assert status == 0
    assert_facts(row(text, "cell"), "start 17", "18 of 600")
    assert_facts(" ".join(text.split()), f"tilt {tilt:.10g} deg")
    assert row(text, "motion") == "motion eulerdisk simulate --from a.nc start=17 -o path.nc"
    assert command("simulate --from a.nc start=17 -o path.nc")[0] == 0
    status, text, _ = command("boundary a.nc")
    assert status == 0
    assert_facts(text, "no boundary", "list of starts")
    assert command("boundary a.nc --to json")[0] == 0
    done = command("plot a.nc -o a.png")
    assert done[0] == 0, done[2]
    assert command("export a.nc --to csv")[0] == 0
    head, first, *_ = Path("a.csv").read_text().splitlines()
    values = dict(zip(head.split(","), first.split(","), strict=True))
    with sweep.open_atlas("a.nc") as atlas, xr.open_dataset("path.nc") as motion:
        assert (float(values["tilt"]), float(values["roll_rate"])) == (atlas.tilt[0], atlas.roll_rate[0])
        # The start is printed and parsed again, which costs one rounding.
        assert float(motion.tilt[0]) == pytest.approx(float(atlas.tilt[17]), rel=1e-15)
    assert command("run --from a.nc -o b.nc")[0] == 0
    status, text, _ = command("compare b.nc a.nc")
    assert status == 0
    assert_facts(text.splitlines()[0], "identical", "600 cells", "20 variables")
    status, text, _ = command(f"plan {WORDS}")
    assert status == 0
    assert_facts(row(text, "cells"), "600", "random")
    found = json.loads(command("info a.nc --json")[1])
    assert found["listed"]["roll_rate"] == "uniform:2.0:4.0"
    share = found["unstable_share"]
    assert share["unstable"] + share["stable"] == 600
    assert share["interval"][0] < share["value"] < share["interval"][1]
    assert [axis["name"] for axis in found["axes"]] == ["start"]


def test_commands_on_a_table(command):
    """A CSV file gives the atlas, and the atlas alone gives the same atlas."""
    rows = "\n".join(
        f"{rate!r},{tilt!r}" for rate, tilt in zip(*(each.tolist() for each in COLUMNS.values()), strict=True)
    )
    for line in ("run", "prepare", "plan"):
        status, _, errors = command(f"{line} rolling --starts no.csv -o a.nc")
        assert status == 2
        assert_facts(errors, "no.csv", "No such file or directory")
    assert not list(Path().iterdir())
    Path("pushes.csv").write_text(f"roll_rate [rad/s],tilt [rad]\n{rows}\n")
    assert command("run rolling --starts pushes.csv -o a.nc")[0] == 0
    Path("pushes.csv").unlink()
    status, text, _ = command("info a.nc")
    assert status == 0
    assert_facts(row(text, "starts"), "600", "table", f"SHA-256 {TABLE.starts.sha256[:16]}")
    ends = [f"{end(COLUMNS['roll_rate']):.6g} rad s-1" for end in (np.min, np.max)]
    assert_in_order(row(text, "  roll_rate"), "table", *ends)
    assert_facts(text, "600 starts", "95 %")
    for line in ("verify a.nc", "explain a.nc start=599", "plot a.nc -o a.png", "run --from a.nc -o b.nc"):
        assert command(line)[0] == 0, line
    status, text, _ = command("compare b.nc a.nc")
    assert status == 0
    assert_facts(text.splitlines()[0], "identical", "600 cells", "20 variables")
    with sweep.open_atlas("a.nc") as atlas:
        assert atlas.eulerdisk.spec == TABLE
        assert np.array_equal(atlas.tilt, COLUMNS["tilt"])
        assert atlas.attrs["history"].endswith("eulerdisk run rolling starts=pushes.csv -o a.nc")
        assert "values" not in atlas.attrs["sweep_spec"]
        judged = sweep.reclassify(atlas.load(), "departure:20deg")
        assert judged.eulerdisk.spec == TABLE.replace(criterion="departure:20deg")
    assert command("run --from a.nc start=0:9 -o few.nc")[0] == 0
    assert_facts(command("info few.nc")[1], "10 of a table")


def test_a_stopped_run_whose_table_is_gone(command):
    """The same command lacks the starts to compare; commands that use the folder's copy continue."""
    np.savetxt(
        "pushes.csv", np.transpose([*COLUMNS.values()]), "%.17g", ",", header=",".join(COLUMNS), comments=""
    )
    line = "rolling --starts pushes.csv -o a.nc"
    assert command(f"prepare {line} --block-cells 100")[0] == 0
    Path("pushes.csv").unlink()
    status, _, errors = command(f"run {line}")
    assert status == 2
    assert_facts(errors, "pushes.csv", "No such file or directory")
    assert command("block --run a.nc.run --part 1/1")[0] == 0
    assert command("assemble a.nc.run")[0] == 0
    with sweep.open_atlas("a.nc") as atlas:
        assert atlas.eulerdisk.spec == TABLE


def test_a_damaged_table_in_the_folder(tmp_path):
    """No block is computed from damaged values; the message names the file and the remedy."""
    journal = array_jobs.prepare(TABLE, tmp_path / "a.nc")
    path = journal.folder / STARTS
    good = path.read_bytes()
    for damaged in (good[:-8], good[:-1] + b"\0", b"else" + good, b"", None):
        path.unlink() if damaged is None else path.write_bytes(damaged)
        with pytest.raises(RequestError) as caught:
            Journal.at(journal.folder)
        assert caught.value.where == str(path)
        assert_facts(str(caught.value), "starts")
        assert_facts(caught.value.hint, f"rm -r {journal.folder}")


def test_killed_before_the_manifest(tmp_path, references):
    """A run killed while creating its folder leaves files that the next run recognizes as its own."""
    folder = tmp_path / "a.nc.run"
    folder.mkdir()
    (folder / STARTS).write_bytes(b"half")
    run_to_file(TABLE, tmp_path / "a.nc")
    assert (tmp_path / "a.nc").read_bytes() == references["table"]


def test_a_partial_atlas(tmp_path):
    """Cells that are not computed still have their starts."""
    for kind, spec in SPECS.items():
        journal = array_jobs.prepare(spec, tmp_path / f"{kind}.nc", block_cells=100)
        array_jobs.compute_part(journal.folder, 1, 3)
        path = tmp_path / f"part-{kind}.nc"
        assert write_partial(journal.folder, path) == (200, 600)
        with sweep.open_atlas(path) as atlas:
            assert atlas.eulerdisk.spec == spec
            assert np.isfinite(atlas.tilt).all()
            assert atlas.eulerdisk.unstable_share.missing == 400


def test_refusals_of_commands(command):
    """Operations that a list does not support are refused in a sentence."""
    assert command("run rolling roll_rate=uniform:2:4 tilt=1deg samples=5 -o a.nc")[0] == 0
    assert command("explain a.nc tilt=1deg start=1")[0] == 0
    for line, facts in (
        ("explain a.nc", ["start", "start=2"]),
        ("explain a.nc roll_rate=3 start=1", ["roll_rate"]),
        ("explain a.nc start=7", ["start=7", "4"]),
        ("explain a.nc starts=7", ["starts", "start?"]),
        ("boundary a.nc --refine 1e-6", ["grid", "list of starts"]),
        ("plot a.nc -o x.png --regimes", ["--regimes"]),
        ("plot a.nc -o x.png --friction 1", ["friction"]),
    ):
        status, _, errors = command(line)
        assert status == 2, line
        assert_facts(errors, *facts)
    assert not Path("x.png").exists()


def test_lists_that_can_be_compared(command):
    """More starts of one seed include the fewer; another seed, a table and a grid have none in common."""
    random = "roll_rate=uniform:2:4 tilt=1deg"
    lists = {"few": "samples=30", "more": "samples=50", "other": "samples=30 seed=1"}
    for name, words in lists.items():
        assert command(f"run rolling {random} {words} -o {name}.nc")[0] == 0
    assert command("run rolling roll_rate=2:4:30 tilt=1deg -o grid.nc")[0] == 0
    assert_facts(command("compare more.nc few.nc")[2], "differ in start")
    status, text, _ = command("compare more.nc few.nc --common")
    assert status == 0
    assert_facts(text.splitlines()[0], "within", "30 common cells")
    assert_in_order(command("compare other.nc few.nc")[2], "seed", "1", "0")
    assert_facts(command("compare grid.nc few.nc")[2], "list of starts", "grid")
    status, _, errors = command("simulate --from grid.nc start=2 -o other.nc")
    assert status == 2
    assert_facts(errors, "start", "roll_rate")


def test_parts_of_a_table_are_compared(command):
    """With --common the shared starts are compared, and their values must be equal."""
    atlas = sweep.run(TABLE.replace(start="0:4:5"))
    for name, places in (("a", slice(0, 3)), ("b", slice(1, 5)), ("c", slice(4, 5))):
        sweep.save(atlas.isel(start=places).eulerdisk.atlas, f"{name}.nc")
    assert_facts(command("compare b.nc a.nc")[2], "grid")
    status, text, _ = command("compare b.nc a.nc --common")
    assert status == 0
    assert_facts(text.splitlines()[0], "within", "2 common cells")
    assert_facts(command("compare c.nc a.nc --common")[2], "common")
    # Start 1 differs.
    columns = {name: np.where(np.arange(600) == 1, values + 1e-7, values) for name, values in COLUMNS.items()}
    sweep.save(sweep.run(TABLE.replace(starts=columns).replace(start="1:4:4")), "other.nc")
    sweep.save(sweep.run(TABLE.replace(starts={"tilt": [0.1] * 5}, roll_rate=3)), "fewer.nc")
    for name in ("other", "fewer"):
        assert_facts(command(f"compare {name}.nc a.nc --common")[2], "starts")


def test_starts_outside_end_invalid(command):
    """Cells with a normal tilt beyond 90 degrees are invalid, have no verdict and are counted separately."""
    status, _, errors = command("run rolling roll_rate=3 tilt=normal:88deg:2deg samples=400 -o a.nc")
    with sweep.open_atlas("a.nc") as atlas:
        outside = np.abs(atlas.tilt.values) >= np.pi / 2
        assert 0 < outside.sum() < 200
        assert np.array_equal(atlas.ending.values == ENDINGS.code("invalid"), outside)
        share = atlas.eulerdisk.unstable_share
    assert (share.failed, share.decided) == (outside.sum(), 400 - outside.sum())
    assert status == 1
    assert_facts(errors, f"{outside.sum()} of 400 cells")
    assert_facts(command("info a.nc")[1], f"{outside.sum()} failed")


def test_a_changed_start_is_found(command):
    """For random starts `verify` names the variable and `compare` refuses; for tables all commands refuse."""
    assert command("run rolling roll_rate=uniform:2:4 tilt=normal:1deg:0.2deg samples=50 -o a.nc")[0] == 0
    assert command("run --from a.nc -o b.nc")[0] == 0
    Path("c.csv").write_text("tilt [deg],roll_rate\n1,2\n1,3\n")
    assert command("run rolling --starts c.csv -o c.nc")[0] == 0

    def changed(file, name, place, value):
        with netCDF4.Dataset(file, "a") as held:
            held.set_auto_maskandscale(False)
            before, held[name][place] = held[name][place], value
        return before

    for name, value in [("tilt", 0.02), ("start", 5000), ("roll_rate", np.nan)]:
        before = changed("a.nc", name, 49, value)
        status, text, errors = command("verify a.nc")
        assert status in (1, 2)
        assert name in (text + errors)
        if status == 1:
            assert_facts(text, "1 of 50", "start 49")
        status, text, errors = command("compare a.nc b.nc")
        assert status == 2
        assert_facts(errors, f"{name}")
        changed("a.nc", name, 49, before)
    for value in (0.021, np.nan):
        changed("c.nc", "tilt", 1, value)
        for line in ("info c.nc", "verify c.nc", "explain c.nc start=0", "run --from c.nc -o d.nc"):
            status, _, errors = command(line)
            assert status == 2
            assert_facts(errors, "tilt, roll_rate", "SHA-256")


def test_exact_method_and_another_criterion():
    """The exact reduction handles lists, and verdicts only need the stored extremes."""
    exact, stepped = sweep.run(SPEC.replace(method="exact")), sweep.run(SPEC)
    assert np.array_equal(exact.tilt, stepped.tilt)
    np.testing.assert_allclose(exact.tilt_max, stepped.tilt_max, rtol=0, atol=1e-8)
    changed = sweep.reclassify(stepped, "departure:20deg")
    fresh = sweep.run(SPEC.replace(criterion="departure:20deg"))
    assert np.array_equal(changed.stability, fresh.stability)
    assert changed.eulerdisk.spec == fresh.eulerdisk.spec


def test_in_the_file(tmp_path):
    """By CF the listed parameters are auxiliary coordinates of all cell variables, without a fill value."""
    run_to_file(SPEC.replace(samples=20), tmp_path / "a.nc")
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        assert file["start"].dtype == np.int32
        assert file["tilt"].dimensions == ("start",)
        assert "_FillValue" not in file["tilt"].ncattrs()
        assert file["peak_tilt"].coordinates.split()[:2] == ["tilt", "roll_rate"]
        assert file["peak_tilt"].cell_methods == "start: point"
        assert not hasattr(file["tilt"], "coordinates")
    with sweep.open_atlas(tmp_path / "a.nc") as stored:
        assert {"start", "tilt", "roll_rate", "alpha"} <= set(stored.coords)
        made = sweep.run(SPEC.replace(samples=20))
        # The file contains everything needed to recompute it.
        assert stored.eulerdisk.spec == made.eulerdisk.spec
        for name in stored.variables:
            assert np.array_equal(stored[name], made[name], equal_nan=True), name
            assert stored[name].dtype == made[name].dtype, name


def test_the_next_start_is_no_neighbour(command):
    """On a grid an ending may flip next to a cell that has it; in a list the next start proves nothing."""
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
    assert (status, text[:9]) == (1, "DIFFERENT")
    with refused("starts", "list"):
        sweep.run(SPEC.replace(samples=20)).eulerdisk.interp(start=3.5)


def test_many_samples_are_cheap_to_ask_for():
    """A request for 2e9 starts is accepted, and its last starts are drawn without creating the others."""
    spec = SPEC.replace(samples=2e9)
    some = np.array([5, 2_000_000_000 - 1])
    starts = starts_at(spec, some)
    assert np.array_equal(starts["tilt"][:1], starts_at(SPEC, some[:1])["tilt"])
    assert np.isfinite(starts["tilt"]).all()
    # The first starts are as good as any, and they are drawn together.
    assert forecast.coarse(spec, 1000).start.array().tolist() == list(range(1000))


@pytest.mark.slow_lane
def test_a_selection_is_a_list(command):
    """Some starts form an atlas with their original numbers: saved, verified, compared, repeated."""
    few = {"roll_rate": np.linspace(2.0, 4.0, 60), "tilt": np.linspace(0.01, 0.03, 60)}
    for spec in (SPEC.replace(samples=60), SPEC.replace(starts=few)):
        run_to_file(spec, "a.nc", overwrite=True)
        with sweep.open_atlas("a.nc") as atlas:
            some = atlas.isel(start=[3, 17, 40]).eulerdisk.atlas.load()
            assert some.eulerdisk.spec.start.array().tolist() == [3, 17, 40]
            sweep.save(some, "some.nc", overwrite=True)
            many = atlas.isel(start=atlas.stability.values == 2).eulerdisk.atlas
            assert many.eulerdisk.unstable_share.stable == 0
        assert command("verify some.nc")[0] == 0
        assert command("run --from some.nc -o again.nc --overwrite")[0] == 0
        status, text, _ = command("compare again.nc some.nc")
        assert status == 0
        assert_facts(text.splitlines()[0], "identical", "3 cells", "20 variables")
        assert command("explain some.nc start=17")[0] == 0
        assert command(f"plot a.nc start=0:20 -o part{spec.seed}.png")[0] == 0


def test_one_start_of_a_list_is_a_cell(tmp_path):
    """It has no dimension and no number; its parameters are those of the start."""
    atlas = sweep.run(SPEC.replace(samples=20))
    one = atlas.isel(start=5).eulerdisk.atlas
    assert one.eulerdisk.spec.axes == ()
    assert one.eulerdisk.spec.tilt == float(atlas.tilt[5])
    assert "start" not in one.variables
    sweep.save(one, tmp_path / "one.nc")
    with sweep.open_atlas(tmp_path / "one.nc") as stored:
        assert int((sweep.verify(stored).audit != 1).sum()) == 0


def test_a_steady_rate_follows_from_a_table():
    """For circling, the computed rate is stored next to the columns."""
    spec = sweep.SweepSpec.preset("circling").replace(
        starts={"tilt [deg]": [1.0, 5.0], "precession_rate": [1.0, 3.0]}
    )
    atlas = sweep.run(spec)
    assert atlas.roll_rate.dims == ("start",)
    assert "roll_rate" in atlas.data_vars
    with refused("precession_rate", "roll_rate=steady"):
        spec.replace(starts={"tilt": [0.1], "precession_rate": [0.0]})
