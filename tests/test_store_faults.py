"""A file at its final name is complete or absent, whatever goes wrong, and what cannot work is refused beforehand."""

import errno
import os
import shutil
from collections import namedtuple

import netCDF4
import pytest

from sweep.atlas.cf_metadata import FORMAT
from sweep.engine import estimate
from sweep.errors import RequestError, StorageError
from sweep.files import publish, store
from sweep.files.reading import open_atlas
from sweep.request.spec import SweepSpec
from sweep.runs import executor as driving
from sweep.runs import run_directory as claims
from sweep.runs.run import run_to_file

SPEC = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Files of one spec bear one date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture
def path(tmp_path):
    """Return where a test writes its atlas."""
    return tmp_path / "atlas.nc"


def refused(match, function, *arguments, **options):
    """Assert that a call is refused with a place, a message and a hint, and return the whole text."""
    with pytest.raises(RequestError, match=match) as caught:
        function(*arguments, **options)
    error = caught.value
    assert all((error.where, error.message, error.hint))
    return str(error)


@pytest.mark.parametrize("existing", [False, True], ids=["new", "overwrite"])
@pytest.mark.parametrize(
    ("fault", "seen"),
    [
        (KeyboardInterrupt(), KeyboardInterrupt),
        (ValueError("a defect"), ValueError),
        (RuntimeError("a defect"), RuntimeError),
        (OSError(errno.ENOSPC, "No space left on device"), StorageError),
        (RuntimeError("NetCDF: HDF error"), StorageError),
    ],
    ids=lambda each: repr(each) if isinstance(each, BaseException) else "",
)
def test_a_run_that_breaks_keeps_its_blocks(path, monkeypatch, fault, seen, existing):
    """Whatever ends a run between two blocks, no new file is there, an old one is as it was, and the run goes on."""

    def breaking(spec, span):
        if span.start == 10:
            raise fault
        return compute(spec, span)

    compute = driving.compute
    run_to_file(SPEC, path, command="x", block_cells=5)
    whole = path.read_bytes()
    path.unlink()
    if existing:
        path.write_bytes(b"old")
    monkeypatch.setattr(driving, "compute", breaking)
    with pytest.raises(seen):
        run_to_file(SPEC, path, overwrite=existing, command="x", block_cells=5)
    assert [each.read_bytes() for each in path.parent.glob("*.nc")] == [b"old"] * existing
    assert sorted(each.name for each in path.parent.iterdir()) == ["atlas.nc", "atlas.nc.run"][1 - existing :]
    spans = []
    monkeypatch.setattr(driving, "compute", lambda spec, span: spans.append(span) or compute(spec, span))
    heard = []
    run_to_file(SPEC, path, overwrite=existing, say=heard.append)
    assert [span.start for span in spans] == [10, 15]
    assert heard == ["going on: 2 of 4 blocks are there, 2 to compute"]
    assert path.read_bytes() == whole
    assert list(path.parent.iterdir()) == [path]


def test_a_run_that_breaks_before_its_first_block_leaves_nothing(path, monkeypatch):
    """If nothing was computed there is nothing to keep."""
    monkeypatch.setattr(driving, "compute", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run_to_file(SPEC, path)
    assert list(path.parent.iterdir()) == []


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_file_system_that_refuses_at_the_end(path, monkeypatch, step):
    """If the finished file cannot be made safe or be named, that is said, and its blocks are kept."""
    real = getattr(os, step)

    def refuse(*arguments):
        # the manifest and the blocks pass; the file does not
        if str(arguments[0]).endswith("assembled.nc") or list(path.parent.glob("*/published.json")):
            raise OSError(errno.EIO, "Input/output error")
        return real(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(publish.os, step, refuse)
        text = refused(r"could not be written.*Input/output error.*MB are free", run_to_file, SPEC, path)
    assert f"1 of 1 blocks are kept in {path}.run" in text
    assert not path.exists()
    run_to_file(SPEC, path)
    assert list(path.parent.iterdir()) == [path]


def test_the_final_name_appears_last(path):
    """While blocks are computed the final name does not exist, and afterwards nothing else does."""
    seen = []
    run_to_file(SPEC, path, block_cells=5, progress=lambda *_: seen.append(path.exists()))
    assert seen == [False] * 4
    assert list(path.parent.iterdir()) == [path]


def test_the_disk_is_asked_to_keep_each_file_before_it_gets_its_name(path, monkeypatch):
    """Manifest, block, record and file: the content is synchronised, the name given, the folder synchronised."""
    steps = []
    for step in ("fsync", "replace"):
        real = getattr(os, step)
        monkeypatch.setattr(publish.os, step, lambda *a, step=step, real=real: steps.append(step) or real(*a))
    run_to_file(SPEC, path)
    # the new folder too is a name that must survive
    assert steps == ["fsync", "replace", "fsync", "fsync"] + ["fsync", "replace", "fsync"] * 3


def test_an_existing_file_is_not_replaced_by_accident(path):
    """Without overwrite an existing file is refused before anything is computed; with it, it is replaced."""
    path.write_bytes(b"old")
    text = refused("the file exists", run_to_file, SPEC, path)
    assert text.startswith(f"{path}: ")
    assert "--overwrite" in text
    assert path.read_bytes() == b"old"
    run_to_file(SPEC, path, overwrite=True)
    with open_atlas(path) as read:
        assert read.sizes == {"tilt": 20}
        refused("the file exists", store.save, read, path)


def test_targets_that_are_no_files(tmp_path):
    """A folder, a pipe, a missing folder and a file in a folder's place are refused, overwrite or not."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "file").write_bytes(b"")
    before = sorted(tmp_path.iterdir())
    for name, what in [
        (".", "not a file"),
        ("pipe", "not a file"),
        ("missing/x.nc", "no such folder"),
        ("file/x.nc", "no such folder"),
        ("y" * 300 + "/x.nc", "no such folder"),
        ("y" * 300, "could not be written"),
        ("y" * 254, "could not be written"),
    ]:
        refused(what, run_to_file, SPEC, tmp_path / name, overwrite=True)
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_that_cannot_be_written(path, monkeypatch):
    """A folder without permission is refused beforehand."""
    # root may write anywhere: the answer of the system is put in its mouth
    monkeypatch.setattr(store.os, "access", lambda *_: False)
    assert str(path.parent) in refused("folder cannot be written", run_to_file, SPEC, path)


def test_a_disk_that_is_too_small(path, monkeypatch):
    """The room for atlas and journal is looked for before anything is computed; a disk that is large enough will do."""
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(estimate.shutil, "disk_usage", lambda _: usage(10**9, 0, 10**6))
    monkeypatch.setattr(driving, "compute", None)
    monkeypatch.setattr(claims.calibrate, "block_cells", None)
    large = SPEC.replace(tilt="1deg:5deg:20000")
    text = refused("does not fit on the disk", run_to_file, large, path)
    assert "1.0 MB free" in text
    assert list(path.parent.iterdir()) == []
    estimate.check_room(path, 0.9e6)


def test_the_room_that_is_asked_for_is_enough(path, monkeypatch):
    """Neither the journal nor an atlas of the presets' kind is larger than what is looked for beforehand."""
    spec = SweepSpec.preset("rolling").replace(roll_rate="2:4:150", tilt="0.001deg:5deg:100:log")
    taken = []

    def measure(done, _):
        files = path.parent.glob("atlas.nc.run/blocks/*.npz")
        taken.append((done, sum(each.stat().st_size for each in files)))

    run_to_file(spec, path, block_cells=5000, progress=measure)
    for done, size in taken:
        # no more than what does not follow from the rest, no less than what never repeats
        assert spec.size / 3 * 24 <= size <= estimate.journal_bytes(spec, spec.size)
        assert done <= spec.size
    assert path.stat().st_size < estimate.file_bytes(spec)


def test_files_that_are_no_atlas(path, tmp_path):
    """A missing file, a folder, text, a cut file and another's netCDF are refused under their names."""
    run_to_file(SPEC, path)
    whole = path.read_bytes()
    contents = {
        "text.nc": b"tilt,rate\n",
        "empty.nc": b"",
        "cut.nc": whole[:-2],
        "half.nc": whole[: len(whole) // 2],
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
        assert refused("not a readable netCDF file", open_atlas, tmp_path / name).startswith(
            str(tmp_path / name)
        )
    with netCDF4.Dataset(tmp_path / "foreign.nc", "w") as file:
        file.title = "Ocean"
    assert "Ocean" in refused("not a stability atlas", open_atlas, tmp_path / "foreign.nc")
    for name in ("missing.nc", "", "y" * 300):
        refused("no such file", open_atlas, tmp_path / name)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda file: file.setncattr("eulerdisk_format", FORMAT + 1),
            "newer than this program",
        ),
        (lambda file: file.delncattr("sweep_spec"), "not a stability atlas"),
        (lambda file: file.renameVariable("tilt_min", "least"), "without its measures.*tilt_min"),
    ],
)
def test_atlases_that_this_version_cannot_read(path, change, message):
    """A newer format and missing parts are refused, and the file is closed again."""
    run_to_file(SPEC, path)
    with netCDF4.Dataset(path, "a") as file:
        change(file)
    refused(message, open_atlas, path)
    # HDF5 locks a file that is open for reading against writers
    netCDF4.Dataset(path, "a").close()


def test_free_space_is_that_of_the_output_folder(path, monkeypatch):
    """The disk that is asked is the one of the output, not of the working folder."""
    asked = []
    real = shutil.disk_usage
    monkeypatch.setattr(estimate.shutil, "disk_usage", lambda folder: asked.append(folder) or real(folder))
    estimate.check_room(path, 1.0)
    assert asked == [path.parent]
