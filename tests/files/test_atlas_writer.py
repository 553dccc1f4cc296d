"""The file of an atlas while it is written: filters like those of HDF5, order, memory, and what the check finds."""

import errno
import threading
import time
import zlib
from itertools import pairwise

import h5py
import netCDF4
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.engine.compute import Block, run_blocks
from sweep.engine.grid import Span
from sweep.files import raw_chunks
from sweep.files.atlas_writer import AtlasWriter, regroup
from sweep.files.raw_chunks import RawChunks
from sweep.request.spec import SweepSpec

SPEC = SweepSpec(roll_rate="2:4:30", tilt="1deg:5deg:40")


@pytest.fixture
def small_chunks(monkeypatch):
    """Let a chunk hold 64 cells: here one row of 40."""
    monkeypatch.setattr("sweep.engine.grid.chunk_shape.__defaults__", (64,))
    monkeypatch.setattr("sweep.engine.grid.chunks.__defaults__", (64,))


@pytest.fixture
def written(tmp_path, small_chunks):
    """Return a writer whose file is complete, but not checked yet, and the path of that file."""
    writer = AtlasWriter(tmp_path / "a.nc", SPEC, {"title": "x"}, 2)
    for _ in writer.write_cells(run_blocks(SPEC)):
        pass
    writer.write_boundary()
    return writer, tmp_path / "a.nc"


@pytest.mark.parametrize("dtype", ["i1", "i4", "f4", "f8"])
@pytest.mark.parametrize("count", [40, 31])
def test_a_chunk_is_stored_as_hdf5_stores_it(tmp_path, dtype, count):
    """HDF5's own filters make a chunk that inflates to the same bytes, and read back what these make."""
    values = np.random.default_rng(1).normal(scale=50.0, size=count).astype(dtype)
    stored = raw_chunks.packed(values, 40)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in ("theirs", "ours"):
            file.create_dataset(
                name, (count,), dtype, chunks=(40,), maxshape=(None,), shuffle=True, compression=1
            )
        file["theirs"][...] = values
        file["ours"].id.write_direct_chunk((0,), stored)
        assert zlib.decompress(file["theirs"].id.read_direct_chunk((0,))[1]) == zlib.decompress(stored)
    with h5py.File(tmp_path / "a.h5") as file:
        np.testing.assert_array_equal(file["ours"][...], values)


def test_a_chunk_that_does_not_inflate_is_noticed(monkeypatch):
    """A bit that changes between the two filters ends the run: nothing wrong is written."""
    from isal import isal_zlib

    def spoilt(content, level):
        changed = content.copy()
        changed[7] ^= 1
        return compress(changed, level)

    compress = isal_zlib.compress
    monkeypatch.setattr(raw_chunks.isal_zlib, "compress", spoilt)
    with pytest.raises(OSError, match="does not inflate") as caught:
        raw_chunks.packed(np.arange(40.0), 40)
    assert caught.value.errno == errno.EIO


def test_the_check_passes_what_is_whole(written):
    """A file that nobody has touched is what was written; the caller hears how many cells have been looked at."""
    writer, _ = written
    heard = []
    writer.check(heard.append)
    assert heard == sorted(heard)
    assert 0.9 * SPEC.size < heard[-1] < SPEC.size


def in_a_stored_chunk(path):
    """Flip one bit of one stored chunk, in the bytes of the file."""
    with h5py.File(path) as file:
        place = file["tilt_max"].id.get_chunk_info_by_coord((17, 0))
    content = bytearray(path.read_bytes())
    content[place.byte_offset + place.size // 2] ^= 1
    path.write_bytes(content)


def a_whole_chunk(path):
    """Put a good chunk in the place of another one."""
    with h5py.File(path, "r+") as file:
        content = file["tilt_max"].id.read_direct_chunk((3, 0))[1]
        file["tilt_max"].id.write_direct_chunk((5, 0), content)


def a_coordinate(path):
    """Change a value that netCDF has written."""
    with netCDF4.Dataset(path, "a") as file:
        file["tilt"][11] += 1e-15


def an_attribute(path):
    """Change a text that stands beside a variable."""
    with netCDF4.Dataset(path, "a") as file:
        file["tilt_max"].units = "deg"


def a_missing_attribute(path):
    """Take an attribute away."""
    with netCDF4.Dataset(path, "a") as file:
        file["stability"].delncattr("flag_meanings")


def a_text_of_the_file(path):
    """Change what the file says of itself."""
    with netCDF4.Dataset(path, "a") as file:
        file.title = "another"


def the_boundary(path):
    """Change a value of the boundary."""
    with netCDF4.Dataset(path, "a") as file:
        file["boundary_roll_rate_status"][0] = 5


#: Rows along both rates, some with a lower edge; curves; no axis at all.
WRITTEN_WHOLE = {
    "both rates": SweepSpec(alpha="0.5,1", roll_rate="-4:4:9", precession_rate="0:2:4", tilt="1deg:9deg:3"),
    "curves": SweepSpec.preset("circling").replace(
        tilt="2deg:25deg:16", precession_rate="0.2:5:17", boundary="refined:1e-3"
    ),
    "one cell": SweepSpec(roll_rate=3.0),
}


def finished(path, spec):
    """Return the writer of a whole atlas."""
    writer = AtlasWriter(path, spec, {"title": "x"})
    for _ in writer.write_cells(run_blocks(spec)):
        pass
    writer.write_boundary()
    return writer


@pytest.mark.parametrize("name", WRITTEN_WHOLE)
def test_the_last_value_of_every_small_variable_is_checked(tmp_path, name):
    """Axes, edges and curves are written whole, and a change of their last value is found."""
    spec, path = WRITTEN_WHOLE[name], tmp_path / "a.nc"
    writer = finished(path, spec)
    writer.check()
    with netCDF4.Dataset(path) as file:
        names = [each.name for each in file.variables.values() if each.dimensions != spec.axes]
    assert any(name.startswith(("boundary_lower", "curve")) for name in names) == bool(spec.axes)
    for each in names:
        with netCDF4.Dataset(path, "a") as file:
            file.set_auto_maskandscale(False)
            last = (-1,) * file[each].ndim or ...
            before = file[each][last]
            file[each][last] = 3 if before != 3 else 4
        with pytest.raises(OSError, match=rf"\b{each}$"):
            writer.check()
        with netCDF4.Dataset(path, "a") as file:
            file.set_auto_maskandscale(False)
            file[each][last] = before
    writer.check()


@pytest.mark.parametrize(
    ("damage", "named"),
    [
        (in_a_stored_chunk, "tilt_max"),
        (a_whole_chunk, "tilt_max"),
        (a_coordinate, "tilt"),
        (the_boundary, "boundary_roll_rate_status"),
        (an_attribute, "units of tilt_max"),
        (a_missing_attribute, "the names of the attributes of stability"),
        (a_text_of_the_file, "title of the file"),
    ],
)
def test_the_check_finds_damage(written, damage, named):
    """Whatever has changed in the file since it was written, the check names the variable."""
    writer, path = written
    damage(path)
    with pytest.raises(OSError, match=rf"\b{named}\b"):
        writer.check()


@pytest.mark.parametrize("fault", ["left out", "past the filters"])
def test_the_check_finds_a_chunk_that_was_never_stored(tmp_path, small_chunks, monkeypatch, fault):
    """A chunk that is not there is no chunk of missing values, nor is one that HDF5 would not filter when it reads."""
    write = RawChunks.write

    def wrong(self, name, offset, content):
        if (name, offset) != ("steps", (9, 0)):
            write(self, name, offset, content)
        elif fault == "past the filters":
            self._identifier(name).write_direct_chunk(offset, content, 3)

    monkeypatch.setattr(RawChunks, "write", wrong)
    writer = AtlasWriter(tmp_path / "a.nc", SPEC, {})
    for _ in writer.write_cells(run_blocks(SPEC)):
        pass
    with pytest.raises(OSError, match=r"does not hold what was written: steps$"):
        writer.check()


def test_filters_that_netcdf_does_not_undo_are_noticed(written, monkeypatch):
    """The first chunk is read by netCDF, through its filters: a file that only we can read is refused."""
    monkeypatch.setattr(raw_chunks, "_shuffled", lambda values, cells: values.view(np.uint8))
    _, path = written
    writer = AtlasWriter(path, SPEC, {})
    for _ in writer.write_cells(run_blocks(SPEC)):
        pass
    with pytest.raises(OSError, match="does not hold what was written: tilt_min, tilt_max"):
        writer.check()


@pytest.mark.parametrize("threads", [1, 3])
def test_chunks_are_completed_in_threads_and_written_in_order(tmp_path, small_chunks, threads):
    """Chunks that are finished late are written in their place, and few of them are in the making at a time."""
    seen, taken, most = set(), [], []

    def slowly(span, columns):
        seen.add(threading.current_thread())
        time.sleep(0.02 if span.start // 40 % 3 == 0 else 0.0)
        return columns

    def blocks():
        for block in run_blocks(SPEC, block_cells=40):
            taken.append(block.span.start)
            yield block

    writer = AtlasWriter(tmp_path / "a.nc", SPEC, {}, threads)
    done = []
    for block in writer.write_cells(blocks(), slowly):
        done.append(block.span.start)
        most.append(len(taken) - len(done))
    assert done == list(range(0, SPEC.size, 40))
    assert len(seen) <= threads
    assert (len(seen) > 1) == (threads > 1)
    assert threading.current_thread() not in seen
    assert max(most) <= threads + 2


def test_a_writer_that_is_left_closes_its_file(tmp_path, small_chunks):
    """Whoever stops taking cells leaves no thread and no open file behind."""
    before = threading.active_count()
    writer = AtlasWriter(tmp_path / "a.nc", SPEC, {}, 2)
    cells = writer.write_cells(run_blocks(SPEC, block_cells=40))
    next(cells)
    cells.close()
    assert threading.active_count() == before
    with netCDF4.Dataset(tmp_path / "a.nc", "a") as file:
        assert file["tilt_max"].shape == SPEC.shape


@pytest.mark.parametrize(
    "problem", [ValueError("a defect"), KeyError("a defect"), OSError(errno.EIO, "refused")]
)
def test_the_error_of_a_block_passes(tmp_path, small_chunks, problem):
    """What goes wrong while cells are made is raised as it is: only errors of HDF5 are told as such."""

    def blocks():
        yield from run_blocks(SPEC.replace(roll_rate="2:4:10"), block_cells=40)
        raise problem

    def complete(span, columns):
        if span.start == 80:
            raise problem
        return columns

    for made, how in ((blocks(), ()), (run_blocks(SPEC), (complete,))):
        writer = AtlasWriter(tmp_path / "a.nc", SPEC, {}, 2)
        with pytest.raises(type(problem)) as caught:
            for _ in writer.write_cells(made, *how):
                pass
        assert caught.value is problem


def test_a_refusal_of_the_system_keeps_its_number(tmp_path):
    """HDF5 tells the error of the system in words only; here it has its number, so that the hint is the right one."""
    with pytest.raises(FileNotFoundError) as caught, RawChunks(tmp_path / "missing.nc", "r+"):
        pass
    assert str(caught.value) == "[Errno 2] No such file or directory"
    (tmp_path / "a.nc").write_bytes(b"no file of HDF5")
    with pytest.raises(OSError, match="HDF5: ") as caught, RawChunks(tmp_path / "a.nc", "r+"):
        pass
    assert caught.value.errno is None


CUTS = st.lists(st.integers(1, 12), min_size=1, max_size=12)


@given(st.data())
def test_regroup_regroups_and_loses_nothing(data):
    """Columns regrouped by any other cuts of the same cells are these cells, each once, in order."""
    blocks, spans = [], []
    counts = data.draw(CUTS)
    ends = np.cumsum(counts)
    values = np.arange(ends[-1])
    for start, stop in zip([0, *ends[:-1]], ends, strict=True):
        blocks.append(Block(Span(start, stop), {"a": values[start:stop], "b": -values[start:stop]}))
    inner = data.draw(st.sets(st.integers(1, int(ends[-1]))))
    edges = sorted({0, int(ends[-1]), *inner})
    spans = [Span(start, stop) for start, stop in pairwise(edges)]
    for span, block in zip(spans, regroup(blocks, spans), strict=True):
        assert block.span == span
        np.testing.assert_array_equal(block.columns["a"], values[span.start : span.stop])
        np.testing.assert_array_equal(block.columns["b"], -values[span.start : span.stop])


def test_regroup_asks_for_a_block_only_when_it_needs_it():
    """No more blocks are held than one span touches: memory stays bounded."""
    asked = []

    def blocks():
        for start in range(0, 100, 10):
            asked.append(start)
            yield Block(Span(start, start + 10), {"a": np.arange(start, start + 10)})

    spans = regroup(blocks(), [Span(start, start + 5) for start in range(0, 100, 5)])
    for _ in range(3):
        next(spans)
    assert asked == [0, 10]
