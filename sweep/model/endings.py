"""How the integration of a cell can end: the closed list of a model, and what each ending means for the verdict."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError
from sweep.model.quantity import DECISION, Quantity, Truths

# Roles: what an ending means for the verdict, whatever the model calls it.
#: The cell has not been integrated.
MISSING = "missing"
#: The extremes that were reached hold for all time; of a model that judges within the duration, for that.
FINAL = "final"
#: Time ran out first: the motion may yet go further.
OPEN = "open"
#: Unstable by any criterion that limits the coordinate.
LOST = "lost"
#: Nothing disturbs the motion: there is nothing to measure.
UNDISTURBED = "undisturbed"
#: The cell could not be computed.
FAILED = "failed"


@dataclass(frozen=True)
class Ending:
    """One way in which the integration of a cell can end.

    `code` is the number that the kernels write, `name` and `meaning` stand in the file, `role` is one of the roles
    above, `reason` says in a sentence why such a cell has the verdict that it has; empty where extremes decide.
    """

    code: int
    name: str
    meaning: str
    role: str
    reason: str = ""


class Endings:
    """The closed list of endings of a model.

    Parameters
    ----------
    *endings : Ending
        The one whose role is MISSING has the code 0.
    lost_time : str
        The measure with the time at which a motion was lost; empty if there is none. Of another ending it has none, or
        the time until that one.
    """

    def __init__(self, *endings: Ending, lost_time: str = "") -> None:
        self._all, self.lost_time = endings, lost_time
        self._codes = {each.name: each.code for each in endings}

    def __iter__(self) -> Iterator[Ending]:
        """Yield the endings."""
        return iter(self._all)

    def code(self, name: str) -> int:
        """Return the code of a name."""
        return self._codes[name]

    def of(self, code: float) -> Ending:
        """Return the ending of a code.

        Raises
        ------
        RequestError
            If there is none, as in a damaged file.
        """
        for each in self._all:
            if each.code == code:
                return each
        raise RequestError(
            f"The file is damaged: a cell has the ending {code:g}, which is none of "
            f"{', '.join(map(str, self.flags))}.",
            hint="Check it with eulerdisk verify.",
            where="ending",
        )

    def codes(self, *roles: str) -> list[int]:
        """Return the codes of all endings with one of the roles."""
        return [each.code for each in self._all if each.role in roles]

    def have(self, role: str, ending: npt.NDArray[Any]) -> Truths:
        """Return which cells ended with a role; `ending` holds codes, any shape."""
        codes = self.codes(role)
        found: Truths = ending == codes[0] if len(codes) == 1 else np.isin(ending, codes)
        return found

    @property
    def flags(self) -> Mapping[int, str]:
        """Each code with its name, as the file declares it."""
        return MappingProxyType({each.code: each.name for each in self._all})

    @property
    def quantity(self) -> Quantity:
        """The variable of the file that holds the codes."""
        meanings = "; ".join(f"{each.name}: {each.meaning}" for each in self._all)
        words = "how the integration of the cell ended"
        return Quantity("ending", "", "1", words, DECISION, meanings, "i1", self.flags)
