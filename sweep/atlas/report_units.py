"""The quantities in which reports give values.

An atlas requested by speed is reported in speeds, not in the rates that its file holds.
"""

import re
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sweep.errors import plain_text
from sweep.model.quantity import Quantity
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class ReportedAs:
    """The quantity in which values of a parameter are reported: `scale` times what they exceed `offset` by [SI]."""

    quantity: Quantity
    scale: float = 1.0
    offset: float = 0.0

    def value(self, of_parameter: Any) -> Any:
        """Return a value, or an array of them, of the parameter as one of the quantity, both in SI."""
        return (of_parameter - self.offset) * self.scale

    def width(self, of_parameter: float) -> float:
        """Return a difference of the parameter as one of the quantity, both in SI."""
        return of_parameter * abs(self.scale)

    def spell(self, of_parameter: float, digits: int = 10) -> str:
        """Return a value of the parameter as a message says it, with its unit."""
        return self.quantity.spell(self.value(of_parameter), digits)


def words_of_command(dataset: "xr.Dataset") -> list[str]:
    """Return the names of the words in the command that made an atlas, which its history begins with."""
    return _names_in(plain_text(dataset.attrs.get("history", "")).partition("\n")[0])


def with_substitutes(command: str, spec: SweepSpec) -> str:
    """Return a command with the words of a spec that stand for its parameters, where it does not give them itself.

    Python and spec files give words too; the history of the atlas keeps them.
    """
    names = _names_in(command)
    more = (f"{name}={text}" for name, text in spec.substitutes.items() if name not in names)
    return " ".join([command, *map(shlex.quote, more)])


def _names_in(command: str) -> list[str]:
    try:
        words = shlex.split(command)
    except ValueError:
        # a history that another program has cut
        words = command.split()
    return [found[1] for word in words if (found := re.match(r"(\w+)=", word))]


def reported_as(spec: SweepSpec, asked: Iterable[str]) -> Mapping[str, ReportedAs]:
    """Return how the values of each parameter are reported: as they are, or as the word that was asked for instead.

    Parameters
    ----------
    spec : SweepSpec
    asked : iterable of str
        Names of words. A later name replaces an earlier one. Ignored: a substitute whose scale differs between cells; a
        substitute that decreases as its control increases, because 'above the boundary' would become 'below'.
    """
    reported = {name: ReportedAs(each) for name, each in spec.quantities.items()}
    for name in asked:
        if name in spec.quantities:
            reported[name] = ReportedAs(spec.quantities[name])
        elif substitute := spec.model.substitutes.get(name):
            needed = {each: getattr(spec, each) for each in substitute.needs}
            if not all(isinstance(each, float) for each in needed.values()):
                continue
            scale = substitute.scale(needed)
            if scale > 0.0 or not spec.quantities[substitute.parameter].control:
                reported[substitute.parameter] = ReportedAs(substitute, scale, substitute.offset)
    return reported
