"""Prepared runs, their parts and their assembly; looks at what is not finished; plans."""

import re
import shlex
import subprocess
import sys
import threading

import numpy as np
import pytest

from sweep import driving, estimate, peek
from sweep.calibrate import coarse
from sweep.cli import main
from sweep.errors import StoppedError
from sweep.running import run_to_file
from sweep.spec import SweepSpec
from sweep.store import open_atlas

WORDS = "rolling roll_rate=2:4:9 tilt=0.1deg,1deg"
SPEC = SweepSpec.from_words("rolling", WORDS.split()[1:])


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Files of one spec bear one date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """Return a function that runs a command line in an empty folder and returns status, output and messages."""
    monkeypatch.chdir(tmp_path)

    def run(line):
        monkeypatch.setattr(sys, "argv", ["eulerdisk", *shlex.split(line)])
        with pytest.raises(SystemExit) as end:
            main()
        return end.value.code, *capsys.readouterr()

    return run


def stopped_after(path, count, **how):
    """Begin a run of four blocks and let it compute so many of them."""
    asked = [0]

    def stopping():
        # the thread that computes asks before every block
        asked[0] += threading.current_thread() is not threading.main_thread()
        return asked[0] > count

    with pytest.raises(StoppedError):
        run_to_file(SPEC, path, block_cells=5, stopping=stopping, **how)
    assert len(list(path.parent.glob(f"{path.name}.run/blocks/*.npz"))) == count


def test_parts_make_the_file_of_a_run(command, tmp_path):
    """Prepared, computed in three parts in any order, and assembled: the bytes are those of the plain run."""
    assert command(f"run {WORDS} -o whole.nc")[0] == 0
    assert command(f"prepare {WORDS} --block-cells 4 -o a.nc") == (
        0,
        "a.nc.run\n",
        "eulerdisk: 18 cells in 5 blocks\n",
    )
    for part, blocks in ((3, 1), (1, 2), (2, 2)):
        status, _, err = command(f"block --run a.nc.run --part {part}/3")
        assert (status, err) == (0, f"eulerdisk: part {part}/3: 0 blocks were there, {blocks} computed\n")
    assert command("block --run a.nc.run --part 2/3")[2].endswith("2 blocks were there, 0 computed\n")
    assert command("assemble a.nc.run") == (0, "", "eulerdisk: a.nc: 18 cells\n")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "whole.nc").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nc", "whole.nc"]


def test_drivers_take_over_from_each_other(command, tmp_path, monkeypatch):
    """A run goes on from a part, and parts go on from a run; each block is computed once."""
    run_to_file(SPEC, tmp_path / "whole.nc", command=f"eulerdisk run {WORDS}")
    spans = []
    compute = driving.compute
    monkeypatch.setattr(driving, "compute", lambda spec, span: spans.append(span) or compute(spec, span))
    command(f"prepare {WORDS} --block-cells 4 -o a.nc")
    command("block --run a.nc.run --part 2/2")
    assert command(f"run {WORDS} -o a.nc")[2].startswith(
        "eulerdisk: going on: 2 of 5 blocks are there, 3 to compute"
    )
    stopped_after(tmp_path / "b.nc", 1, command=f"eulerdisk run {WORDS}")
    assert command("block --run b.nc.run --part 1/1")[0] == 0
    assert command("assemble b.nc.run")[0] == 0
    # 5 blocks of 4 cells, then 4 blocks of 5
    assert sorted(len(span) for span in spans) == [2, 3, 4, 4, 4, 4, 5, 5, 5]
    for name in ("a.nc", "b.nc"):
        assert (tmp_path / name).read_bytes() == (tmp_path / "whole.nc").read_bytes()


@pytest.mark.parametrize(
    ("line", "match"),
    [
        ("block --run a.nc.run --part 0/3", "not a part"),
        ("block --run a.nc.run --part 4/3", "not a part"),
        ("block --run a.nc.run --part x", "not a part"),
        ("block --run elsewhere --part 1/3", "not the folder of a run"),
        ("assemble a.nc.run", "blocks are missing"),
        ("assemble elsewhere", "not the folder of a run"),
        (
            f"run {WORDS} alpha=0.7 criterion=departure:1deg -o a.nc",
            r"alpha: 0.5 there, 0.7 here; criterion: ",
        ),
        (f"prepare {WORDS} --block-cells 0 -o b.nc", "no block"),
        ("info missing.nc --partial b.nc", "no unfinished run"),
    ],
)
def test_what_cannot_be_done_is_refused(command, tmp_path, line, match):
    """With status 2, a message of four parts, and nothing touched."""
    command(f"prepare {WORDS} --block-cells 4 -o a.nc")
    before = sorted(tmp_path.rglob("*"))
    status, out, err = command(line)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert all(part in err for part in (". Rule: ", ". Given: ", ". Do: "))
    assert re.search(match, err)
    assert sorted(tmp_path.rglob("*")) == before


def test_info_tells_how_far_a_run_is(command, tmp_path):
    """Of an unfinished run, under the name of its file or its folder, the blocks and cells that are there are told."""
    stopped_after(tmp_path / "a.nc", 2)
    for name in ("a.nc", "a.nc.run"):
        status, out, _ = command(f"info {name}")
        assert status == 0
        assert "blocks      2 of 4, 10 of 18 cells (56 %)" in out


def test_a_partial_atlas_has_what_there_is(command, tmp_path):
    """Cells of finished blocks are as in the whole atlas; the others are not computed, undecided, without numbers."""
    stopped_after(tmp_path / "a.nc", 2)
    done = 10
    run_to_file(SPEC, tmp_path / "whole.nc")
    assert command("info a.nc --partial p.nc") == (0, "", f"eulerdisk: p.nc: {done} of 18 cells computed\n")
    with open_atlas(tmp_path / "p.nc") as part, open_atlas(tmp_path / "whole.nc") as whole:
        for name in ("ending", "stability", "tilt_min", "tilt_max", "steps"):
            found, expected = part[name].values.ravel(), whole[name].values.ravel()
            np.testing.assert_array_equal(found[:done], expected[:done])
            assert (np.isnan(found[done:]) if found.dtype.kind == "f" else found[done:] == 0).all()
    assert f"{18 - done} not computed" in command("info p.nc")[1]
    assert peek.unfinished(tmp_path / "p.nc") is None
    # only looked at: the run goes on
    assert command(f"run {WORDS} -o a.nc")[0] == 0


def test_two_runs_that_differ_in_how_they_are_run_have_the_same_bytes(command, tmp_path):
    """Threads, block size, output name and driver are not in the file."""
    for line in (f"run {WORDS} -o a.nc", f"run {WORDS} --threads 1 --block-cells 3 --max-failed 50 -o b.nc"):
        assert command(line)[0] == 0
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_finished_run_that_could_not_tidy_up(command, tmp_path, monkeypatch):
    """Killed after the file got its name: the same command finds that it is done, and only tidies up."""
    monkeypatch.setattr("sweep.journal.remove", lambda _: None)
    run_to_file(SPEC, tmp_path / "a.nc", block_cells=5)
    monkeypatch.undo()
    before = (tmp_path / "a.nc").stat()
    monkeypatch.chdir(tmp_path)
    assert command(f"run {WORDS} -o a.nc")[0] == 0
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
    assert (tmp_path / "a.nc").stat() == before


def test_another_file_at_the_final_name_is_not_taken_for_the_runs_own(command, tmp_path):
    """A run that is stopped, and a file that appears at its name meanwhile: refused without --overwrite, kept whole."""
    stopped_after(tmp_path / "a.nc", 1)
    (tmp_path / "a.nc").write_text("somebody else's")
    assert command(f"run {WORDS} -o a.nc")[0] == 2
    assert (tmp_path / "a.nc").read_text() == "somebody else's"
    assert command(f"run {WORDS} -o a.nc --overwrite")[0] == 0


def test_plan_writes_nothing_and_counts_right(command, tmp_path):
    """Cells and blocks follow from the grid; without calibration no time is promised."""
    status, out, err = command(
        "plan rolling roll_rate=0.5:6:1000 tilt=0.1deg:9deg:300 --block-cells 70000 --no-calibrate"
    )
    assert (status, err) == (0, "")
    assert out.splitlines()[:3] == [
        "cells    300000 (1000 x 300)",
        "blocks   5 of 70000 cells",
        "time     not measured",
    ]
    # 63 bytes a cell, the sum of the types in the table of variables
    assert "disk     19 MB for the journal" in out
    assert list(tmp_path.iterdir()) == []


def test_plan_without_calibration_loads_no_numba(tmp_path):
    """Neither numba nor the file libraries are loaded, and the answer is quick."""
    code = (
        "import sys; sys.argv = ['eulerdisk', 'plan', 'rolling', '--no-calibrate']\n"
        "from sweep.cli import main\n"
        "try: main()\n"
        "finally: print(*{name.partition('.')[0] for name in sys.modules}, file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (
        set(done.stderr.split()) & {"numba", "llvmlite", "xarray", "netCDF4", "scipy", "matplotlib"} == set()
    )
    assert done.stdout.startswith("cells    160200 (801 x 200)\n")


@pytest.mark.compiled
def test_plan_measures(command):
    """With calibration a time is given, in the words in which a run says what it has to go."""
    status, out, _ = command("plan rolling")
    assert status == 0
    assert "time     about " in out
    assert " s (" in out
    assert " cells per second)" in out


def test_plan_says_what_does_not_fit(command):
    """A run larger than the disk: status 1."""
    status, out, _ = command("plan rolling roll_rate=0:9:1000000 tilt=0:1:900000 --no-calibrate")
    assert status == 1
    assert "does not fit" in out


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.2, "0 s"), (119.4, "119 s"), (600, "10 min"), (9000, "2.5 h"), (400000, "4.7 days")],
)
def test_times_for_people(seconds, text):
    """Seconds, minutes, hours or days, whichever is read at a glance."""
    assert estimate.duration(seconds) == text


@pytest.mark.parametrize("cells", [1, 10, 500, 10**6])
def test_a_coarse_grid_is_spread_over_the_grid(cells):
    """It has about as many cells as asked for, at most those of the grid, and values of the grid's own axes."""
    spec = SweepSpec.preset("rolling")
    sample = coarse(spec, cells)
    assert min(cells, spec.size) / 4 <= sample.size <= min(4 * cells, spec.size)
    for name in spec.axes:
        value = getattr(sample, name)
        assert set(np.atleast_1d(value.array())) <= set(getattr(spec, name).array())
