"""The folder of a run: other files in it are safe, and it is removed once the atlas exists."""

import os

import pytest
from messages import refused

from sweep.errors import RequestError
from sweep.files.reading import open_atlas
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs
from sweep.runs.run import run_to_file

SPEC = SweepSpec(roll_rate="2:4:6", tilt="0.1deg,1deg")


def test_what_a_run_has_not_made_it_does_not_remove(tmp_path):
    """Notes next to the blocks, and among them, survive the run; blocks and its other files are removed."""
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
    with refused("a.nc"):
        run_to_file(SPEC, tmp_path / "a.nc")


def test_an_empty_folder_will_do(tmp_path):
    """An empty folder, or one with temporary files of an earlier crash, does not block a run."""
    (tmp_path / "a.nc.run").mkdir()
    (tmp_path / "a.nc.run" / ".eulerdisk-0123456789abcdef.tmp").write_text("{")
    run_to_file(SPEC, tmp_path / "a.nc")
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


def test_a_run_that_is_refused_leaves_no_folder(tmp_path):
    """A refusal after the folder was created leaves nothing."""
    (tmp_path / "a.nc").write_text("old")
    for how in ({}, {"overwrite": True, "threads": 10**6}, {"overwrite": True, "block_cells": 0}):
        with pytest.raises(RequestError):
            run_to_file(SPEC, tmp_path / "a.nc", **how)
        assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
    assert (tmp_path / "a.nc").read_text() == "old"


@pytest.mark.parametrize("name", ["data.npz", "x.tmp", "owner", "logs/1"])
def test_a_folder_that_is_not_a_runs_is_left_as_it_was(tmp_path, name):
    """A folder without a manifest, and with a file that no run creates, is refused and left unchanged."""
    mine = tmp_path / "a.nc.run" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("years of work")
    before = sorted(tmp_path.rglob("*"))
    first = name.partition("/")[0]
    with refused("a.nc.run", f"{first}"):
        run_to_file(SPEC, tmp_path / "a.nc")
    assert sorted(tmp_path.rglob("*")) == before
    assert mine.read_text() == "years of work"


def test_a_malformed_record_does_not_block_a_run(tmp_path):
    """In a run's folder an unreadable record is ignored: the run continues and replaces it."""
    journal = array_jobs.prepare(SPEC, tmp_path / "a.nc", block_cells=3)
    (journal.folder / "published.json").write_bytes(b"\xff{")
    run_to_file(SPEC, tmp_path / "a.nc")
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


def test_odd_names_are_names(tmp_path, monkeypatch):
    """A name that netCDF or xarray would interpret otherwise, without a folder, is used as a file name."""
    for name in [" a.nc", "a.nc ", "-a.nc", "http:a.nc", "a#mode=nczarr.nc", "~a.nc", "a\nb.nc"]:
        monkeypatch.chdir(tmp_path)
        run_to_file(SPEC, name)
        with open_atlas(name) as atlas:
            assert atlas.sizes == {"roll_rate": 6, "tilt": 2}
        assert os.listdir() == [name]
        os.remove(name)


def test_hopeless_names_are_refused_at_once(tmp_path, monkeypatch):
    """Impossible atlas names are refused before anything is computed or created."""
    for name in ["a\udcff.nc", "a\0.nc", "y" * 256]:
        monkeypatch.chdir(tmp_path)
        with refused("name"):
            run_to_file(SPEC, name)
        assert os.listdir() == []
