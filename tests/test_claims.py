"""The folder of a run: what is in it that no run has put there is safe, and so is who may not write there."""

import errno
import os

import pytest

from sweep.errors import RequestError, StorageError
from sweep.files.publish import refusals
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs
from sweep.runs.locks import locked
from sweep.runs.run import run_to_file

SPEC = SweepSpec(roll_rate="2:4:6", tilt="0.1deg,1deg")


def test_a_folder_of_somebody_else_is_not_taken(tmp_path):
    """A folder that happens to have the name of a run's, with other things in it, is refused and left as it was."""
    mine = tmp_path / "a.nc.run" / "mine.txt"
    mine.parent.mkdir()
    mine.write_text("years of work")
    with pytest.raises(
        RequestError, match=r"name of the run's folder is taken.*mine\.txt, which no run has made"
    ):
        run_to_file(SPEC, tmp_path / "a.nc")
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
    """What an earlier crash has left of the folder, or a file manager in it, is in nobody's way."""
    (tmp_path / "a.nc.run").mkdir()
    (tmp_path / "a.nc.run" / "manifest.json.17.tmp").write_text("{")
    run_to_file(SPEC, tmp_path / "a.nc")
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]


@pytest.mark.parametrize("code", [errno.EACCES, errno.EROFS])
def test_a_run_of_somebody_else(tmp_path, monkeypatch, code):
    """Who may not write into its folder is told so, with status 2."""

    def refuse(path, *_):
        raise OSError(code, os.strerror(code), path)

    monkeypatch.setattr("sweep.runs.locks.os.open", refuse)
    with (
        pytest.raises(RequestError, match=rf"folder cannot be written.*{os.strerror(code)}.*let its owner"),
        locked(tmp_path),
    ):
        pass


def test_a_lock_on_a_full_disk(tmp_path, monkeypatch):
    """That nobody can write down who holds it does not keep anybody from holding it."""

    def refuse(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("sweep.runs.locks.os.pwrite", refuse)
    with locked(tmp_path):
        assert (tmp_path / "lock").exists()


def test_no_right_is_not_no_room(tmp_path):
    """Where the right to write is missing, nobody is sent to free space."""
    with (
        pytest.raises(StorageError, match="give yourself the right to write there") as caught,
        refusals(tmp_path / "a"),
    ):
        raise PermissionError(errno.EACCES, "Permission denied", "a.nc.run/blocks/000000.tmp")
    assert "free some" not in str(caught.value)


def test_a_folder_that_goes_meanwhile(tmp_path):
    """If the run that held it ends and removes the folder, whoever waited to look at the lock makes a new one."""
    with locked(tmp_path / "a.nc.run"):
        assert (tmp_path / "a.nc.run" / "lock").exists()
