"""The edges of the unstable band of a whole grid, by formulas over full arrays: a referee for the search."""

import numpy as np

from sweep.atlas.row_edges import (
    FOUND,
    MORE_THAN_ONE,
    OTHER_EDGE_ONLY,
    ROW_UNDECIDED,
    STABLE_THROUGHOUT,
    UNSTABLE_THROUGHOUT,
)
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE


def bracket(rows, edge):
    """Return each row's last unstable place and the first stable one after it, or -1; mirrored for lower edges."""
    n = rows.shape[-1]
    if edge == "lower":
        first, last = bracket(rows[..., ::-1], "upper")
        return np.where(first < 0, -1, n - 1 - first), np.where(last < 0, -1, n - 1 - last)
    unstable = rows == UNSTABLE
    last = np.where(unstable.any(-1), n - 1 - np.argmax(unstable[..., ::-1], axis=-1), n)
    beyond = (rows == STABLE) & (np.arange(n) > last[..., None])
    some = beyond.any(-1)
    return np.where(some, last, -1), np.where(some, np.argmax(beyond, axis=-1), -1)


def status(rows, edge):
    """Return each row's code of `sweep.atlas.row_edges`, from the verdict changes between its decided cells."""
    if edge == "lower":
        rows = rows[..., ::-1]
    n = rows.shape[-1]
    stable, unstable, decided = rows == STABLE, rows == UNSTABLE, rows != UNDECIDED
    # The place of the last decided cell up to each cell.
    last = np.maximum.accumulate(np.where(decided, np.arange(n), -1), axis=-1)
    before = np.take_along_axis(unstable, np.maximum(last[..., :-1], 0), axis=-1) & (last[..., :-1] >= 0)
    changes = (before & stable[..., 1:]).sum(-1)
    ends_stable = np.take_along_axis(stable, np.maximum(last[..., -1:], 0), axis=-1)[..., 0]
    alike = (~decided.all(-1), stable.all(-1), unstable.all(-1))
    without = np.select(alike, (ROW_UNDECIDED, STABLE_THROUGHOUT, UNSTABLE_THROUGHOUT), OTHER_EDGE_ONLY)
    return np.select((changes == 0, (changes == 1) & ends_stable), (without, FOUND), MORE_THAN_ONE)


def unlike(grid, axis):
    """Return where a cell and the next one along an axis are decided and differ; one shorter along the axis."""
    count = grid.shape[axis]
    here, after = (np.take(grid, range(k, count - 1 + k), axis) for k in (0, 1))
    return (here != after) & (here != UNDECIDED) & (after != UNDECIDED)


def pairs(grid):
    """Return flat indices of first cells of differing neighbors, along the last axis but one and the last."""
    return [np.ravel_multi_index(np.nonzero(unlike(grid, axis)), grid.shape) for axis in (-2, -1)]


def chains(grid, like_corner):
    """Return the points of each curve, and which curves are closed, from arrays of the sides of all squares.

    `like_corner` says whether the verdict at the middle of a square equals the verdict of its first corner, given by
    its place.
    """
    sides = []
    for axis in (-2, -1):
        changed = unlike(grid, axis)
        numbers = np.full(changed.shape, -1)
        numbers[changed] = np.arange(changed.sum()) + sum(int((each >= 0).sum()) for each in sides)
        sides.append(numbers)
    down, across = sides
    squares = np.stack((down[..., :-1], across[..., :-1, :], down[..., 1:], across[..., 1:, :]))
    joined = [[] for _ in range(int((down >= 0).sum() + (across >= 0).sum()))]
    saddles = []
    for place in np.ndindex(squares.shape[1:]):
        left, low, right, high = squares[(slice(None), *place)].tolist()
        crossed = sorted(each for each in (left, low, right, high) if each >= 0)
        if len(crossed) == 2:
            joined[crossed[0]].append((0, crossed[1]))
            joined[crossed[1]].append((1, crossed[0]))
        elif len(crossed) == 4:
            saddles += [(left, high), (low, right)] if like_corner(place) else [(left, low), (right, high)]
    for one, other in saddles:
        joined[one].append((0, other))
        joined[other].append((1, one))
    links = [[other for _, other in sorted(each, key=lambda link: link[0])] for each in joined]
    return _followed(links)


def _followed(links):
    found, closed, seen = [], [], set()
    for start in sorted(range(len(links)), key=lambda point: (len(links[point]) == 2, point)):
        if start in seen:
            continue
        chain = [start]
        seen.add(start)
        while ahead := [each for each in links[chain[-1]] if each not in seen]:
            chain.append(ahead[0])
            seen.add(ahead[0])
        found.append(chain)
        closed.append(len(chain) > 2 and start in links[chain[-1]])
    return found, closed
