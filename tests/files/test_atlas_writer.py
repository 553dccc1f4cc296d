"""Writing an atlas: filters compatible with HDF5, order, memory, and the result as netCDF reads it."""

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
from kernel_runner import run_blocks
from messages import assert_facts, refused

import sweep
from sweep.engine.compute import Block
from sweep.engine.grid import Span
from sweep.files import raw_chunks
from sweep.files.atlas_writer import AtlasWriter, regroup
from sweep.files.raw_chunks import RawChunks
from sweep.request.spec import SweepSpec

SPEC = SweepSpec(roll_rate="2:4:30", tilt="1deg:5deg:40")


@pytest.fixture
def small_chunks(monkeypatch):
    """Make a chunk hold 64 cells, here one row of 40."""
    monkeypatch.setattr("sweep.engine.grid.chunk_shape.__defaults__", (64,))
    monkeypatch.setattr("sweep.engine.grid.chunks.__defaults__", (64,))


@pytest.mark.parametrize("dtype", ["i1", "i4", "f4", "f8"])
@pytest.mark.parametrize("count", [40, 31])
def test_a_chunk_is_stored_as_hdf5_stores_it(tmp_path, dtype, count):
    """HDF5's own filters give a chunk with the same content, and each side reads the other's chunks."""
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
    """A bit that flips between the two filters ends the run, so that no wrong data are written."""
    from isal import isal_zlib

    def spoilt(content, level):
        changed = content.copy()
        changed[7] ^= 1
        return compress(changed, level)

    compress = isal_zlib.compress
    monkeypatch.setattr(raw_chunks.isal_zlib, "compress", spoilt)
    with refused("inflate", error=OSError) as caught:
        raw_chunks.packed(np.arange(40.0), 40)
    assert caught.value.errno == errno.EIO


#: Rows along both rates, some with a lower edge; curves; no axis; several chunks.
WRITTEN_WHOLE = {
    "both rates": SweepSpec(alpha="0.5,1", roll_rate="-4:4:9", precession_rate="0:2:4", tilt="1deg:9deg:3"),
    "curves": SweepSpec.preset("circling").replace(
        tilt="2deg:25deg:16", precession_rate="0.2:5:17", boundary="refined:1e-3"
    ),
    "one cell": SweepSpec(roll_rate=3.0),
    "chunks": SPEC,
}


@pytest.mark.parametrize("name", WRITTEN_WHOLE)
def test_netcdf_reads_what_was_written(tmp_path, small_chunks, name):
    """Every value and attribute can be read through the filters of netCDF's own library."""
    spec, path = WRITTEN_WHOLE[name], tmp_path / "a.nc"
    writer = AtlasWriter(path, spec, {"title": "x"}, 2)
    for _ in writer.write_cells(run_blocks(spec)):
        pass
    writer.write_boundary()
    expected = sweep.run(spec)
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        assert file.title == "x"
        assert set(file.variables) == set(map(str, expected.variables))
        for each, values in expected.variables.items():
            stored, fill = file[each], values.encoding.get("_FillValue")
            held = values.values if fill is None else np.where(np.isnan(values.values), fill, values.values)
            np.testing.assert_array_equal(stored[...], held, each)
            attributes = dict(values.attrs)
            attributes |= (
                {"coordinates": values.encoding["coordinates"]} if "coordinates" in values.encoding else {}
            )
            attributes |= {} if fill is None else {"_FillValue": fill}
            assert set(stored.ncattrs()) == attributes.keys()
            for key, value in attributes.items():
                np.testing.assert_array_equal(stored.getncattr(key), value, f"{each}:{key}")


@pytest.mark.parametrize("threads", [1, 3])
def test_chunks_are_completed_in_threads_and_written_in_order(tmp_path, small_chunks, threads):
    """Chunks that finish late are written in their place, and only a few are in progress at a time."""
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
    """A caller that stops early leaves no thread and no open file behind."""
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
    """Errors while computing cells are raised unchanged; only errors of HDF5 are converted."""

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
    """HDF5 gives system errors only as text; they get their number back, so that the hint is right."""
    with pytest.raises(FileNotFoundError) as caught, RawChunks(tmp_path / "missing.nc"):
        pass
    assert_facts(str(caught.value), "[Errno 2] No such file or directory")
    (tmp_path / "a.nc").write_bytes(b"no file of HDF5")
    with pytest.raises(OSError, match="HDF5: ") as caught, RawChunks(tmp_path / "a.nc"):
        pass
    assert caught.value.errno is None


CUTS = st.lists(st.integers(1, 12), min_size=1, max_size=12)


@given(st.data())
def test_regroup_regroups_and_loses_nothing(data):
    """Regrouping with any other cuts keeps all cells once and in order."""
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
    """At most the blocks that one span touches are held, so memory stays bounded."""
    asked = []

    def blocks():
        for start in range(0, 100, 10):
            asked.append(start)
            yield Block(Span(start, start + 10), {"a": np.arange(start, start + 10)})

    spans = regroup(blocks(), [Span(start, start + 5) for start in range(0, 100, 5)])
    for _ in range(3):
        next(spans)
    assert asked == [0, 10]
