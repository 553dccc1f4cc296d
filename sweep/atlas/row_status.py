"""Why a row of the grid has an edge of the unstable band, or none: a code for each row, from its verdicts alone."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

#: The codes.
ROW_UNDECIDED, STABLE_THROUGHOUT, UNSTABLE_THROUGHOUT, FOUND, MORE_THAN_ONE, OTHER_EDGE_ONLY = range(6)

#: Each code with its name, as the file declares it.
ROW_STATUS: Mapping[int, str] = MappingProxyType(
    {
        ROW_UNDECIDED: "undecided",
        STABLE_THROUGHOUT: "stable_throughout",
        UNSTABLE_THROUGHOUT: "unstable_throughout",
        FOUND: "found",
        MORE_THAN_ONE: "more_than_one_edge",
        OTHER_EDGE_ONLY: "other_edge_only",
    }
)

#: Cells of the rows whose changes of verdict are counted at a time: 16 megabytes of working arrays.
_STATUS_CELLS = 2**20


def row_status(rows: npt.NDArray[np.integer], edge: str = "upper") -> npt.NDArray[np.int8]:
    """Return for each row whether it has an edge of the unstable band, and if not, why.

    Parameters
    ----------
    rows : array of int, shape (..., n)
        Verdicts along a control parameter, increasing along the last axis.
    edge : {"upper", "lower"}
        The edge above which, or below which, the motion is stable.

    Returns
    -------
    array of int8, shape (...)
        A code of `ROW_STATUS`. Undecided cells are left out of the sequence of verdicts first. ``found``: the verdict
        changes once in the direction of this edge, and the row ends on its stable side. ``more_than_one_edge``: it
        changes so more than once, or changes back: the value stored is that of the outermost edge, and there is none
        where the row ends on the unstable side. Rows without such a change are ``undecided`` if a cell is,
        ``stable_throughout``, ``unstable_throughout``, or have the ``other_edge_only``.
    """
    flat = rows.reshape(-1, rows.shape[-1])
    if edge == "lower":
        flat = flat[:, ::-1]
    found = np.empty(len(flat), np.int8)
    count = max(1, _STATUS_CELLS // flat.shape[-1])
    for start in range(0, len(flat), count):
        found[start : start + count] = _upper_status(flat[start : start + count])
    return found.reshape(rows.shape[:-1])


def _upper_status(rows: npt.NDArray[np.integer]) -> npt.NDArray[np.int8]:
    n = rows.shape[-1]
    stable, unstable, decided = rows == STABLE, rows == UNSTABLE, rows != UNDECIDED
    # the place of the last decided cell up to each one
    last = np.maximum.accumulate(np.where(decided, np.arange(n, dtype=np.int32), np.int32(-1)), axis=-1)
    before = np.take_along_axis(unstable, np.maximum(last[:, :-1], 0), axis=-1) & (last[:, :-1] >= 0)
    changes = (before & stable[:, 1:]).sum(-1)
    ends_stable = np.take_along_axis(stable, np.maximum(last[:, -1:], 0), axis=-1)[:, 0]
    alike = (~decided.all(-1), stable.all(-1), unstable.all(-1))
    without = np.select(alike, (ROW_UNDECIDED, STABLE_THROUGHOUT, UNSTABLE_THROUGHOUT), OTHER_EDGE_ONLY)
    single = (changes == 1) & ends_stable
    return np.select((changes == 0, single), (without, FOUND), MORE_THAN_ONE).astype(np.int8)


def in_words(status: npt.NDArray[np.integer], rows: str = "rows", edge: str = "") -> list[str]:
    """Return what there is to say of rows whose boundary was not simply found: one line or two, or none.

    Parameters
    ----------
    status : array of int, any shape
        Codes of `ROW_STATUS`.
    rows : str
        What the rows are called.
    edge : {"", "upper", "lower"}
        The edge that the codes belong to, where it is to be named.
    """
    counts = {code: int((status == code).sum()) for code in ROW_STATUS}
    several, found = counts.pop(MORE_THAN_ONE), counts.pop(FOUND)
    missing = {name(code, edge): count for code, count in counts.items() if count}
    without, lines = status.size - several - found, []
    what = f"{edge} edge" if edge else "boundary"
    if without:
        where = "" if without == status.size else f" in {without} of {status.size} {rows}"
        reasons = (
            list(missing) if len(missing) == 1 else [f"{count} {word}" for word, count in missing.items()]
        )
        lines.append(f"no {what}{where}: {', '.join(reasons)}")
    if several:
        where = "" if several == status.size else f" in {several} of {status.size} {rows}"
        lines.append(f"more than one {edge} edge{where}".replace("  ", " "))
    return lines


def name(code: int, edge: str = "") -> str:
    """Return the name of a code, in words; of an edge that is named, the other one is named too."""
    words = ROW_STATUS[code].replace("_", " ")
    return words.replace("other", {"upper": "lower", "lower": "upper"}.get(edge, "other"))
