"""The command as a user meets it: mostly in this process, as a process where signals and imports are meant."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

import sweep
from sweep.atlas.verdicts import reclassify
from sweep.commands.report import boundary_table, describe
from sweep.files.reading import open_atlas

CHECKOUT = Path(__file__).parents[1]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
SMALL = ["roll_rate=2:4:9", "tilt=0.1deg,1deg"]
HEAVY = {"numba", "llvmlite", "xarray", "netCDF4", "scipy", "matplotlib", "pandas", "pint"}


def start(*words, folder, before=()):
    """Start the command as a process in a folder."""
    return subprocess.Popen(
        [sys.executable, *before, "-m", "sweep", *words],
        cwd=folder,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_run_writes_the_atlas(command, tmp_path):
    """The file is the atlas of the spec with the words' changes; standard output stays empty."""
    status, out, err = command(f"run rolling {' '.join(SMALL)} -o a.nc")
    # a first run may compile for long enough to say how far it is
    assert (status, out, err.splitlines()[-1]) == (0, "", "eulerdisk: a.nc: 18 cells")
    spec = sweep.SweepSpec.from_words("rolling", SMALL)
    with open_atlas(tmp_path / "a.nc") as read:
        assert read.attrs["history"].endswith("Z eulerdisk run rolling roll_rate=2:4:9 tilt=0.1deg,1deg")
        xr.testing.assert_equal(read, sweep.run(spec))
        assert read.attrs["sweep_fingerprint"] == spec.fingerprint()


def test_run_reads_a_file(command, spec_file, tmp_path):
    """A TOML file is a spec like a preset, and its words can be changed."""
    spec_file('tilt = "1deg:5deg:3"\nroll_rate = 3\n', "my.toml")
    assert command("run my.toml alpha=0.5,1 --threads 1 -o a.nc")[0] == 0
    with open_atlas(tmp_path / "a.nc") as read:
        assert dict(read.sizes) == {"tilt": 3, "alpha": 2}


def test_an_existing_file_needs_overwrite(command, tmp_path):
    """An existing file is refused as it is, and replaced with --overwrite."""
    (tmp_path / "a.nc").write_text("old")
    status, _, err = command("run rolling roll_rate=3 tilt=1deg -o a.nc")
    assert status == 2
    assert "--overwrite" in err
    assert (tmp_path / "a.nc").read_text() == "old"
    assert command("run rolling roll_rate=3 tilt=1deg -o a.nc --overwrite")[0] == 0
    assert command("info a.nc")[0] == 0


def test_info_and_boundary_print_the_reports(command, tmp_path):
    """What is printed on standard output is the report, and with another criterion that of the reclassified atlas."""
    command(f"run rolling {' '.join(SMALL)} -o a.nc")
    with open_atlas(tmp_path / "a.nc") as atlas:
        assert command("info a.nc") == (0, describe(atlas) + "\n", "")
        assert command("boundary a.nc") == (0, boundary_table(atlas) + "\n", "")
        other = boundary_table(reclassify(atlas, "departure:1deg"))
    assert command("boundary a.nc --criterion departure:1deg") == (0, other + "\n", "")
    assert other != command("boundary a.nc")[1].strip("\n")


@pytest.mark.parametrize(
    ("line", "what", "rule", "given", "do"),
    [
        ("run rolling rol_rate=3 -o a.nc", "unknown word", "the words are tilt", "rol_rate", "did you mean roll_rate?"),
        ("run roling -o a.nc", "no preset 'roling'", "presets are", "roling", "did you mean rolling?"),
        ("run rolling roll_rate=3deg -o a.nc", "'deg' does not fit", "rad/s", "roll_rate=3deg", "a unit that fits"),
        ("run rolling tilt=3m -o a.nc", "'m' does not fit", "deg, rad", "tilt=3m", "a unit that fits"),
        ("run rolling roll_rate=4:2:9 -o a.nc", "not a range", "goes up", "4:2:9", "smaller end first"),
        ("run rolling roll_rate=2:4:0 -o a.nc", "not a range", "count >= 1", "2:4:0", "how many values"),
        ("run rolling roll_rate= -o a.nc", "not a value", "a number, a list", "roll_rate=", "0.01deg:20deg:300:log"),
        ("run rolling roll_rate=2:inf:9 -o a.nc", "not a finite", "finite", "2:inf:9", "a finite number"),
        ("run rolling tilt=nan -o a.nc", "not a finite number", "finite", "tilt=nan", "a finite number"),
        ("run rolling alpha=0 -o a.nc", "0 is not possible", "0 < alpha <= 1", "alpha=0", "choose"),
        ("run rolling alpha=0.5,1.5 -o a.nc", "1.5 is not possible", "0 < alpha <= 1", "alpha=0.5,1.5", "choose"),
        ("run rolling radius=0 -o a.nc", "not possible", "radius > 0", "radius=0", "choose"),
        ("run rolling gravity=-9.81 -o a.nc", "not possible", "gravity > 0", "gravity=-9.81", "choose"),
        ("run rolling tilt=0:90deg:9 -o a.nc", "90 deg is not possible", "|tilt| < 90 deg", "0:90deg:9", "choose"),
        ("run rolling tilt=20 -o a.nc", "not possible", "|tilt| < 90 deg", "tilt=20", "tilt=20deg"),
        ("run circling precession_rate=0 -o a.nc", "without precession", "other than 0", "steady", "precession_rate="),
        ("run rolling criterion=depart -o a.nc", "not a criterion", "departure:ANGLE", "depart", "departure:5deg"),
        ("run rolling tilt=1deg tilt=2deg -o a.nc", "given twice", "once", "tilt=1deg and tilt=2deg", "leave one out"),
        ("run rolling roll_rate=0:9:1000000 tilt=0:1:900000 -o a.nc", "not fit", "are free for", "free in", "fewer"),
        ("run rolling roll_rate=0:9:10000000 tilt=0:1:900000 -o a.nc", "too many cells", "most", "10000000", "lower"),
        ("run rolling -o missing/a.nc", "no such folder", "folder exists", "missing", "mkdir -p missing"),
        ("run rolling -o .", "not a file", "is a file", ".", "give a file name"),
        ("run rolling roll_rate=3 tilt=1deg --threads 0 -o a.nc", "threads", "1 <= threads", "0", "leave it out"),
        ("run rolling --max-failed -1 -o a.nc", "not a share", "0 <= --max-failed <= 100", "-1", "--max-failed 5"),
        ("run rolling --max-failed nan -o a.nc", "not a share", "0 <= --max-failed <= 100", "nan", "--max-failed 5"),
        ("run missing.toml -o a.nc", "cannot be read", "can be read", "No such file", "check the path"),
        ("info missing.nc", "no such file", "netCDF", "missing.nc", "check the path"),
        ("boundary missing.nc", "no such file", "netCDF", "missing.nc", "check the path"),
        ("plot missing.nc -o a.png", "no such file", "netCDF", "missing.nc", "check the path"),
    ],
    ids=lambda each: each if each.startswith(("run", "info", "bound", "plot")) else "",
)  # fmt: skip
def test_a_bad_request_has_one_message(command, tmp_path, line, what, rule, given, do):
    """It ends with 2 and one line on standard error that says what, rule, given and what to do; nothing is touched."""
    status, out, err = command(line)
    assert (status, out, err.count("\n")) == (2, "", 1)
    before, _, rest = err.partition(". Rule: ")
    stated, _, rest = rest.partition(". Given: ")
    found, _, advice = rest.rpartition(". Do: ")
    assert before.startswith("eulerdisk: ")
    for part, expected in ((before, what), (stated, rule), (found, given), (advice, do)):
        assert expected in part, err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("epoch", ["", "yesterday", "1e9", "9" * 30])
def test_a_time_that_is_none(command, tmp_path, monkeypatch, epoch):
    """The time that a file is to bear is looked at before anything is computed."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    status, out, err = command("run rolling -o a.nc")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert "SOURCE_DATE_EPOCH: not a time. Rule: " in err
    assert repr(epoch) in err
    assert list(tmp_path.iterdir()) == []


def test_an_atlas_that_is_cut(command, tmp_path):
    """A truncated file is refused with one message by every command that reads."""
    command("run rolling roll_rate=3 tilt=1deg -o a.nc")
    (tmp_path / "b.nc").write_bytes((tmp_path / "a.nc").read_bytes()[:-100])
    for line in ("info b.nc", "boundary b.nc"):
        status, out, err = command(line)
        assert (status, out) == (2, "")
        assert err.startswith("eulerdisk: b.nc: not a readable netCDF file. Rule: ")


def test_one_impossible_cell_does_not_stop_a_run(command):
    """Circling with a precession axis through zero runs; just those cells are invalid, and are listed and counted."""
    status, _, err = command("run circling tilt=10deg,20deg precession_rate=-1:1:5 --max-failed 20 -o a.nc")
    assert status == 0
    assert err.splitlines() == [
        "eulerdisk: a.nc: 10 cells",
        "eulerdisk: 2 of 10 cells could not be computed (20 %): 2 invalid",
        "eulerdisk:     tilt=10deg precession_rate=0: invalid",
        "eulerdisk:     tilt=20deg precession_rate=0: invalid",
    ]
    assert "8 bounded, 2 invalid" in command("info a.nc")[1]


def test_too_many_failed_cells_end_with_1(command, tmp_path):
    """More failed cells than --max-failed, 1 % if not given: status 1, the file is there, ten of them are listed."""
    words = "tilt=1deg:9deg:12 precession_rate=-1:1:41"
    for most, expected in (("", 1), ("--max-failed 2.43", 1), ("--max-failed 2.44", 0)):
        status, out, err = command(f"run circling {words} {most} -o a.nc --overwrite")
        assert (status, out) == (expected, "")
        assert "12 of 492 cells could not be computed (2.44 %): 12 invalid" in err
        assert err.count("precession_rate=0: invalid\n") == 10
        assert ("the file is whole" in err) == (expected == 1)
        with open_atlas(tmp_path / "a.nc") as read:
            assert int((read.ending == 6).sum()) == 12


def test_a_defect_is_not_hidden(command, monkeypatch):
    """What is no bad request keeps its traceback: it is ours to mend."""
    monkeypatch.setattr("sweep.runs.executor.measure_block", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        command("run rolling roll_rate=3 tilt=1deg -o a.nc")


def test_version(command):
    """The version is that of the package."""
    assert command("--version") == (0, f"eulerdisk {sweep.__version__}\n", "")


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (["--help"], 0),
        (["run", "rolling", "tilt=95deg", "-o", "a.nc"], 2),
        (["run", "rolling", "rate=1", "-o", "a.nc"], 2),
    ],
    ids=["help", "value", "word"],
)
def test_help_and_bad_words_load_nothing_heavy(tmp_path, words, status):
    """Neither help nor a bad word waits for the compiler, the file libraries, the figures or the units."""
    process = start(*words, folder=tmp_path, before=("-X", "importtime"))
    _, err = process.communicate(timeout=60)
    loaded = {
        line.rpartition("|")[2].strip().partition(".")[0]
        for line in err.splitlines()
        if "import time" in line
    }
    assert process.returncode == status
    assert "sweep" in loaded
    assert loaded & HEAVY == set()


def test_a_reader_that_leaves_early(tmp_path):
    """Piping into a reader that closes, like head, ends without a traceback."""
    sweep.run_to_file(sweep.SweepSpec(roll_rate="2:4:3", tilt="1deg:5deg:5000"), tmp_path / "a.nc")
    process = start("boundary", "a.nc", folder=tmp_path)
    process.stdout.readline()
    process.stdout.close()
    assert process.stderr.read() == ""
    process.stderr.close()
    assert process.wait(timeout=60) == 1
