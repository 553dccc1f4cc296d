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
    """The quantity in which values of a parameter are reported: `scale` times (value minus `offset`), in SI."""

    quantity: Quantity
    scale: float = 1.0
    offset: float = 0.0

    def value(self, of_parameter: Any) -> Any:
        """Convert a value or an array of the parameter to the quantity, both in SI."""
        return (of_parameter - self.offset) * self.scale

    def width(self, of_parameter: float) -> float:
        """Convert a difference of the parameter to the quantity, both in SI."""
        return of_parameter * abs(self.scale)

    def spell(self, of_parameter: float, digits: int = 10) -> str:
        """Return a value of the parameter as text for a message, with its unit."""
        return self.quantity.spell(self.value(of_parameter), digits)


def words_of_command(dataset: "xr.Dataset") -> list[str]:
    """Return the names of the words in the command that made an atlas, taken from the first line of its history."""
    return _names_in(plain_text(dataset.attrs.get("history", "")).partition("\n")[0])


def with_substitutes(command: str, spec: SweepSpec) -> str:
    """Add to a command the substitute words of a spec that it does not contain.

    They come from Python or from a spec file; the history of the atlas keeps them.
    """
    names = _names_in(command)
    more = (f"{name}={text}" for name, text in spec.substitutes.items() if name not in names)
    return " ".join([command, *map(shlex.quote, more)])


def _names_in(command: str) -> list[str]:
    try:
        words = shlex.split(command)
    except ValueError:
        # another program has cut the history
        words = command.split()
    return [match[1] for word in words if (match := re.match(r"(\w+)=", word))]


def reported_as(spec: SweepSpec, asked: Iterable[str]) -> Mapping[str, ReportedAs]:
    """Return the quantity in which each parameter is reported: itself, or the substitute that was asked for.

    Parameters
    ----------
    spec : SweepSpec
    asked : iterable of str
        Names of words. A later name replaces an earlier one. Ignored are substitutes whose scale differs between cells,
        and substitutes that decrease as their control increases, because 'above the boundary' would become 'below'.
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
