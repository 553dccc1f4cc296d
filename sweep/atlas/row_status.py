"""Why a row of the grid has an edge of the unstable band, or none: a code for each row, from its verdicts alone."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from sweep.errors import counted

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


def in_words(status: npt.NDArray[np.integer], axis: str, edge: str = "") -> list[str]:
    """Return what there is to say of rows whose boundary was not simply found: one line or two, or none.

    Parameters
    ----------
    status : array of int, any shape
        Codes of `ROW_STATUS`.
    axis : str
        The parameter along which the rows lie.
    edge : {"", "upper", "lower"}
        The edge that the codes belong to, where it is to be named.
    """
    counts = {code: int((status == code).sum()) for code in ROW_STATUS}
    several, found = counts.pop(MORE_THAN_ONE), counts.pop(FOUND)
    missing = {name(code, edge): count for code, count in counts.items() if count}
    without, lines = status.size - several - found, []
    what = f"{edge} edge" if edge else "boundary"
    if without:
        where = "" if without == status.size else f" in {counted(without, 'row', status.size)} along {axis}"
        reasons = (
            list(missing) if len(missing) == 1 else [f"{count} {word}" for word, count in missing.items()]
        )
        lines.append(f"no {what}{where}: {', '.join(reasons)}")
    if several:
        where = "" if several == status.size else f" in {counted(several, 'row', status.size)} along {axis}"
        lines.append(f"more than one {edge} edge{where}".replace("  ", " "))
    return lines


def name(code: int, edge: str = "") -> str:
    """Return the name of a code, in words; of an edge that is named, the other one is named too."""
    words = ROW_STATUS[code].replace("_", " ")
    return words.replace("other", {"upper": "lower", "lower": "upper"}.get(edge, "other"))
