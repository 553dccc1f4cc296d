"""Reading an atlas block by block: the same values from memory and from files of any layout."""

import tracemalloc

import numpy as np
import pytest
from messages import assert_facts

import sweep
from sweep.atlas.cf_metadata import cell_declarations
from sweep.engine.grid import BLOCK_CELLS, Span
from sweep.files import cell_reader
from sweep.files.cell_reader import CellReader, UnreadableError
from sweep.request.spec import SweepSpec

#: Chunks of 67 x 299 x 3 cells; the last one along an axis is partly filled.
SPEC = SweepSpec.preset("rolling").replace(
    alpha="0.4:1:3", roll_rate="1:4:401", tilt="0.1deg:80deg:299", method="exact"
)
NAMES = [each.name for each in cell_declarations(SPEC)]


@pytest.fixture(scope="module")
def atlas():
    """Return an atlas in memory with missing values in every variable that may have them."""
    dataset = sweep.run(SPEC)
    for number, name in enumerate(NAMES):
        if dataset[name].dtype.kind == "f":
            dataset[name].values.reshape(-1)[number :: 1000 + number] = np.nan
    return dataset


@pytest.fixture(scope="module")
def file(atlas, tmp_path_factory):
    """Return the path of a file of that atlas."""
    path = tmp_path_factory.mktemp("atlas") / "a.nc"
    sweep.save(atlas, path)
    return path


def columns(reader):
    """Return the joined blocks of a reader."""
    parts = list(reader.blocks(NAMES))
    assert [span.start for span, _ in parts] == [0, *(span.stop for span, _ in parts[:-1])]
    assert all(len(span) <= BLOCK_CELLS for span, _ in parts)
    assert len(parts) > 1
    return {name: np.concatenate([each[name] for _, each in parts]) for name in NAMES}


def assert_same(found, atlas):
    """Assert that all values and types equal those of an atlas."""
    for name in NAMES:
        assert found[name].dtype == atlas[name].dtype
        np.testing.assert_array_equal(found[name], atlas[name].values.reshape(-1))


def test_all_ways_give_the_same(atlas, file):
    """Reading from memory, from a file in blocks and from a file as a whole gives the same."""
    assert_same(columns(CellReader(atlas, NAMES)), atlas)
    with sweep.open_atlas(file) as opened:
        for whole in (False, True):
            assert_same(columns(CellReader(opened, NAMES, whole)), atlas)


def test_any_span_can_be_read(atlas, file):
    """Spans within a chunk, across chunks, of one cell and of all cells can be read."""
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
        for dataset in (atlas, opened):
            reader = CellReader(dataset, NAMES)
            for start, stop in spans:
                found = reader.read("tilt_max", Span(start, stop))
                np.testing.assert_array_equal(found, atlas["tilt_max"].values.reshape(-1)[start:stop])


@pytest.mark.slow_lane
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
    """Files with other chunks, and with other filters or none, can be read."""
    path = tmp_path / "other.nc"
    other = atlas.copy()
    for name in NAMES:
        other[name].encoding |= layout
    other.to_netcdf(path, format="NETCDF4_CLASSIC", engine="netcdf4")
    with sweep.open_atlas(path) as opened:
        assert_same(columns(CellReader(opened, NAMES)), atlas)


def test_a_damaged_chunk_is_named(command, file, tmp_path):
    """A stored chunk with a wrong byte is refused with the name of the variable."""
    import h5py

    damaged = tmp_path / "damaged.nc"
    content = bytearray(file.read_bytes())
    with h5py.File(file) as opened:
        chunk = opened["tilt_max"].id.get_chunk_info(3)
    content[chunk.byte_offset + chunk.size // 2] ^= 1
    damaged.write_bytes(content)
    with sweep.open_atlas(damaged) as opened:
        with pytest.raises(UnreadableError) as problem:
            columns(CellReader(opened, NAMES))
        assert problem.value.name == "tilt_max"
    status, _, message = command(f"verify {damaged}")
    assert status == 2
    assert_facts(message, "tilt_max", "HDF error")
    status, _, message = command(f"compare {file} {damaged}")
    assert status == 2
    assert_facts(message, f"{damaged}:", "tilt_max", "HDF error")


def test_only_some_blocks_are_in_memory(file, monkeypatch):
    """Reading all cells keeps at most three blocks of all variables in memory."""
    monkeypatch.setattr(cell_reader, "BLOCK_CELLS", 1)
    with sweep.open_atlas(file) as opened:
        reader = CellReader(opened, NAMES)
        span = next(reader.spans())
        block = sum(len(span) * opened[name].dtype.itemsize for name in NAMES)
        tracemalloc.start()
        for _ in reader.blocks(NAMES):
            pass
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 3 * block
