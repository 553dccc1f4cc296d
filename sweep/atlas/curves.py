"""The boundary of stability as curves: several, closed or not, through the planes of a grid."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas.boundary import Brackets, bisected, verdicts
from sweep.atlas.cf_metadata import CURVES, POINTS
from sweep.engine.grid import whole
from sweep.model.quantity import UNDECIDED, Array, Truths
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr

Ints = npt.NDArray[np.intp]


@dataclass(frozen=True)
class Curves:
    """Curves as chains of points, one chain after the other.

    Each curve lies in a plane of the last two axes. Each point lies on a line of the grid between two neighbouring
    cells of unlike verdicts: its place along one axis was measured and has a half-width, the others are the grid's.

    `counts` and `closed`, shape (curves,): the points of each curve, and whether its last point leads back to its
    first. `points` and `halfwidths`, per axis of the spec, shape (points,), in SI: the half-width is 0 along the axes
    that were not measured.
    """

    counts: Ints
    closed: Truths
    points: dict[str, Array]
    halfwidths: dict[str, Array]


def curves(spec: SweepSpec, stability: npt.NDArray[np.integer], width: float) -> Curves:
    """Find where neighbouring cells have unlike verdicts, bisect all these places at once, and join them to curves.

    Parameters
    ----------
    spec : SweepSpec
        Of two axes or more; the curves lie in the planes of the last two.
    stability : array of int, shape spec.shape
    width : float
        Width of the brackets, in the SI unit of each axis.

    Returns
    -------
    Curves

    Notes
    -----
    Marching squares. Of a square whose corners alternate, the verdict at its middle says which corners belong together;
    it is integrated like a cell. A curve ends at the border of the grid and at undecided cells.
    """
    changes = [_changes(stability, axis) for axis in (-2, -1)]
    brackets = _brackets(spec, stability, changes)
    fine = bisected(spec, brackets, width)
    chains, closed = _chains(_links(spec, stability, changes))
    order = np.concatenate(chains) if chains else np.zeros(0, np.intp)
    middle, half = 0.5 * (fine.near + fine.far), 0.5 * np.abs(fine.far - fine.near)
    points, halfwidths, numbers = {}, {}, _numbers(spec)
    for name in spec.axes:
        measured = fine.along == numbers[name]
        points[name] = np.where(measured, middle, fine.starts[name])[order]
        halfwidths[name] = np.where(measured, half, 0.0)[order]
    return Curves(
        np.array([len(chain) for chain in chains], np.intp), np.array(closed, bool), points, halfwidths
    )


def without_curves(dataset: "xr.Dataset") -> "xr.Dataset":
    """Return what an atlas holds on its grid: its dimensions are axes of its spec, and no others."""
    return dataset.drop_dims((CURVES, POINTS), errors="ignore")


def _numbers(spec: SweepSpec) -> dict[str, int]:
    return {name: number for number, name in enumerate(spec.model.parameters)}


def _changes(stability: npt.NDArray[np.integer], axis: int) -> Truths:
    """Return where a cell and the next one along an axis are decided and unlike; one shorter along the axis."""
    count = stability.shape[axis]
    here, after = (np.take(stability, range(k, count - 1 + k), axis) for k in (0, 1))
    return np.asarray((here != after) & (here != UNDECIDED) & (after != UNDECIDED))


def _brackets(spec: SweepSpec, stability: npt.NDArray[np.integer], changes: list[Truths]) -> Brackets:
    ends = []
    for axis, changed in zip((-2, -1), changes, strict=True):
        here = np.nonzero(changed)
        after = list(here)
        after[axis] = after[axis] + 1
        ends.append([np.ravel_multi_index(place, spec.shape) for place in (here, tuple(after))])
    near, far = (np.concatenate(side) for side in zip(*ends, strict=True))
    numbers, names = _numbers(spec), [spec.axes[axis] for axis in (-2, -1)]
    along = np.repeat([numbers[name] for name in names], [len(pair[0]) for pair in ends])
    grid = whole(spec)
    places = {name: values[near] for name, values in grid.items()}
    beyond = {name: values[far] for name, values in grid.items()}

    def chosen(values: dict[str, Array]) -> Array:
        return np.where(along == numbers[names[0]], values[names[0]], values[names[1]])

    flat = stability.reshape(-1)
    return Brackets(places, along, chosen(places), chosen(beyond), flat[near], flat[far])


def _links(spec: SweepSpec, stability: npt.NDArray[np.integer], changes: list[Truths]) -> Ints:
    """Return the two points that each point is joined to, -1 for none, shape (points, 2)."""
    down, across = (np.full(changed.shape, -1) for changed in changes)
    down[changes[0]] = np.arange(changes[0].sum())
    across[changes[1]] = np.arange(changes[1].sum()) + changes[0].sum()
    # the four sides of each square: left and right run along the first of the two axes, low and high along the last
    left, right = down[..., :-1], down[..., 1:]
    low, high = across[..., :-1, :], across[..., 1:, :]
    sides = np.stack((left, low, right, high))
    crossed = (sides >= 0).sum(0)
    twice = sides[:, crossed == 2].T
    pairs = np.sort(twice, axis=1)[:, 2:]
    saddle = crossed == 4
    if saddle.any():
        as_corner = _middle_verdicts(spec, np.nonzero(saddle)) == stability[..., :-1, :-1][saddle]
        a, b, c, d = sides[:, saddle]
        # joined to the middle, the first corner and the one opposite leave the two others cut off
        cut = np.where(as_corner, (a, d, b, c), (a, b, c, d)).T
        pairs = np.concatenate((pairs, cut.reshape(-1, 2)))
    links = np.full((int(changes[0].sum() + changes[1].sum()), 2), -1)
    for one, other in (*pairs.tolist(), *pairs[:, ::-1].tolist()):
        links[one, int(links[one, 0] >= 0)] = other
    return links


def _middle_verdicts(spec: SweepSpec, squares: tuple[Ints, ...]) -> npt.NDArray[np.int8]:
    """Return the verdicts at the middles of squares, given by the places of their first corners."""
    grid = whole(spec)
    corner = np.ravel_multi_index(squares, spec.shape)
    opposite = np.ravel_multi_index((*squares[:-2], squares[-2] + 1, squares[-1] + 1), spec.shape)
    values = {name: 0.5 * (each[corner] + each[opposite]) for name, each in grid.items()}
    last = _numbers(spec)[spec.axes[-1]]
    nothing = np.zeros(len(corner), np.int8)
    at = Brackets(
        values, np.full(len(corner), last), values[spec.axes[-1]], values[spec.axes[-1]], nothing, nothing
    )
    return verdicts(spec, at, np.arange(len(corner)), at.near)


def _chains(links: Ints) -> tuple[list[Ints], list[bool]]:
    """Follow the links: open curves from their ends first, then closed ones; returns the points of each."""
    joined, seen = links.tolist(), [False] * len(links)
    chains: list[Ints] = []
    closed: list[bool] = []
    ends = np.flatnonzero(links[:, 1] < 0).tolist()
    for start in (*ends, *range(len(links))):
        if seen[start]:
            continue
        chain, here = list[int](), start
        while here >= 0 and not seen[here]:
            seen[here] = True
            chain.append(here)
            here = next((each for each in joined[here] if each >= 0 and not seen[each]), -1)
        chains.append(np.array(chain, np.intp))
        closed.append(start in joined[chain[-1]] and len(chain) > 2)
    return chains, closed
