"""The grid of a spec: its chunks, its blocks and the starts of its cells."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sweep.engine.grid import (
    BLOCK_CELLS,
    CHUNK_CELLS,
    Span,
    blocks,
    chunk_shape,
    chunks,
    completed,
    starts_of,
    whole,
)
from sweep.model.disk.tables import PARAMETERS
from sweep.request.spec import SweepSpec

SHAPES = st.lists(st.integers(1, 9), min_size=0, max_size=4).map(tuple)


@given(SHAPES, st.integers(1, 200))
def test_chunks_partition_the_grid_in_c_order(shape, cells):
    """The chunks cover every cell once and in C order, and the spans number them."""
    numbers = np.arange(math.prod(shape)).reshape(shape)
    place = 0
    for span, slices in chunks(shape, cells):
        inside = numbers[slices].ravel()
        assert list(inside) == list(range(span.start, span.stop))
        assert span.start == place
        assert 1 <= len(span) <= cells
        place = span.stop
    assert place == numbers.size


@given(SHAPES, st.integers(1, 200))
def test_chunks_have_one_shape(shape, cells):
    """All chunks have the chunk shape, except those cut off at the end of an axis."""
    shares = chunk_shape(shape, cells)
    for _, slices in chunks(shape, cells):
        for n, share, part in zip(shape, shares, slices, strict=True):
            assert part.start % share == 0
            assert part.stop == min(n, part.start + share)


@given(SHAPES, st.integers(1, 200))
def test_chunks_are_not_wasteful(shape, cells):
    """There are at most twice as many chunks as the size limit requires."""
    cut = [
        axis
        for axis, (n, share) in enumerate(zip(shape, chunk_shape(shape, cells), strict=True))
        if share < n
    ]
    if not cut:
        assert len(list(chunks(shape, cells))) == 1
        return
    axis = max(cut)
    row = math.prod(shape[axis + 1 :])
    fewest = math.ceil(shape[axis] * row / cells)
    assert len(list(chunks(shape, cells))) <= 2 * fewest * math.prod(shape[:axis])


def test_the_chunks_of_a_large_grid():
    """A million cells make 16 chunks of 63 rows; a single cell is one chunk."""
    assert chunk_shape((1000, 1000)) == (63, 1000)
    assert len(list(chunks((1000, 1000)))) == 16
    assert list(chunks(())) == [(Span(0, 1), ())]
    assert math.prod(chunk_shape((10**6,))) <= CHUNK_CELLS


@given(st.integers(0, 300), st.integers(1, 320))
def test_blocks_partition_the_cells(size, cells):
    """Blocks are contiguous, do not overlap, and all but the last have the requested length."""
    spans = list(blocks(size, cells))
    assert [cell for span in spans for cell in range(span.start, span.stop)] == list(range(size))
    assert all(len(span) == cells for span in spans[:-1])
    assert all(1 <= len(span) <= cells for span in spans)


def test_how_many_blocks():
    """A grid that fills a block exactly has one block."""
    for size, count in [(1, 1), (BLOCK_CELLS, 1), (BLOCK_CELLS + 1, 2)]:
        assert len(list(blocks(size))) == count


#: Values of each parameter that are valid for any disk.
VALUES = {
    "tilt": [0.1, 0.2, 0.4],
    "tilt_rate": [-0.1, 0.3],
    "precession_rate": [-2.0, 1.0, 3.0],
    "roll_rate": [0.5, 1.5],
    "alpha": [0.25, 0.5, 1.0],
    "radius": [0.25, 2.0],
    "gravity": [1.6, 9.81],
}


@given(st.data())
def test_cells_are_in_the_order_of_c(data):
    """Any span of any grid equals that part of the meshed axes, with the last axis fastest."""
    axes = data.draw(
        st.permutations(list(VALUES)).flatmap(lambda names: st.sampled_from([names[:n] for n in range(8)]))
    )
    spec = SweepSpec(**{name: VALUES[name] for name in axes})
    start = data.draw(st.integers(0, spec.size - 1))
    stop = data.draw(st.integers(start, spec.size))
    meshed = dict(zip(axes, np.meshgrid(*(VALUES[name] for name in axes), indexing="ij"), strict=True))
    found = starts_of(spec, Span(start, stop))
    assert list(found) == list(PARAMETERS)
    for name, values in found.items():
        expected = (
            meshed[name].ravel()[start:stop] if name in axes else [PARAMETERS[name].default] * (stop - start)
        )
        assert values.dtype == np.float64
        np.testing.assert_array_equal(values, expected)


def test_a_span_has_the_starts_of_the_whole():
    """A computed parameter of a cell has the same bits in any span."""
    spec = SweepSpec(tilt="1deg:20deg:4", roll_rate="steady", precession_rate="-1:4:5")
    everything, part = whole(spec), starts_of(spec, Span(3, 17))
    assert list(everything) == list(part) == list(PARAMETERS)
    for name, values in part.items():
        assert values.tobytes() == everything[name][3:17].tobytes()


def test_starts_off_the_grid_are_completed():
    """Starts off the grid get the computed parameter, in the order of the model."""
    spec = SweepSpec(tilt="1deg:20deg:4", roll_rate="steady", precession_rate="-1:4:5")
    given = {name: values for name, values in reversed(whole(spec).items()) if name != "roll_rate"}
    found = completed(spec, given)
    assert list(found) == list(PARAMETERS)
    assert found["roll_rate"].tobytes() == whole(spec)["roll_rate"].tobytes()
