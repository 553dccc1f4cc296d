"""The folder of a run: files that no run has made are safe in it, and it is removed when the file is there."""

import pytest

from sweep.errors import RequestError
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs
from sweep.runs.run import run_to_file

SPEC = SweepSpec(roll_rate="2:4:6", tilt="0.1deg,1deg")


def test_a_folder_with_other_files_is_not_taken(tmp_path):
    """A folder that happens to have the name of a run's, with other things in it, is refused and left as it was."""
    mine = tmp_path / "a.nc.run" / "mine.txt"
    mine.parent.mkdir()
    mine.write_text("years of work")
    with pytest.raises(RequestError, match=r"that name is taken.*mine\.txt, which no run has made") as caught:
        run_to_file(SPEC, tmp_path / "a.nc")
    assert caught.value.where == str(tmp_path / "a.nc")
    assert str(tmp_path) not in caught.value.message
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [mine]


def test_what_a_run_has_not_made_it_does_not_remove(tmp_path):
    """Notes that somebody keeps beside the blocks, and among them, outlive the run; blocks and the rest go."""
    journal = array_jobs.prepare(SPEC, tmp_path / "a.nc", block_cells=3)
    notes = [
        journal.folder / "notes.txt",
        journal.folder / "blocks" / "job-17.log",
        journal.folder / "logs" / "1",
    ]
    for path in notes:
        path.parent.mkdir(exist_ok=True)
        path.write_text("kept")
    run_to_file(SPEC, tmp_path / "a.nc")
    assert sorted(path for path in tmp_path.rglob("*") if path.is_file()) == sorted(
        [tmp_path / "a.nc", *notes]
    )
    with pytest.raises(RequestError, match=r"the file exists|is taken"):
        run_to_file(SPEC, tmp_path / "a.nc")


def test_an_empty_folder_will_do(tmp_path):
    """An empty folder, or one with temporary files of an earlier crash, does not keep a run from starting."""
    (tmp_path / "a.nc.run").mkdir()
    (tmp_path / "a.nc.run" / "manifest.json.17.tmp").write_text("{")
    run_to_file(SPEC, tmp_path / "a.nc")
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


def test_a_run_that_is_refused_leaves_no_folder(tmp_path):
    """Whatever is refused after the folder was made, nothing of it is left."""
    (tmp_path / "a.nc").write_text("old")
    for how in ({}, {"overwrite": True, "threads": 10**6}, {"overwrite": True, "block_cells": 0}):
        with pytest.raises(RequestError):
            run_to_file(SPEC, tmp_path / "a.nc", **how)
        assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
    assert (tmp_path / "a.nc").read_text() == "old"
