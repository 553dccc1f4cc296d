"""`run`, `plan` and `warmup`: a run writes the requested atlas; plan and warmup report what they find."""

import math
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from messages import assert_facts, assert_in_order

import sweep
from sweep.commands import warmup
from sweep.files.reading import open_atlas
from sweep.model import registry
from sweep.model.disk.model import DISK
from sweep.model.kernel import cache_root
from sweep.request.spec import SweepSpec
from sweep.request.spec_file import presets

CHECKOUT = Path(__file__).parents[2]
SMALL = ["roll_rate=2:4:9", "tilt=0.1deg,1deg"]


def test_run_writes_the_atlas(command, tmp_path):
    """The file is the atlas of the spec with the changes; standard output is empty."""
    status, out, err = command(f"run rolling {' '.join(SMALL)} -o a.nc")
    # a first run may compile long enough to show its progress
    assert (status, out, err.splitlines()[-1]) == (0, "", "eulerdisk: a.nc: 18 cells")
    spec = sweep.SweepSpec.from_words("rolling", SMALL)
    with open_atlas(tmp_path / "a.nc") as read:
        assert read.attrs["history"].endswith(
            "Z eulerdisk run rolling roll_rate=2:4:9 tilt=0.1deg,1deg -o a.nc"
        )
        xr.testing.assert_equal(read, sweep.run(spec))
        assert read.attrs["sweep_fingerprint"] == spec.fingerprint()


def test_run_reads_a_file(command, spec_file, tmp_path):
    """A TOML file is a spec like a preset and can be changed by words."""
    spec_file('tilt = "1deg:5deg:3"\nroll_rate = 3\n', "my.toml")
    assert command("run my.toml alpha=0.5,1 --threads 1 -o a.nc")[0] == 0
    with open_atlas(tmp_path / "a.nc") as read:
        assert dict(read.sizes) == {"tilt": 3, "alpha": 2}


def test_an_existing_file_needs_overwrite(command, tmp_path):
    """An existing file is kept and refused, unless --overwrite is given."""
    (tmp_path / "a.nc").write_text("old")
    status, _, err = command("run rolling roll_rate=3 tilt=1deg -o a.nc")
    assert status == 2
    assert_facts(err, "a.nc", "--overwrite")
    assert (tmp_path / "a.nc").read_text() == "old"
    assert command("run rolling roll_rate=3 tilt=1deg -o a.nc --overwrite")[0] == 0
    assert command("info a.nc")[0] == 0


@pytest.mark.parametrize("epoch", ["", "yesterday", "1e9", "9" * 30])
def test_a_time_that_is_none(command, tmp_path, monkeypatch, epoch):
    """A bad date for the file is refused before anything is computed."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    status, out, err = command("run rolling -o a.nc")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert_facts(err, "SOURCE_DATE_EPOCH", repr(epoch))
    assert list(tmp_path.iterdir()) == []


def test_one_impossible_cell_does_not_stop_a_run(command):
    """A precession axis through zero makes only those circling cells invalid; they are listed and counted."""
    status, _, err = command("run circling tilt=10deg,20deg precession_rate=-1:1:5 --max-failed 20 -o a.nc")
    assert status == 0
    cells, failed, *listed = err.splitlines()
    assert_facts(cells, "a.nc", "10 cells")
    assert_facts(failed, "2 of 10 cells", "(20 %)", "2 invalid")
    for line, tilt in zip(listed, ("10deg", "20deg"), strict=True):
        assert_in_order(line, f"tilt={tilt} precession_rate=0", "invalid")
    assert "8 bounded, 2 invalid" in command("info a.nc")[1]


def test_too_many_failed_cells_end_with_1(command, tmp_path):
    """More failed cells than --max-failed, by default 1 %, give status 1 and a list of ten; the file exists."""
    words = "tilt=1deg:9deg:12 precession_rate=-1:1:41"
    for most, expected in (("", 1), ("--max-failed 2.43", 1), ("--max-failed 2.44", 0)):
        status, out, err = command(f"run circling {words} {most} -o a.nc --overwrite")
        assert (status, out) == (expected, "")
        assert_facts(err, "12 of 492 cells", "(2.44 %)", "12 invalid")
        assert err.count("precession_rate=0: invalid\n") == 10
        assert ("--max-failed" in err) == (expected == 1)
        with open_atlas(tmp_path / "a.nc") as read:
            assert int((read.ending == 6).sum()) == 12


def test_plan_writes_nothing_and_counts_right(command, tmp_path):
    """Cells and blocks follow from the grid; without calibration no time is given."""
    status, out, err = command(
        "plan rolling roll_rate=0.5:6:1000 tilt=0.1deg:9deg:300 --block-cells 70000 --no-calibrate"
    )
    assert (status, err) == (0, "")
    cells, blocks, time, *others = out.splitlines()
    assert cells == "cells    300000 (1000 x 300)"
    assert_facts(blocks, "5 of 70000 cells")
    assert time.split()[0] == "time"
    assert not re.search(r"\d", time)
    # 46 bytes a cell without derived variables, 63 bytes with them
    (disk,) = (line for line in others if line.startswith("disk "))
    assert re.findall(r"\d+ [kMGT]?B", disk)[:2] == ["14 MB", "15 MB"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.compiled
def test_plan_measures(command):
    """With calibration, `plan` gives a time in the format of a run's remaining time."""
    status, out, _ = command("plan rolling")
    assert status == 0
    # possibly minutes on a busy machine
    assert re.search(r"^time .*\b[\d.]+ (s|min)\b.*\b[\d.e+]+ cells\b", out, re.MULTILINE)


def test_plan_says_what_does_not_fit(command, machine):
    """A run larger than the disk gives status 1."""
    machine(free_bytes=50e9)
    status, out, _ = command("plan rolling roll_rate=0:9:30000 tilt=0:1:33000 contact=yes --no-calibrate")
    assert status == 1
    assert_facts(out, "GB", "not fit")


def test_plan_refuses_an_output_that_cannot_be(command):
    """An impossible output gives status 2 and one message, as in `run`."""
    status, out, err = command("plan rolling --no-calibrate -o nowhere/a.nc")
    assert (status, out) == (2, "")
    assert err.startswith("eulerdisk: nowhere/a.nc: ")
    assert err.count("\n") == 1
    assert_facts(err, "mkdir -p nowhere")


def test_a_file_system_without_a_size_is_not_a_full_one(command, machine):
    """A file system that reports zero size is not treated as full."""
    machine(free_bytes=math.inf)
    status, out, _ = command("plan rolling --no-calibrate")
    assert status == 0
    (disk,) = (line for line in out.splitlines() if line.startswith("disk "))
    assert_facts(disk, "unknown")
    assert command("run rolling roll_rate=2:4:3 tilt=1deg -o a.nc")[0] == 0


def run(folder, *words, **environment):
    """Run the command in a folder."""
    return subprocess.run(
        [sys.executable, "-m", "sweep", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT), **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_warmup_fills_the_cache(tmp_path):
    """`warmup` compiles the kernels of methods, contact forces and motions into the cache, and writes nothing else.

    It compiles in several processes but names the sets of kernels in a fixed order.
    """
    done = run(tmp_path, "warmup")
    assert (done.returncode, done.stderr) == (0, "")
    *ready, device, last = done.stdout.splitlines()
    assert device.startswith("device  cpu")
    names = ["disk rk4", "disk exact", "disk contact=yes", "disk path=yes", "disk motion"]
    names += ["lossy_disk rk4", "lossy_disk coin", "lossy_disk toy", "lossy_disk motion"]
    names += ["bodies thick_coin"]
    names += ["bodies motion", "lossy_bodies rk4", "lossy_bodies motion"]
    assert [line.split()[:3] for line in ready] == [[*name.split(), "ready"] for name in names]
    assert last.split() == ["cache", str(cache_root())]
    compiled = {path.name.partition("-")[0].rpartition(".")[2] for path in cache_root().rglob("*.nbc")}
    assert {"integrate_of_disk", "reduce", "wells", "contact"} <= compiled
    assert any(name.startswith("trajectory") or name.startswith("_trajectory") for name in compiled)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_a_command_that_compiles_says_so(tmp_path):
    """The first command announces what it compiles, for how long, and the cache; the second has nothing to compile."""
    where = {"EULERDISK_CACHE_DIR": str(tmp_path / "cache"), "EULERDISK_NOTICES": "yes"}
    words = ["simulate", "tilt=0.1", "duration=0.1", "--overwrite", "-o", "a.nc"]
    told, again = (run(tmp_path, *words, **where).stderr.splitlines() for _ in range(2))
    of = [line for line in told if "compiling kernels.bodies.trajectory" in line]
    assert of
    for line in of:
        assert re.search(r"\b\d+ s\b", line)
        assert_facts(line, f"kept in {tmp_path / 'cache'}")
        assert "cannot" not in line
    assert not [line for line in again if "compiling" in line or "measuring" in line]


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_a_cache_that_others_can_write_is_told(tmp_path):
    """If others can write to the cache, one line says so and what to do; the compile notice does not contradict it."""
    cache = tmp_path / "cache"
    cache.mkdir()
    cache.chmod(0o777)
    where = {"EULERDISK_CACHE_DIR": str(cache), "EULERDISK_NOTICES": "yes", "PYTHONWARNINGS": "error"}
    done = run(tmp_path, "simulate", "tilt=0.1", "duration=0.1", "-o", "a.nc", **where)
    assert done.returncode == 0
    (warning,) = [line for line in done.stderr.splitlines() if line.startswith("eulerdisk: warning: ")]
    assert_facts(warning, str(cache), "chmod -R go-w")
    told = [line for line in done.stderr.splitlines() if "compiling" in line]
    assert told
    for line in told:
        assert_facts(line, "cannot", str(cache))


def test_warmup_has_the_kernels_of_every_preset():
    """After `warmup`, no first run of a preset compiles anything."""
    tasks, kernels = warmup.usual_tasks()
    assert len(tasks) > 10
    for model in registry.every():
        for name in presets(model):
            spec = SweepSpec.preset(name)
            assert set(spec.model.kernels(spec)) <= set(kernels), name


@pytest.mark.slow_lane
def test_warmup_says_that_nothing_was_kept(command, tmp_path, monkeypatch):
    """If the kernels cannot be kept, here because compilation is off, `warmup` exits with 2 and advice."""
    monkeypatch.setattr(warmup, "usual_tasks", lambda: ({}, [DISK.integrate]))
    monkeypatch.setenv("EULERDISK_CACHE_DIR", str(tmp_path / "cache"))
    status, _, err = command("warmup")
    assert status == 2
    assert_facts(err, "EULERDISK_CACHE_DIR", str(tmp_path / "cache"))


def test_a_range_that_misses_the_boundary_is_warned_of(command, tmp_path):
    """`run`, `plan`, `prepare` and `info` warn and suggest a range, without changing status or output."""
    words = "rolling radius=12mm roll_rate=2:4:9 tilt=0.1deg,1deg"
    warning = "eulerdisk: warning: roll_rate=2.0:4.0:9 "
    ends = [command(line) for line in (f"plan {words} --no-calibrate", f"run {words} -o a.nc", "info a.nc")]
    ends.append(command(f"prepare {words} -o b.nc"))
    for status, out, err in ends:
        assert status == 0
        assert warning not in out
        (told,) = (line for line in err.splitlines() if line.startswith(warning))
        assert_facts(told, "unstable")
    pasted = ends[0][2].split()[-1]
    for line in (
        f"plan {words} {pasted} --no-calibrate",
        "run rolling roll_rate=2:4:5 tilt=1deg -o c.nc",
        "info c.nc",
    ):
        assert "warning" not in command(line.replace("roll_rate=2:4:9 ", ""))[2]
    # the refusal follows the warning
    assert_facts(command(f"run {words} -o a.nc")[2].splitlines()[-1], "a.nc", "--overwrite")


def test_the_mass_of_a_preset_is_told_where_the_disk_is_another(command, tmp_path):
    """A coin made from the toy keeps its mass, and a note says so, unless a mass is given or has no meaning."""
    for line, facts in (
        ("plan toy radius=11mm", ["toy", "438.7g", "radius=11mm", "mass="]),
        ("plan coin diameter=2cm", ["coin", "7.5g", "diameter=2cm"]),
        ("plan toy radius=11mm mass=7g", []),
        ("plan toy", []),
        ("plan rolling radius=11mm", []),
    ):
        status, _, err = command(f"{line} --no-calibrate")
        assert status == 0
        assert_facts(err, *facts)
        assert facts or "mass" not in err
