"""Unlike neighbours and the curves through them, found in parts, held against arrays of the whole grid."""

from unittest import mock

import boundary_referee as referee
import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from sweep.atlas import boundary, chains, neighbours, scratch
from sweep.atlas import curves as curves_of
from sweep.atlas.boundary_search import in_memory
from sweep.atlas.curves import Curves
from sweep.atlas.neighbours import joined_pairs, parts_of
from sweep.engine.grid import Span
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.request.spec import SweepSpec

AXES = ("gravity", "alpha", "tilt", "roll_rate")


@st.composite
def grids(draw):
    """A grid of two to four axes: noise, or one of few undecided cells and many squares with alternating corners."""
    shape = draw(array_shapes(min_dims=2, max_dims=4, max_side=6))
    codes = draw(
        st.sampled_from(((UNDECIDED, STABLE, UNSTABLE), (STABLE, UNSTABLE), (STABLE, STABLE, UNSTABLE)))
    )
    return draw(arrays(np.int8, shape, elements=st.sampled_from(codes)))


def pairs_of(grid, like_corner=lambda corners: np.full(corners.size, STABLE)):
    """The pairs of both kinds that a grid in memory has: places, links backward, links forward."""

    def read(span):
        assert 0 <= span.start < span.stop <= grid.size
        return grid.reshape(-1)[span.start : span.stop]

    parts = list(joined_pairs(grid.shape, read, like_corner))
    return [
        [
            np.concatenate([getattr(part[kind], name) for part in parts])
            for name in ("places", "before", "after")
        ]
        for kind in (0, 1)
    ]


@given(grids(), st.integers(1, 50))
def test_neighbours_in_any_spans(grid, most):
    """Whether lines are longer than what is looked at at a time or shorter, the pairs are those of the whole grid."""
    with mock.patch.object(neighbours, "_AT_ONCE", most):
        found = pairs_of(grid)
    for kind, (cells, (places, before, after)) in enumerate(zip(referee.pairs(grid), found, strict=True)):
        here, verdicts, along_last = parts_of(places)
        assert here.tolist() == cells.tolist()
        assert verdicts.tolist() == grid.reshape(-1)[cells].tolist()
        assert along_last.tolist() == [kind == 1] * cells.size
        assert before.size == after.size == cells.size


#: A loop around one cell, which begins beside a saddle: it is followed away from that.
BESIDE_SADDLE = np.array([[1, 2, 1, 1], [1, 1, 2, 1], [1, 1, 1, 1]], np.int8)


def judged(spec, starts):
    """A verdict at any start, without integration: stable and unstable lie close together."""
    waves = np.sin(97.0 * starts["tilt"] + 31.0 * starts["roll_rate"] + starts["alpha"] + starts["gravity"])
    return np.where(waves > 0.0, UNSTABLE, STABLE).astype(np.int8)


@given(grids(), st.integers(1, 40), st.integers(0, 3), st.integers(0, 40))
@example(BESIDE_SADDLE, 40, 3, 40)
@example(3 - BESIDE_SADDLE, 40, 3, 40)
def test_curves_of_any_grid(grid, at_once, page_bits, held):
    """Curves have the points, in the order, that the sides of all squares of the whole grid give.

    However few squares are looked at at a time, and however few points are in memory.
    """
    values = [
        np.linspace(0.1 * number + 0.1, 0.1 * number + 0.9, count) for number, count in enumerate(grid.shape)
    ]
    names = AXES[-grid.ndim :]
    spec = SweepSpec(**dict(zip(names, map(np.ndarray.tolist, values), strict=True)))
    coordinates = np.meshgrid(*values, indexing="ij")

    def like_corner(place):
        far = (*place[:-2], place[-2] + 1, place[-1] + 1)
        middle = {
            name: 0.5 * (each[place] + each[far]) for name, each in zip(names, coordinates, strict=True)
        }
        return judged(spec, {"alpha": spec.alpha, "gravity": spec.gravity} | middle) == grid[place]

    with (
        mock.patch.object(boundary, "judged", judged),
        mock.patch.object(boundary, "AT_ONCE", at_once),
        mock.patch.object(curves_of, "AT_ONCE", at_once),
        mock.patch.object(neighbours, "_AT_ONCE", at_once),
        mock.patch.object(chains, "_AT_ONCE", at_once),
        mock.patch.object(chains, "_PAGE_BITS", page_bits),
        mock.patch.object(chains, "_MOST_PAGES", 2),
        mock.patch.object(scratch, "_MOST_HELD", held),
        scratch.Scratch() as place,
    ):
        found = Curves(spec, in_memory(grid), place)
        counts, closed_here = found.lengths(Span(0, found.count))
        spans = [Span(at, min(at + at_once, found.points)) for at in range(0, found.points, at_once)]
        # wider than any bracket: the middles stay those of the grid
        points = [found.measured(span, 10.0) for span in spans]
    expected, closed = referee.chains(grid, like_corner)
    assert counts.tolist() == [len(chain) for chain in expected]
    assert closed_here.tolist() == closed
    order = np.array([point for chain in expected for point in chain], int)
    down, across = referee.pairs(grid)
    here = np.concatenate((down, across))[order]
    after = here + np.where(order < down.size, grid.shape[-1], 1)
    for name, each in zip(names, coordinates, strict=True):
        one, other = each.reshape(-1)[here], each.reshape(-1)[after]
        places, widths = ([v for each in points for v in each.along(name)[k].tolist()] for k in (0, 1))
        assert places == (0.5 * (one + other)).tolist()
        assert widths == (0.5 * np.abs(other - one)).tolist()
