"""The quantities in which reports give values.

An atlas requested by speed is reported in speeds, not in the rates that its file holds.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sweep.model.quantity import Quantity
from sweep.request.spec import SweepSpec


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


def reported_as(spec: SweepSpec, asked: Iterable[str] = ()) -> Mapping[str, ReportedAs]:
    """Return the quantity in which each parameter is reported: itself, or the substitute that was asked for.

    Parameters
    ----------
    spec : SweepSpec
    asked : iterable of str, optional
        Names of words, besides those of the request. A later name replaces an earlier one. Ignored are substitutes
        whose scale differs between cells, and substitutes that decrease as their control increases, because 'above the
        boundary' would become 'below'.
    """
    reported = {name: ReportedAs(each) for name, each in spec.quantities.items()}
    for name in (*spec.requested, *asked):
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
