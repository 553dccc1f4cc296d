"""The edges of the unstable band of a whole grid in memory, by formulas over full arrays: a referee for the search."""

import numpy as np

from sweep.atlas.row_status import (
    FOUND,
    MORE_THAN_ONE,
    OTHER_EDGE_ONLY,
    ROW_UNDECIDED,
    STABLE_THROUGHOUT,
    UNSTABLE_THROUGHOUT,
)
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE


def bracket(rows, edge):
    """Last unstable place of each row and the first stable one after it, -1 if there is no pair; mirrored if lower."""
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
    """Code of `sweep.atlas.row_status` of each row, from the changes of verdict between its decided cells."""
    if edge == "lower":
        rows = rows[..., ::-1]
    n = rows.shape[-1]
    stable, unstable, decided = rows == STABLE, rows == UNSTABLE, rows != UNDECIDED
    # the place of the last decided cell up to each one
    last = np.maximum.accumulate(np.where(decided, np.arange(n), -1), axis=-1)
    before = np.take_along_axis(unstable, np.maximum(last[..., :-1], 0), axis=-1) & (last[..., :-1] >= 0)
    changes = (before & stable[..., 1:]).sum(-1)
    ends_stable = np.take_along_axis(stable, np.maximum(last[..., -1:], 0), axis=-1)[..., 0]
    alike = (~decided.all(-1), stable.all(-1), unstable.all(-1))
    without = np.select(alike, (ROW_UNDECIDED, STABLE_THROUGHOUT, UNSTABLE_THROUGHOUT), OTHER_EDGE_ONLY)
    return np.select((changes == 0, (changes == 1) & ends_stable), (without, FOUND), MORE_THAN_ONE)
