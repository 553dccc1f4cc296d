import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sweep.engine.grid import BLOCK_CELLS, CHUNK_CELLS, Span, blocks, chunk_shape, chunks

SHAPES = st.lists(st.integers(1, 9), min_size=0, max_size=4).map(tuple)


@given(SHAPES, st.integers(1, 200))
def test_chunks_partition_the_grid_in_c_order(shape, cells):
    """The slices, one after the other, cover every cell once and in C order, and the spans number them."""
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
    """Every chunk has the chunk shape, except the last ones along an axis, which are cut by its end."""
    shares = chunk_shape(shape, cells)
    for _, slices in chunks(shape, cells):
        for n, share, part in zip(shape, shares, slices, strict=True):
            assert part.start % share == 0
            assert part.stop == min(n, part.start + share)


@given(SHAPES, st.integers(1, 200))
def test_chunks_are_not_wasteful(shape, cells):
    """There are at most twice as many chunks as the limit forces along the axis that is cut."""
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
    """Blocks follow each other without gap or overlap, all of the wanted length but the last."""
    spans = list(blocks(size, cells))
    assert [cell for span in spans for cell in range(span.start, span.stop)] == list(range(size))
    assert all(len(span) == cells for span in spans[:-1])
    assert all(1 <= len(span) <= cells for span in spans)


@pytest.mark.parametrize(("size", "count"), [(1, 1), (BLOCK_CELLS, 1), (BLOCK_CELLS + 1, 2)])
def test_how_many_blocks(size, count):
    """A grid that fills a block exactly needs no second one."""
    assert len(list(blocks(size))) == count
