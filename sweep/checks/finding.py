"""The comparison of one variable of two atlases."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from sweep.checks.alignment import Pair
from sweep.checks.cell_pair import CellBlock, Places, Values
from sweep.checks.tally import Tally, difference, other_bits
from sweep.checks.variables import (
    CELL,
    CURVE,
    EDGE,
    FOREIGN,
    Variable,
    allowed,
    allowed_of_cells,
    cut_along,
    lacking,
    may_lack,
)
from sweep.errors import counted
from sweep.model.quantity import EDGE_HALFWIDTH, GRID, OF_THE_RUN, TIMED, Array, Truths

if TYPE_CHECKING:
    import xarray as xr

#: Attributes that give the numbers of a variable their meaning.
MEANING = ("units", "flag_values", "flag_meanings")


@dataclass(frozen=True)
class Cell:
    """The cell where two atlases differ most, relative to the allowed difference.

    `where` has its coordinates [SI], `place` the same in words, and `flags` the values of flags in words.
    """

    where: dict[str, float]
    new: float | None
    reference: float | None
    difference: float | None
    allowed: float
    place: str
    flags: str = ""


@dataclass(frozen=True)
class Finding:
    """The comparison of one variable.

    `different` counts the values that differ by more than is allowed, `on_edge` the values that differ because a
    borderline cell flipped. `largest` is the largest absolute difference among the other values, `allowed` the allowed
    difference there, both in the units of the variable, and 0 for flags; `share` is the largest ratio of difference to
    allowed difference. `bitwise` is true if all bits are equal. `reason` is the reason for the allowed difference.
    """

    name: str
    units: str
    values: int
    different: int
    on_edge: int
    bitwise: bool
    largest: float = 0.0
    allowed: float = 0.0
    share: float = 0.0
    worst: Cell | None = None
    reason: str = ""
    note: str = ""


class HeldVariable:
    """The comparison of one variable, which one or both atlases have.

    Parameters
    ----------
    variable : Variable
    pair : Pair
    exact : bool
        Whether all bits must be equal.

    Attributes
    ----------
    limit : float or None
        The difference that the caller allows.
    """

    def __init__(self, variable: Variable, pair: Pair, exact: bool) -> None:
        self.variable, self._pair, self._exact = variable, pair, exact
        self.limit: float | None = None
        self._tally, self._bitwise = Tally(), True
        self._missing = lacking(variable.name, pair)

    def add_cells(self, block: CellBlock, flips: Mapping[str, Truths]) -> None:
        """Add the values of some cells; `flips` marks the cells whose ending and verdict may flip."""
        name = self.variable.name
        new, old = block.new[name], block.reference[name]
        bits = other_bits(new, old)
        self._bitwise &= not bits.any()
        # always add the first block: if nothing differs, the report shows the allowed difference of the first cell
        if not bits.any() and block.places[0]:
            return
        excused = flips.get("stability" if name == "stability" else "ending", False)
        if self.variable.kind != CELL:
            excused = False
        most: Array | float | None = self._given()
        if most is None:
            most = allowed_of_cells(self.variable.quantity, *block.stated, block.starts)
        self._add(int(block.places[0]), new, old, bits, most, excused)

    def add_whole(self, on_edge: Places) -> None:
        """Add all values of a variable without one value per cell; `on_edge` are the cells that flipped."""
        name, pair = self.variable.name, self._pair
        if self._missing:
            return
        new, old = pair.new[name], pair.reference[name]
        if _other_kind(new, old):
            self._bitwise = new.dims == old.dims and np.array_equal(new.values, old.values)
            return
        bits = other_bits(new.values, old.values)
        self._bitwise = not bits.any()
        most: Array | float | None = self._given()
        if most is None:
            most = allowed(self.variable.quantity, pair)
        self._add(0, new.values, old.values, bits, most, self._excused(on_edge))

    def _given(self) -> float | None:
        """Return the allowed difference if it is the same for all values, otherwise None."""
        return 0.0 if self._exact else self.limit

    def _add(
        self, start: int, new: Values, old: Values, bits: Truths, most: Array | float, excused: Truths | bool
    ) -> None:
        apart = difference(new, old)
        most = np.broadcast_to(most, apart.shape)
        rule = self.variable.quantity.tolerance
        beyond = bits
        if not self._exact:
            # written so that NaN counts as beyond
            beyond = ~(apart <= most)
            if rule in OF_THE_RUN or rule.stated == TIMED:
                # times, errors and step counts are never negative
                beyond |= (new < 0.0) != (old < 0.0)
        columns = [
            np.asarray(np.broadcast_to(each, apart.shape)).reshape(-1) for each in (most, beyond, excused)
        ]
        self._tally.add(
            start,
            apart.reshape(-1),
            columns[0],
            beyond=columns[1],
            excused=columns[2],
            values=(new.reshape(-1), old.reshape(-1)),
        )

    def _excused(self, on_edge: Places) -> Truths | bool:
        """Return which values may differ because a borderline cell flipped: all curves, and the bracket of its row."""
        variable, shape = self.variable, self._pair.reference["ending"].shape
        if variable.kind == CURVE:
            return bool(on_edge.size)
        # lines of theory do not depend on cells
        if variable.kind != EDGE or not variable.name.startswith("boundary_"):
            return False
        axis = self._pair.axes.index(variable.axis)
        cells = np.zeros(shape, bool)
        cells.reshape(-1)[on_edge] = True
        return np.asarray(cells.any(axis=axis))

    def outcome(self, curves_move: bool) -> "Finding | str":
        """Return the finding, or the reason for not comparing; `curves_move` if any cell flipped."""
        variable, pair = self.variable, self._pair
        if self._missing:
            reason = (
                "" if self._exact else _elsewhere(variable, pair) or may_lack(variable, pair) * self._missing
            )
            return reason or self._all_different(self._missing)
        new, old = pair.new[variable.name], pair.reference[variable.name]
        other = _other_meaning(new, old)
        if self._bitwise and not other:
            return self._finding(bitwise=True)
        if self.limit is None and (reason := self._not_judged()):
            return reason
        if other := other or _other_kind(new, old):
            return self._all_different(other, curves_move and variable.kind == CURVE)
        return self._finding(bitwise=False)

    def _not_judged(self) -> str:
        """Return the reason for not judging a difference; empty if it is judged."""
        if self._exact:
            return cut_along(self.variable, self._pair)
        if reason := _elsewhere(self.variable, self._pair):
            return reason
        if self.variable.kind == FOREIGN:
            return "this version does not know this variable"
        return self._pair.other_errors if self.variable.quantity.tolerance in OF_THE_RUN else ""

    def _reason(self) -> str:
        """Return the reason for the allowed difference."""
        rule = self.variable.quantity.tolerance
        if self._exact:
            return "the option exact requires equal bits"
        if rule == GRID and self.variable.name not in self._pair.axes:
            # a single value, not computed from a range
            return "a number in a request is exact to rounding"
        return rule.reason

    def _all_different(self, note: str, excused: bool = False) -> "Finding":
        name, pair = self.variable.name, self._pair
        size = (pair.reference if name in pair.reference.variables else pair.new)[name].size
        different, on_edge = (0, size) if excused else (size, 0)
        units = self.variable.quantity.units
        return Finding(name, units, size, different, on_edge, False, reason=self._reason(), note=note)

    def _finding(self, bitwise: bool) -> "Finding":
        quantity, tally = self.variable.quantity, self._tally
        found = Finding(
            quantity.name,
            quantity.units,
            values=self._pair.reference[quantity.name].size,
            different=0 if bitwise else tally.beyond,
            on_edge=tally.excused,
            bitwise=bitwise,
            reason="the tolerance was given" if self.limit is not None and not bitwise else self._reason(),
        )
        if bitwise:
            return found
        worst = self._worst_cell()
        if quantity.flags is None:
            found = replace(found, largest=max(tally.largest, 0.0), allowed=tally.allowed)
        return replace(found, share=tally.ratio, worst=worst)

    def _worst_cell(self) -> "Cell | None":
        """Return the cell with the largest ratio to the allowed difference; cells beyond it come first."""
        worst, pair = self._tally.worst, self._pair
        if worst is None or not (worst.beyond or worst.ratio > 0.0):
            return None
        values = pair.reference[self.variable.name]
        places = np.unravel_index(worst.place, values.shape) if values.ndim else ()
        where = {
            str(dim): float(pair.reference[dim].values[i]) if dim in pair.reference.coords else float(i)
            for dim, i in zip(values.dims, places, strict=True)
        }
        known, flags = pair.spec.model.parameters, self.variable.quantity.flags
        words = [
            f"{dim} {known[dim].spell(value) if dim in known else int(value)}" for dim, value in where.items()
        ]
        new, reference, apart = (
            None if np.isnan(value) else value for value in (*worst.values, worst.difference)
        )
        named = "" if flags is None else " and ".join(_flag(value, flags) for value in (new, reference))
        return Cell(where, new, reference, apart, worst.allowed, ", ".join(words) or "the only one", named)


def _flag(value: float | None, flags: Mapping[int, str]) -> str:
    return "missing" if value is None else flags.get(int(value), f"code {value:g}")


def _elsewhere(variable: Variable, pair: Pair) -> str:
    """Return why the values of a variable belong to different places in the two atlases; empty if they do not."""
    if along := cut_along(variable, pair):
        return along
    ways = pair.boundaries
    # brackets of different widths around the same place can still be compared
    if ways[0] != ways[1] and (variable.kind == CURVE or variable.quantity.tolerance == EDGE_HALFWIDTH):
        return f"the option boundary differs: {' and '.join(ways)}"
    return ""


def _other_kind(new: "xr.DataArray", old: "xr.DataArray") -> str:
    if new.shape != old.shape:
        # curves with different numbers of points cannot be compared point by point
        return f"it has {counted(new.size, 'value')}, but {old.size} in the reference"
    if new.dims != old.dims:
        return f"its dimensions differ: {', '.join(map(str, new.dims))} and {', '.join(map(str, old.dims))}"
    if {new.dtype.kind, old.dtype.kind} - set("biuf"):
        return f"its types differ: {new.dtype} and {old.dtype}"
    return ""


def _other_meaning(new: "xr.DataArray", old: "xr.DataArray") -> str:
    for key in MEANING:
        if not np.array_equal(np.asarray(new.attrs.get(key)), np.asarray(old.attrs.get(key))):
            return f"its {key} differ: {new.attrs.get(key)} and {old.attrs.get(key)}"
    return ""
