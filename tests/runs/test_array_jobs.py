"""Prepared runs, their parts and their assembly; resumed runs; descriptions of unfinished runs."""

import errno
import inspect
import os
import pkgutil
import re
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from messages import assert_facts, assert_in_order, row

from sweep.errors import StoppedError
from sweep.files.reading import open_atlas
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs, executor
from sweep.runs.folder import locked, unfinished
from sweep.runs.run import run_to_file

WORDS = "rolling roll_rate=2:4:9 tilt=0.1deg,1deg"
SPEC = SweepSpec.from_words("rolling", WORDS.split()[1:])


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Give all files of a spec the same date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


def stopped_after(path, count, **how):
    """Start a run of four blocks and stop it after `count` blocks."""
    asked = [0]

    def stopping():
        # The computing thread asks before every block.
        asked[0] += threading.current_thread() is not threading.main_thread()
        return asked[0] > count

    with pytest.raises(StoppedError):
        run_to_file(SPEC, path, block_cells=5, stopping=stopping, **how)
    assert len(list(path.parent.glob(f"{path.name}.run/blocks/*.block"))) == count


def test_parts_make_the_file_of_a_run(command, tmp_path):
    """Prepared, computed in three parts in any order, and assembled, the bytes equal the plain run's."""
    assert command(f"run {WORDS} -o a.nc")[0] == 0
    # The history contains the file name in its command.
    (tmp_path / "a.nc").rename(tmp_path / "w.nc")
    status, out, err = command(f"prepare {WORDS} --block-cells 4 -o a.nc")
    assert (status, out) == (0, "a.nc.run\n")
    assert_facts(err, "18 cells", "5 blocks")
    for part, blocks in ((3, 1), (1, 2), (2, 2)):
        status, _, err = command(f"block --run a.nc.run --part {part}/3")
        assert status == 0
        assert_facts(err, f"part {part}/3", "0 blocks", f"{blocks} computed")
    assert_facts(command("block --run a.nc.run --part 2/3")[2], "2 blocks", "0 computed")
    assert command("assemble a.nc.run") == (0, "", "eulerdisk: a.nc: 18 cells\n")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "w.nc").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nc", "w.nc"]


def test_steps_of_a_run_that_has_ended(command, tmp_path):
    """They name the existing file and change nothing; following their advice works."""
    assert command(f"prepare {WORDS} -o a.nc")[0] == 0
    (tmp_path / "a.nc").write_bytes(b"older")
    status, _, err = command("assemble a.nc")
    assert status == 2
    assert_facts(err, "a.nc.run.")
    (tmp_path / "a.nc").unlink()
    assert command("block --run a.nc.run --part 1/1")[0] == 0
    assert command("assemble a.nc.run")[0] == 0
    before = (tmp_path / "a.nc").read_bytes()
    for step in (
        "assemble a.nc.run",
        "assemble a.nc.run --overwrite",
        "block --run a.nc.run --part 1/1",
        "assemble a.nc",
    ):
        status, out, err = command(step)
        assert (status, out) == (2, "")
        assert_facts(err, "a.nc exists", "eulerdisk info a.nc")
        assert "prepare" not in err
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
    assert (tmp_path / "a.nc").read_bytes() == before
    assert command("info a.nc")[0] == 0


def test_assemble_replaces_a_file_if_it_is_told_to(command, tmp_path):
    """A file that appeared meanwhile is kept, as are the blocks; --overwrite replaces it."""
    assert command(f"prepare {WORDS} -o a.nc")[0] == 0
    assert command("block --run a.nc.run --part 1/1")[0] == 0
    (tmp_path / "a.nc").write_bytes(b"other")
    status, _, err = command("assemble a.nc.run")
    assert status == 2
    assert_facts(err, "a.nc", "--overwrite")
    assert (tmp_path / "a.nc").read_bytes() == b"other"
    assert command("assemble a.nc.run --overwrite")[0] == 0
    assert (tmp_path / "a.nc").read_bytes() != b"other"


def test_assemble_on_a_full_disk(command, tmp_path, monkeypatch):
    """The blocks are kept and named, and the same command continues once there is room."""
    assert command(f"prepare {WORDS} --block-cells 4 -o a.nc")[0] == 0
    assert command("block --run a.nc.run --part 1/1")[0] == 0

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(array_jobs, "publish_from_journal", full)
        status, _, err = command("assemble a.nc.run")
    assert status == 3
    assert_facts(err, "5 blocks", "a.nc.run", "same command again")
    assert not (tmp_path / "a.nc").exists()
    assert command("assemble a.nc.run")[0] == 0


def test_the_command_of_a_run_that_python_began_exists():
    """Without a command line the history names the called function by its import path."""
    for begin in [array_jobs.prepare, run_to_file]:
        command = inspect.signature(begin).parameters["command"].default
        assert pkgutil.resolve_name(command) is begin


@pytest.mark.slow_lane
def test_the_documented_array_job(command, tmp_path, monkeypatch):
    """The SLURM script of docs/runs.md, run for each task as by SLURM, leaves a run that can be assembled."""
    checkout = Path(__file__).parents[2]
    script = re.search(
        r"^```bash\n(#!/bin/bash.*?)^```$", (checkout / "docs" / "runs.md").read_text(), re.M | re.S
    )[1]
    (tmp_path / "srun").write_text('#!/bin/sh\nexec "$@"\n')
    (tmp_path / "eulerdisk").write_text(f'#!/bin/sh\nexec {sys.executable} -m sweep "$@"\n')
    for name in ("srun", "eulerdisk"):
        (tmp_path / name).chmod(0o755)
    command(f"prepare {WORDS} --block-cells 4 -o atlas.nc")
    for task in "12":
        environment = {
            **os.environ,
            "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(checkout),
            "SLURM_ARRAY_TASK_ID": task,
            "SLURM_ARRAY_TASK_COUNT": "2",
        }
        subprocess.run(["bash", "-e", "-c", script], cwd=tmp_path, env=environment, check=True)
    assert command("assemble atlas.nc.run")[0] == 0


def test_runs_and_array_jobs_take_over_from_each_other(command, tmp_path, monkeypatch):
    """A run resumes from a part, and parts from a run; each block is computed once."""
    run_to_file(SPEC, tmp_path / "w.nc", command=f"eulerdisk run {WORDS} -o a.nc")
    spans = []
    compute = executor.measure_block
    monkeypatch.setattr(
        executor, "measure_block", lambda spec, span: spans.append(span) or compute(spec, span)
    )
    command(f"prepare {WORDS} --block-cells 4 -o a.nc")
    command("block --run a.nc.run --part 2/2")
    assert_facts(command(f"run {WORDS} -o a.nc")[2], "2 of 5 blocks", "3")
    stopped_after(tmp_path / "b.nc", 1, command=f"eulerdisk run {WORDS} -o a.nc")
    assert command("block --run b.nc.run --part 1/1")[0] == 0
    assert command("assemble b.nc.run")[0] == 0
    # 5 blocks of 4 cells, then 4 blocks of 5.
    assert sorted(len(span) for span in spans) == [2, 3, 4, 4, 4, 4, 5, 5, 5]
    for name in ("a.nc", "b.nc"):
        assert (tmp_path / name).read_bytes() == (tmp_path / "w.nc").read_bytes()


def test_what_cannot_be_done_is_refused(command, tmp_path):
    """Impossible commands end with status 2 and one message with the reason, and change nothing."""
    for line, facts in [
        ("block --run a.nc.run --part 0/3", ["1 <= I <= N", "0/3"]),
        ("block --run a.nc.run --part 4/3", ["1 <= I <= N", "4/3"]),
        ("block --run a.nc.run --part x", ["1 <= I <= N", "x"]),
        ("block --run elsewhere --part 1/3", ["elsewhere", "eulerdisk prepare"]),
        ("assemble a.nc.run", ["a.nc.run", "5 of 5 blocks"]),
        ("assemble elsewhere", ["elsewhere", "eulerdisk prepare"]),
        (
            f"run {WORDS} alpha=0.7 criterion=departure:1deg -o a.nc",
            ["alpha: 0.5 in the run", "0.7 now", "criterion:", "rm -r a.nc.run"],
        ),
        (f"prepare {WORDS} --block-cells 0 -o b.nc", ["at least 1", "0"]),
        ("info missing.nc --partial b.nc", ["--partial", "missing.nc.run"]),
    ]:
        command(f"prepare {WORDS} --block-cells 4 -o a.nc")
        before = sorted(tmp_path.rglob("*"))
        status, out, err = command(line)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert_facts(err, *facts)
        assert sorted(tmp_path.rglob("*")) == before


def spoilt(folder):
    """Damage the first stored block."""
    path = min(folder.glob("blocks/*.block"))
    path.write_bytes(path.read_bytes()[:-2])
    return path.name


def test_damage_is_told_by_every_command_that_meets_it(command, tmp_path):
    """`assemble` names the block that it set aside, and so does the part that recomputes it."""
    command(f"prepare {WORDS} --block-cells 5 -o a.nc")
    command("block --run a.nc.run --part 1/1")
    name = spoilt(tmp_path / "a.nc.run")
    status, _, err = command("assemble a.nc.run")
    assert status == 2
    assert_facts(err, "1 of 4 blocks", "block 0")
    assert name in err
    assert command("block --run a.nc.run --part 1/1")[0] == 0
    name = spoilt(tmp_path / "a.nc.run")
    status, _, err = command("block --run a.nc.run --part 1/1")
    assert status == 0
    assert_facts(err.splitlines()[0], "damaged", name)
    assert command("assemble a.nc.run")[0] == 0


def test_the_name_of_the_folder_is_that_of_the_file(command, tmp_path, monkeypatch):
    """It works from inside the folder too; a wrongly named folder is refused with the required name."""
    command(f"prepare {WORDS} -o a.nc")
    command("block --run a.nc.run --part 1/1")
    shutil.copytree(tmp_path / "a.nc.run", tmp_path / "a copy")
    status, _, err = command("assemble 'a copy'")
    assert status == 2
    assert_facts(err, "a copy")
    assert_facts(err, "mv 'a copy' OUT.nc.run")
    monkeypatch.chdir(tmp_path / "a.nc.run")
    assert command("assemble .")[0] == 0
    monkeypatch.chdir(tmp_path)
    assert (tmp_path / "a.nc").is_file()
    assert not (tmp_path / "a.nc.run").exists()


def test_info_tells_how_far_a_run_is(command, tmp_path):
    """For an unfinished run, by file or folder name, it reports finished blocks and cells."""
    stopped_after(tmp_path / "a.nc", 2)
    for name in ("a.nc", "a.nc.run"):
        status, out, _ = command(f"info {name}")
        assert status == 0
        assert_in_order(row(out, "blocks"), "2 of 4", "10 of 18 cells", "56 %")


def test_a_partial_atlas_has_what_there_is(command, tmp_path):
    """Cells of finished blocks equal the whole atlas; all others are not computed, without numbers."""
    stopped_after(tmp_path / "a.nc", 2)
    done = 10
    run_to_file(SPEC, tmp_path / "whole.nc")
    status, out, err = command("info a.nc --partial p.nc")
    assert (status, out, err.count("\n")) == (0, "", 1)
    assert_facts(err, "p.nc", f"{done} of 18 cells")
    with open_atlas(tmp_path / "p.nc") as part, open_atlas(tmp_path / "whole.nc") as whole:
        for name in ("ending", "stability", "tilt_min", "tilt_max", "steps"):
            found, expected = part[name].values.ravel(), whole[name].values.ravel()
            np.testing.assert_array_equal(found[:done], expected[:done])
            assert (np.isnan(found[done:]) if found.dtype.kind == "f" else found[done:] == 0).all()
    assert_facts(command("info p.nc")[1], f"{18 - done} not computed")
    assert unfinished(tmp_path / "p.nc") is None
    # The file is only a view, so the run can resume.
    assert command(f"run {WORDS} -o a.nc")[0] == 0


def test_a_run_that_goes_on_keeps_its_time(command, tmp_path, monkeypatch):
    """The file has the time and command of the run's start, no matter when it was finished."""
    stopped_after(tmp_path / "a.nc", 2, command="the first")
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1800000000")
    run_to_file(SPEC, tmp_path / "a.nc", command="the second")
    with open_atlas(tmp_path / "a.nc") as read:
        assert read.attrs["date_created"] == "2023-11-14T22:13:20Z"
        assert read.attrs["history"] == "2023-11-14T22:13:20Z the first"


def test_a_second_run_of_one_output_is_refused(command, tmp_path):
    """While one run writes, another gets status 2 and the first one's process id, and changes nothing."""
    stopped_after(tmp_path / "a.nc", 2)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*.block")}
    with locked(tmp_path / "a.nc.run"):
        for line in (f"run {WORDS} -o a.nc", "block --run a.nc.run --part 1/1", "assemble a.nc.run"):
            status, _, err = command(line)
            assert status == 2
            assert_facts(err, "a.nc.run:", "being written")
            assert f"process {os.getpid()} on " in err
    assert {path: path.read_bytes() for path in tmp_path.rglob("*.block")} == before


def test_two_names_of_one_output_meet_at_one_lock(command, tmp_path):
    """A symbolic link is followed: the run belongs to the target file."""
    stopped_after(tmp_path / "a.nc", 2)
    (tmp_path / "link.nc").symlink_to("a.nc")
    assert_facts(command(f"run {WORDS} -o link.nc --overwrite")[2], "2 of 4 blocks")
    assert (tmp_path / "a.nc").is_file()
    assert (tmp_path / "link.nc").is_symlink()


def test_another_run_is_not_taken_for_done(command, tmp_path, monkeypatch):
    """After a run killed once its file was complete, a request for other cells does not end as if done."""
    monkeypatch.setattr("sweep.runs.run_directory.remove", lambda _: None)
    run_to_file(SPEC, tmp_path / "a.nc", block_cells=5)
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    status, _, err = command(f"run {WORDS} alpha=0.7 -o a.nc --overwrite")
    assert status == 2
    assert_in_order(err, "alpha", "0.5", "0.7")


def test_another_file_at_the_final_name_is_not_taken_for_the_runs_own(command, tmp_path):
    """A file that appears while the run is stopped is kept; the run is refused without --overwrite."""
    stopped_after(tmp_path / "a.nc", 1)
    (tmp_path / "a.nc").write_text("somebody else's")
    assert command(f"run {WORDS} -o a.nc")[0] == 2
    assert (tmp_path / "a.nc").read_text() == "somebody else's"
    assert command(f"run {WORDS} -o a.nc --overwrite")[0] == 0
