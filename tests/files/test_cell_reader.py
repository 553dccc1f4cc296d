"""Cells of an atlas read block by block: the same values from memory, through netCDF and without it, in any layout."""

import tracemalloc
import zlib

import numpy as np
import pytest
import xarray as xr

import sweep
from sweep.atlas.cf_metadata import cell_declarations
from sweep.engine.grid import BLOCK_CELLS, Span
from sweep.files import cell_reader
from sweep.files.cell_reader import CellReader, UnreadableError
from sweep.files.inflated_chunks import InflatedChunks
from sweep.request.spec import SweepSpec

#: Chunks of 67 x 299 x 3 cells: the last one along an axis is not full.
SPEC = SweepSpec.preset("rolling").replace(
    alpha="0.4:1:3", roll_rate="1:4:401", tilt="0.1deg:80deg:299", method="exact"
)
NAMES = [each.name for each in cell_declarations(SPEC)]


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas in memory with missing values in every variable that may have some."""
    dataset = sweep.run(SPEC)
    for number, name in enumerate(NAMES):
        if dataset[name].dtype.kind == "f":
            dataset[name].values.reshape(-1)[number :: 1000 + number] = np.nan
    return dataset


@pytest.fixture(scope="module")
def file(atlas, tmp_path_factory):
    """Return the file of that atlas."""
    path = tmp_path_factory.mktemp("atlas") / "a.nc"
    sweep.save(atlas, path)
    return path


def columns(reader):
    """Return all that a reader yields, joined."""
    parts = list(reader.blocks(NAMES))
    assert [span.start for span, _ in parts] == [0, *(span.stop for span, _ in parts[:-1])]
    assert all(len(span) <= BLOCK_CELLS for span, _ in parts)
    assert len(parts) > 1
    return {name: np.concatenate([each[name] for _, each in parts]) for name in NAMES}


def assert_same(found, atlas):
    """Assert that all values and types are those of an atlas."""
    for name in NAMES:
        assert found[name].dtype == atlas[name].dtype
        np.testing.assert_array_equal(found[name], atlas[name].values.reshape(-1))


def test_all_ways_give_the_same(atlas, file, monkeypatch):
    """From memory, through netCDF, without it, and as a whole."""
    with CellReader(atlas, NAMES) as reader:
        assert_same(columns(reader), atlas)
    with sweep.open_atlas(file) as opened:
        for path, whole in ((None, False), (file, False), (None, True)):
            with CellReader(opened, NAMES, path, whole) as reader:
                assert_same(columns(reader), atlas)
        # without netCDF means without
        with CellReader(opened, NAMES, file) as reader:
            monkeypatch.setattr(xr.Variable, "__getitem__", None)
            assert_same(columns(reader), atlas)


def test_any_span_can_be_read(atlas, file):
    """Within a chunk, over the ends of chunks, one cell, all cells."""
    spans = [
        (0, 1),
        (59799, 59801),
        (59800, 119600),
        (1, 59800),
        (59000, 150000),
        (180000, 180299),
        (0, SPEC.size),
    ]
    with sweep.open_atlas(file) as opened:
        for dataset, path in ((atlas, None), (opened, None), (opened, file)):
            with CellReader(dataset, NAMES, path) as reader:
                for start, stop in spans:
                    found = reader.read("tilt_max", Span(start, stop))
                    np.testing.assert_array_equal(found, atlas["tilt_max"].values.reshape(-1)[start:stop])


@pytest.mark.parametrize(
    "layout",
    [
        {"chunksizes": (3, 401, 5)},
        {"chunksizes": (1, 7, 299)},
        {"chunksizes": (3, 401, 299)},
        {"contiguous": True, "chunksizes": None, "zlib": False, "shuffle": False},
        {"zlib": False},
        {"shuffle": False},
        {"fletcher32": True},
        {"complevel": 9},
    ],
    ids=str,
)
def test_files_of_other_programs(atlas, tmp_path, layout):
    """Other chunks, other filters or none: netCDF reads what is not stored as this program does."""
    path = tmp_path / "other.nc"
    other = atlas.copy()
    for name in NAMES:
        other[name].encoding |= layout
    other.to_netcdf(path, format="NETCDF4_CLASSIC", engine="netcdf4")
    with sweep.open_atlas(path) as opened, CellReader(opened, NAMES, path) as reader:
        assert_same(columns(reader), atlas)


def test_a_damaged_chunk_is_named(command, file, tmp_path):
    """A stored chunk with a wrong byte is not taken for values; the message names the variable."""
    import h5py

    damaged = tmp_path / "damaged.nc"
    content = bytearray(file.read_bytes())
    with h5py.File(file) as opened:
        chunk = opened["tilt_max"].id.get_chunk_info(3)
    content[chunk.byte_offset + chunk.size // 2] ^= 1
    damaged.write_bytes(content)
    with InflatedChunks(damaged) as chunks:
        with h5py.File(file) as opened:
            out = np.empty(np.prod(opened["tilt_max"].chunks))
        assert chunks.read("tilt_min", chunk.chunk_offset, out)
        assert not chunks.read("tilt_max", chunk.chunk_offset, out)
    with sweep.open_atlas(damaged) as opened, CellReader(opened, NAMES, damaged) as reader:
        with pytest.raises(UnreadableError) as problem:
            columns(reader)
        assert problem.value.name == "tilt_max"
    status, _, message = command(f"verify {damaged}")
    assert (status, "tilt_max cannot be read" in message) == (2, True)
    status, _, message = command(f"compare {file} {damaged}")
    assert (status, "tilt_max cannot be read" in message, str(damaged) in message) == (2, True, True)


def test_a_chunk_of_another_size_is_not_taken(file, tmp_path):
    """One that inflates to fewer values, one that is not there, one that skipped a filter."""
    import h5py

    for number, (stored, mask) in enumerate([(zlib.compress(bytes(80)), 0), (None, 0), (bytes(480792), 3)]):
        copy = tmp_path / f"{number}.nc"
        copy.write_bytes(file.read_bytes())
        with h5py.File(copy, "r+") as opened:
            if stored is None:
                layout = {"chunks": opened["tilt_max"].chunks, "shuffle": True, "compression": "gzip"}
                del opened["tilt_max"]
                opened.create_dataset("tilt_max", (401, 299, 3), "f8", **layout)
            else:
                opened["tilt_max"].id.write_direct_chunk((0, 0, 0), stored, mask)
        with InflatedChunks(copy) as chunks, h5py.File(file) as opened:
            chunk = opened["tilt_max"].chunks
            out = np.empty(np.prod(chunk))
            assert chunks.fits("tilt_max", chunk, "f8")
            assert not chunks.read("tilt_max", (0, 0, 0), out)
            assert chunks.read("tilt_min", (0, 0, 0), out)


def test_only_some_blocks_are_in_memory(file, monkeypatch):
    """Reading all cells needs no more than three blocks of all variables."""
    monkeypatch.setattr(cell_reader, "BLOCK_CELLS", 1)
    with sweep.open_atlas(file) as opened:
        for path in (None, file):
            with CellReader(opened, NAMES, path) as reader:
                span = next(reader.spans())
                block = sum(len(span) * opened[name].dtype.itemsize for name in NAMES)
                tracemalloc.start()
                for _ in reader.blocks(NAMES):
                    pass
                peak = tracemalloc.get_traced_memory()[1]
                tracemalloc.stop()
                assert peak < 3 * block
