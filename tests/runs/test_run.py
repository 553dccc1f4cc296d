"""After every fault the file of a run is complete or absent; impossible runs are refused before they start."""

import errno
import json
import os
import tracemalloc
from functools import partial

import netCDF4
import numpy as np
import pytest
from messages import assert_facts, assert_in_order, refused

from kernels.native import workers
from sweep.engine import compute, grid
from sweep.engine.compute import Block, usable_threads
from sweep.engine.grid import Span
from sweep.errors import StoppedError, StorageError
from sweep.files import atlas_writer, paths, publish
from sweep.files.atlas_writer import AtlasWriter
from sweep.files.netcdf import save
from sweep.files.reading import open_atlas
from sweep.progress.timetable import COMPUTING
from sweep.request.spec import SweepSpec
from sweep.runs import array_jobs, executor, forecast, run
from sweep.runs.forecast import of_run
from sweep.runs.run import run_to_file

SPEC = SweepSpec(tilt="1deg:5deg:20", roll_rate=3)


@pytest.fixture(autouse=True)
def fixed_time(monkeypatch):
    """Give all files of a spec the same date."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


@pytest.fixture
def path(tmp_path):
    """Return the path of a test's atlas."""
    return tmp_path / "atlas.nc"


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
    """After a stop between two blocks there is no new file, an old one is unchanged, and the run resumes."""

    def breaking(spec, span):
        if span.start == 10:
            raise fault
        return measure_block(spec, span)

    measure_block = executor.measure_block
    run_to_file(SPEC, path, command="x", block_cells=5)
    whole = path.read_bytes()
    path.unlink()
    if existing:
        path.write_bytes(b"old")
    monkeypatch.setattr(executor, "measure_block", breaking)
    with pytest.raises(seen):
        run_to_file(SPEC, path, overwrite=existing, command="x", block_cells=5)
    assert [each.read_bytes() for each in path.parent.glob("*.nc")] == [b"old"] * existing
    assert sorted(each.name for each in path.parent.iterdir()) == ["atlas.nc", "atlas.nc.run"][1 - existing :]
    spans = []
    monkeypatch.setattr(
        executor, "measure_block", lambda spec, span: spans.append(span) or measure_block(spec, span)
    )
    heard = []
    run_to_file(SPEC, path, overwrite=existing, say=heard.append)
    assert [span.start for span in spans] == [10, 15]
    (line,) = heard
    assert_in_order(line, "2 of 4 blocks", "2")
    assert path.read_bytes() == whole
    assert list(path.parent.iterdir()) == [path]


def test_a_run_that_breaks_before_its_first_block_leaves_nothing(path, monkeypatch):
    """If nothing was computed, nothing is kept."""
    monkeypatch.setattr(executor, "measure_block", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run_to_file(SPEC, path)
    assert list(path.parent.iterdir()) == []


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_file_system_that_refuses_at_the_end(path, monkeypatch, step):
    """If the finished file cannot be synchronized or named, the error says so, and the blocks are kept."""
    real = getattr(os, step)

    def refuse(*arguments):
        # The manifest and the blocks pass; the file does not.
        if str(arguments[0]).endswith("assembled.nc") or list(path.parent.glob("*/published.json")):
            raise OSError(errno.EIO, "Input/output error")
        return real(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(publish.os, step, refuse)
        with refused("Input/output error", "1 of 1 block", f"{path}.run"):
            run_to_file(SPEC, path)
    assert not path.exists()
    run_to_file(SPEC, path)
    assert list(path.parent.iterdir()) == [path]


def test_an_existing_file_is_not_replaced_by_accident(path):
    """Without overwrite an existing file is refused before anything is computed; with it, it is replaced."""
    path.write_bytes(b"old")
    with refused(f"{path}:", "--overwrite"):
        run_to_file(SPEC, path)
    assert path.read_bytes() == b"old"
    run_to_file(SPEC, path, overwrite=True)
    with open_atlas(path) as read:
        assert read.sizes == {"tilt": 20}
        with refused(f"{path}:", "--overwrite"):
            save(read, path)


def test_targets_that_are_no_files(tmp_path):
    """A folder, a pipe, a missing folder and a file instead of a folder are refused, even with overwrite."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "file").write_bytes(b"")
    before = sorted(tmp_path.iterdir())
    for name, fact in [
        (".", "file"),
        ("pipe", "file"),
        ("missing/x.nc", "mkdir -p"),
        ("file/x.nc", "folder"),
        ("y" * 300 + "/x.nc", "folder"),
        ("y" * 300, "name"),
        ("y" * 254, "made"),
    ]:
        with refused(fact):
            run_to_file(SPEC, tmp_path / name, overwrite=True)
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_that_cannot_be_written(path, monkeypatch):
    """A folder without write permission is refused in advance."""
    # Root may write anywhere, so the system's answer is replaced.
    monkeypatch.setattr(paths.os, "access", lambda *_: False)
    with refused(str(path.parent), "folder", "writable"):
        run_to_file(SPEC, path)


def test_a_disk_that_is_too_small(path, machine, monkeypatch):
    """Room for atlas and journal is checked before anything is computed; a large enough disk passes."""
    machine(free_bytes=1e6)
    monkeypatch.setattr(executor, "measure_block", None)
    monkeypatch.setattr(forecast, "block_cells", None)
    large = SPEC.replace(tilt="1deg:5deg:20000")
    with refused("disk", "1.0 MB"):
        run_to_file(large, path)
    assert list(path.parent.iterdir()) == []
    publish.check_room(path, 0.9e6)


def test_a_run_that_goes_on_needs_room_for_the_rest(path, machine):
    """With half of its blocks done, it needs less room than a new run."""
    spec = SPEC.replace(tilt="1deg:5deg:1000")
    journal = array_jobs.prepare(spec, path, block_cells=spec.size // 2)
    array_jobs.compute_part(journal.folder, 1, 2)
    done = journal.cells(journal.held())
    assert 0 < done < spec.size
    rest, whole = (
        forecast.file_bytes(spec) + forecast.journal_bytes(spec, n) for n in (spec.size - done, spec.size)
    )
    machine(free_bytes=0.5 * (rest + whole))
    with refused("disk"):
        run_to_file(spec, path.with_name("other.nc"))
    run_to_file(spec, path)
    assert path.exists()


def test_a_run_that_goes_on_needs_room_too(path, machine, monkeypatch):
    """Its blocks are kept, and nothing is computed."""
    large = SPEC.replace(tilt="1deg:5deg:20000")
    journal = array_jobs.prepare(large, path, block_cells=10_000)
    array_jobs.compute_part(journal.folder, 1, 2)
    held = journal.held()
    machine(free_bytes=1e6)
    monkeypatch.setattr(executor, "measure_block", None)
    with refused("disk"):
        run_to_file(large, path)
    assert journal.held() == held != {}


def test_the_room_that_is_asked_for_is_enough(path, monkeypatch):
    """Neither the journal nor an atlas like the presets exceeds the room that is checked in advance."""
    spec = SweepSpec.preset("rolling").replace(roll_rate="2:4:150", tilt="0.001deg:5deg:100:log")
    taken = []

    def measure(status):
        files = path.parent.glob("atlas.nc.run/blocks/*.block")
        if status.stage == COMPUTING and status.done:
            taken.append((status.done, sum(each.stat().st_size for each in files)))

    run_to_file(spec, path, block_cells=5000, progress=measure)
    for done, size in taken:
        # At most what cannot be derived, and at least what never repeats.
        assert spec.size / 3 * 24 <= size <= forecast.journal_bytes(spec, spec.size)
        assert done <= spec.size
    assert path.stat().st_size < forecast.file_bytes(spec)


def test_no_file_is_named_before_its_content_is_on_the_disk(path, monkeypatch):
    """A power cut loses nothing: content is synchronized before it gets a name, names before the run ends."""
    safe, unsafe_names = {}, set()
    fsync, replace = os.fsync, os.replace

    def state(status):
        return status.st_size, status.st_mtime_ns

    def noted_fsync(handle):
        fsync(handle)
        status = os.fstat(handle)
        safe[status.st_ino] = state(status)
        unsafe_names.difference_update(
            {each for each in unsafe_names if os.stat(each[0]).st_ino == status.st_ino}
        )

    def noted_replace(source, target):
        status = os.stat(source)
        assert safe.get(status.st_ino) == state(status), f"{target} was named before it was synchronised"
        replace(source, target)
        unsafe_names.add((os.path.dirname(target), os.path.basename(target)))

    monkeypatch.setattr(publish.os, "fsync", noted_fsync)
    monkeypatch.setattr(publish.os, "replace", noted_replace)

    run_to_file(SPEC, path, block_cells=5)
    assert path.exists()
    assert len(safe) >= 7, "manifest, four blocks, record and file"
    assert unsafe_names == set()


def test_a_program_of_another_version_goes_on(path, monkeypatch):
    """A release that computes the same bits resumes an earlier one's blocks and gives the same file."""
    run_to_file(SPEC, path, command="x", block_cells=5)
    whole = path.read_bytes()
    path.unlink()
    asked = iter(range(1000))
    monkeypatch.setattr("sweep.version.__version__", "0.0.1")
    with pytest.raises(StoppedError):
        run_to_file(SPEC, path, command="x", block_cells=5, stopping=lambda: next(asked) > 4)
    manifest = json.loads((path.parent / "atlas.nc.run" / "manifest.json").read_text())
    assert "eulerdisk" not in manifest["arithmetic"]
    monkeypatch.undo()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    heard = []
    run_to_file(SPEC, path, say=heard.append)
    assert heard[0].startswith("resuming: ")
    assert path.read_bytes() == whole


def test_failed_cells_are_counted_while_they_are_written(path, monkeypatch):
    """Failures are counted without rereading the cells, however the cells are divided into blocks."""
    opened, dataset = [], netCDF4.Dataset
    monkeypatch.setattr(
        netCDF4, "Dataset", lambda *args, **how: opened.append(args[1:]) or dataset(*args, **how)
    )
    spec = SweepSpec(tilt="1deg:9deg:12", precession_rate="-1:1:3", roll_rate="steady")
    failures = run_to_file(spec, path, block_cells=5)
    assert opened == [("w",), ("a",), ("a",)]
    assert failures.total == 12
    assert failures.describe() == run.Failures.in_file(path, spec).describe()
    monkeypatch.setattr("sweep.engine.grid.chunk_shape.__defaults__", (7,))
    monkeypatch.setattr("sweep.engine.grid.chunks.__defaults__", (7,))
    assert failures.describe() == run.Failures.in_file(path, spec).describe(), "in chunks of any size"
    assert len(failures.describe()) == 12, "a line for all, ten cells and dots"
    assert failures.describe()[1].split(":")[0].split() == ["tilt=1deg", "precession_rate=0"]


def test_a_run_that_was_published_says_what_failed(path, monkeypatch):
    """A run killed between publishing and removing its folder reads the failed cells from its file."""
    spec = SweepSpec(tilt="1deg:9deg:3", precession_rate="-1:1:3", roll_rate="steady")
    with monkeypatch.context() as patch:
        patch.setattr(run.run_directory, "remove", lambda _: None)
        told = run_to_file(spec, path).describe()
    assert run_to_file(spec, path).describe() == told
    assert list(path.parent.iterdir()) == [path]


def test_the_bisection_uses_the_threads_of_the_run(path, monkeypatch):
    """The boundary search uses as many threads as the computation of the blocks."""
    used = []

    def searched(*arguments):
        used.append(workers.used())
        return found(*arguments)

    found = atlas_writer.boundaries
    monkeypatch.setattr(atlas_writer, "boundaries", searched)
    for threads in (1, None):
        run_to_file(SPEC, path, overwrite=True, threads=threads)
    assert used == [1, usable_threads(None)]


@pytest.mark.slow_lane
def test_no_array_of_the_whole_grid_is_held(path):
    """From measured cells to the file, 7 million more cells take less than 7 MB more."""

    def peak(rows):
        spec = SweepSpec(roll_rate=f"2:4:{rows}", tilt="1deg:5deg:1000", duration=0.05)
        few = compute.measure_block(spec, Span(0, 50_000))
        blocks = (Block(span, few) for span in grid.blocks(spec.size, 50_000))
        tracemalloc.start()
        writer = AtlasWriter(path, spec, {})
        cells = writer.write_cells(blocks, partial(compute.derive_block, spec))
        run.write_atlas(writer, cells, of_run(spec, 0, None, executor.no_op))
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most

    # Up to 4.5e6 of these bytes vary, as the threads decide how many chunks are in progress at a time.
    small = peak(800)
    assert peak(8000) < small + 6e6


def test_a_run_is_stopped_after_its_last_block_too(path):
    """A stop during the search ends the run; all blocks are kept, and the next run completes the file."""
    spec, seen, stage = SPEC.replace(boundary="refined"), [], "searching the boundary"

    with refused("1 of 1 block", error=StoppedError):
        run_to_file(
            spec, path, progress=lambda status: seen.append(status.stage), stopping=lambda: stage in seen
        )
    assert not path.exists()
    run_to_file(spec, path)
    assert path.exists()


def test_the_result_says_what_failed(tmp_path):
    """In a notebook or at a prompt its repr says that all cells succeeded, or which failed."""
    well = run_to_file(SweepSpec(tilt="1deg:5deg:4", roll_rate=3), tmp_path / "a.nc")
    assert_facts(repr(well), "all 4 cells")
    failed = run.Failures(well.spec)
    ending = np.full(4, next(iter(failed._counts)), np.int8)
    failed.count(0, {"ending": ending, "stability": np.zeros(4, np.int8)})
    assert repr(failed) == "\n".join(failed.describe())
    assert_facts(repr(failed), "4 of 4 cells")
