"""Unlike neighbours and the curves through them, from cells in spans, held against arrays of the whole grid."""

import itertools
from unittest import mock

import boundary_referee as referee
import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from sweep.atlas import boundary, neighbours
from sweep.atlas import curves as curves_of
from sweep.atlas.curves import curves
from sweep.atlas.neighbours import NeighbourSearch
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


def searched(grid, cuts=()):
    """The unlike neighbours of a grid that is given in spans between the cuts."""
    search = NeighbourSearch(grid.shape)
    for start, stop in itertools.pairwise((0, *sorted(cuts), grid.size)):
        search.add(start, grid.reshape(-1)[start:stop])
    return search.pairs()


def agrees(found, grid):
    """Whether the pairs are those of the whole grid."""
    down, across = referee.pairs(grid)
    cells = np.concatenate((down, across))
    return (
        found.down == down.size
        and found.cells.tolist() == cells.tolist()
        and found.verdicts.tolist() == grid.reshape(-1)[cells].tolist()
        and found.along_last.tolist() == [False] * down.size + [True] * across.size
    )


@given(st.data(), grids())
def test_neighbours_in_any_spans(data, grid):
    """In spans of any size the pairs are those of the whole grid."""
    assert agrees(searched(grid, data.draw(st.lists(st.integers(0, grid.size)))), grid)


@given(st.data(), grids(), st.integers(1, 20))
def test_the_last_line_is_kept_through_many_spans(data, grid, most):
    """Where lines are longer than what is compared at a time, and where they are shorter, no pair is lost."""
    with mock.patch.object(neighbours, "_AT_ONCE", most):
        assert agrees(searched(grid, data.draw(st.lists(st.integers(0, grid.size)))), grid)


@given(grids(), st.integers(1, 30))
def test_pairs_of_whole_planes(grid, about):
    """Parts of whole planes have every pair once, by its number, and no plane is in two parts."""
    pairs, area = searched(grid), grid.shape[-1] * grid.shape[-2]
    seen, planes = [], []
    for numbers, part in pairs.of_planes(about):
        seen += numbers.tolist()
        assert part.cells.tolist() == pairs.cells[numbers].tolist()
        assert part.verdicts.tolist() == pairs.verdicts[numbers].tolist()
        assert part.along_last.tolist() == pairs.along_last[numbers].tolist()
        planes += sorted({int(cell) // area for cell in part.cells})
    assert sorted(seen) == list(range(pairs.cells.size))
    assert planes == sorted(set(planes))


def judged(spec, starts):
    """A verdict at any start, without integration: stable and unstable lie close together."""
    waves = np.sin(97.0 * starts["tilt"] + 31.0 * starts["roll_rate"] + starts["alpha"] + starts["gravity"])
    return np.where(waves > 0.0, UNSTABLE, STABLE).astype(np.int8)


@given(grids(), st.integers(1, 40))
def test_curves_of_any_grid(grid, at_once):
    """Curves have the points, in the order, that the sides of all squares of the whole grid give."""
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
    ):
        found = curves(spec, searched(grid))
        spans = [Span(at, min(at + at_once, found.cells.size)) for at in range(0, found.cells.size, at_once)]
        # wider than any bracket: the middles stay those of the grid
        points = [found.measured(span, 10.0) for span in spans]
    chains, closed = referee.chains(grid, like_corner)
    assert found.counts.tolist() == [len(chain) for chain in chains]
    assert found.closed.tolist() == closed
    order = np.array([point for chain in chains for point in chain], int)
    down, across = referee.pairs(grid)
    here = np.concatenate((down, across))[order]
    after = here + np.where(order < down.size, grid.shape[-1], 1)
    for name, each in zip(names, coordinates, strict=True):
        one, other = each.reshape(-1)[here], each.reshape(-1)[after]
        places, widths = ([v for each in points for v in each.along(name)[k].tolist()] for k in (0, 1))
        assert places == (0.5 * (one + other)).tolist()
        assert widths == (0.5 * np.abs(other - one)).tolist()
