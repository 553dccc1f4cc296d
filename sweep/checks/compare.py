"""The regression check: compare an atlas with a reference.

Coordinates have to be those of the specs. Decisions (endings, verdicts) must be equal, measures must agree within what
the two atlases state (`sweep.checks.variables`), and a value that is missing in one must be missing in the other. In a
borderline cell the last bit decides: such flips are counted apart. What a reference holds of its cells, the new atlas
must hold; what only the new one holds is named, and no difference.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from sweep.atlas.selection import require_atlas, settled
from sweep.checks.alignment import Pair, align
from sweep.checks.cell_pair import CellBlock, CellPair, Flips, flips, no_flips
from sweep.checks.difference import Cell, Differences, Judged, other_bits
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
    read_limits,
    variables,
)
from sweep.engine.grid import Span, chunks
from sweep.errors import RequestError, counted
from sweep.model.quantity import EDGE_HALFWIDTH, ERROR_GAUGE, GRID, STEP_COUNT, TIMED, Array, Truths
from sweep.progress.display import following
from sweep.progress.timetable import Progress, Show, Stage, Timetable

if TYPE_CHECKING:
    import xarray as xr

#: Name of the stage.
COMPARING: Final = "comparing"

#: Attributes of a variable that give its numbers their meaning.
_MEANING = ("units", "flag_values", "flag_meanings")

#: Attributes of an atlas whose contents `align` has compared.
_COMPARED = ("sweep_spec", "sweep_fingerprint")


@dataclass(frozen=True)
class Finding:
    """The comparison of one variable.

    `different` counts the values beyond what is allowed, `on_edge` those that differ because a borderline cell flipped.
    Of the other values that both have, `largest` is the largest absolute difference, `allowed` what is allowed there,
    both in the units of the variable, 0 for flags, and `share` the largest difference over what is allowed. `bitwise`
    says whether all bits are the same, `reason` why that much is allowed.
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


@dataclass(frozen=True)
class Comparison:
    """The result of a comparison: `same` if no value differs, except because of borderline cells."""

    cells: int
    common: bool
    findings: tuple[Finding, ...]
    #: attribute -> (new, reference): when, by what and in which words they were made; these may differ
    provenance: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Whether the two atlases agree."""
        return not any(finding.different for finding in self.findings)

    @property
    def identical(self) -> bool:
        """Whether the two atlases hold the same variables with the same bits; attributes aside."""
        return self.same and not self.notes and all(finding.bitwise for finding in self.findings)

    @property
    def outcome(self) -> str:
        """One of ``identical``, ``within tolerance`` and ``different``."""
        if self.identical:
            return "identical"
        return "within tolerance" if self.same else "different"

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain types, for JSON."""
        found: dict[str, Any] = {"outcome": self.outcome, "same": self.same, **asdict(self)}
        for finding in found["findings"]:
            if finding["worst"] is not None:
                del finding["worst"]["place"], finding["worst"]["flags"]
        plain: dict[str, Any] = _without_infinities(found)
        return plain


def _without_infinities(value: Any) -> Any:
    """Replace numbers that JSON does not have by None: shares where nothing is allowed, values of damaged files."""
    if isinstance(value, dict):
        return {key: _without_infinities(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_infinities(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def compare(
    new: "xr.Dataset",
    reference: "xr.Dataset",
    *,
    common: bool = False,
    tolerances: Mapping[str, float | str] | None = None,
    exact: bool = False,
    progress: Progress = None,
) -> Comparison:
    """Compare an atlas with a trusted one.

    Cells are read block by block: of files of any size with equal grids, some tens of megabytes are in memory at once.

    Parameters
    ----------
    new, reference : xarray.Dataset
        Atlases, as `sweep.run` or `sweep.open_atlas` returns them, or selections from some.
    common : bool
        Compare only the cells that both have; otherwise the grids must be the same.
    tolerances : mapping of str to float or str, optional
        Variable -> largest difference allowed, in SI or as text with a unit, instead of what the atlases state.
    exact : bool
        All bits of all variables have to be the same; no cell is borderline, and no variable is left out.
    progress : bool or callable, optional
        As in `sweep.run`.

    Returns
    -------
    Comparison

    Raises
    ------
    RequestError
        If a coordinate of one is not that of its spec; if the two are not comparable: other parameters, criterion,
        method, duration or fall_tilt, or other grids; or if a tolerance cannot be that of a variable, or `progress` is
        something else.
    """
    for dataset in (new, reference):
        require_atlas(dataset)
    new, reference = settled(new, trusting=True), settled(reference, trusting=True)
    pair = align(new, reference, common=common)
    held = list(variables(pair))
    if exact and tolerances:
        raise RequestError(
            "Equal bits leave no tolerance: exact goes without tolerances; got both.",
            hint="Leave one of them out.",
        )
    measured = {each.name: each.quantity for each in held if each.has_tolerance}
    limits = read_limits(tolerances or {}, measured)
    size = pair.reference["ending"].size
    with following(progress) as show:
        cells = CellPair(pair, _passes(size, show))
        judge = _Exact(cells, held) if exact else _Judge(cells, held, limits)
        judged = [judge.outcome(each) for each in held]
        gathered = _gathered(cells, [each for each in judged if isinstance(each, _Rule)])
    findings, notes = [], []
    for each, found in zip(held, judged, strict=True):
        if isinstance(found, str):
            notes.append(f"{each.name} is not compared: {found}")
        else:
            findings.append(_finding(found, gathered[each.name], pair) if isinstance(found, _Rule) else found)
    if exact:
        findings = [replace(each, reason="every bit has to be the same") for each in findings]
    return Comparison(size, common, tuple(findings), _provenance(pair), (*pair.notes, *notes))


def _passes(size: int, show: Show) -> Callable[[int], None]:
    """Return the callback for the number of cells of a pass that are done; the number of passes is not known before."""
    timetable: Timetable | None = None
    last = size

    def seen(done: int) -> None:
        nonlocal timetable, last
        if timetable is None or done <= last:
            timetable = Timetable([Stage(COMPARING, size)], show)
            timetable.begin(COMPARING)
        last = done
        timetable.report(done)

    return seen


class _Rule:
    """How far the values of a variable may differ, for which both have some that do.

    Parameters
    ----------
    variable : Variable
    pair : Pair
    flips : Flips
        Which cells are on an edge.
    exactly : bool
        Whether all bits have to be the same.
    limit : float or None
        What the caller allows.
    """

    def __init__(
        self, variable: Variable, pair: Pair, flips: Flips, exactly: bool = False, limit: float | None = None
    ) -> None:
        self.variable, self._pair, self._flips = variable, pair, flips
        self._exactly, self.given = exactly, limit

    def of_cells(self, cells: CellPair, block: CellBlock) -> Judged:
        """Judge the cells of a block."""
        name, span = self.variable.name, block.span
        old = block.reference[name]
        if self._exactly or self.given is not None:
            most = np.full(old.shape, self.given or 0.0)
        else:
            starts = cells.starts(np.arange(span.start, span.stop))
            most = allowed_of_cells(self.variable.quantity, *cells.stated(block), starts)
        excused = self._flips.of(name, span) if self.variable.kind == CELL else np.zeros(len(span), bool)
        return self._judged(block.new[name], old, most, excused)

    def of_others(self) -> Iterator[tuple[int, Judged]]:
        """Judge all values of a variable that has not one per cell; yield the first flat index of some, and these."""
        whole = self._pair.reference[self.variable.name]
        excused = _excused(self.variable, self._pair, self._flips)
        if self.variable.kind not in (CURVE, EDGE):
            yield 0, self._of_part(self._pair, excused)
            return
        for span, places in chunks(whole.shape):
            part = self._pair.part(dict(zip(whole.dims, places, strict=True)))
            yield span.start, self._of_part(part, excused[places])

    def _of_part(self, pair: Pair, excused: Truths) -> Judged:
        name = self.variable.name
        new, old = pair.new[name].values, pair.reference[name].values
        if self._exactly or self.given is not None:
            most: Any = np.full(old.shape, self.given or 0.0)
        else:
            most = allowed(self.variable.quantity, pair)
        columns = (new, old, np.broadcast_to(most, old.shape), np.broadcast_to(excused, old.shape))
        return self._judged(*(np.asarray(each).reshape(-1) for each in columns))

    def _judged(self, new: Any, old: Any, most: Array, excused: Truths) -> Judged:
        distance, gaps = _apart(new, old)
        if self._exactly:
            beyond = other_bits(new, old)
        else:
            beyond = gaps | (distance > most) | np.isnan(most) | _of_other_sign(self.variable, new, old)
        return Judged(new, old, beyond, excused, gaps, distance, most)


def _gathered(cells: CellPair, rules: Sequence[_Rule]) -> dict[str, Differences]:
    """Return what the differences of variables come to; of those with one value per cell in one pass over the cells."""
    gathered = {each.variable.name: Differences() for each in rules}
    per_cell = [each for each in rules if each.variable.name in cells.names]
    for each in rules:
        if each not in per_cell:
            for start, judged in each.of_others():
                gathered[each.variable.name].add(start, judged)
    model = cells.pair.spec.model
    needed = dict.fromkeys((*(each.variable.name for each in per_cell), *model.extremes, model.error_name))
    for block in cells.blocks([name for name in needed if name in cells.names]) if per_cell else ():
        for each in per_cell:
            name, start = each.variable.name, block.span.start
            # the first block counts in any case: where nothing differs, what is allowed is that of the first cell
            if start == 0 or other_bits(block.new[name], block.reference[name]).any():
                gathered[name].add(start, each.of_cells(cells, block))
    return gathered


class _Exact:
    """All bits of all variables have to be the same."""

    def __init__(self, cells: CellPair, held: Sequence[Variable]) -> None:
        self._cells = cells
        self._alike = cells.alike([each.name for each in held if each.name in cells.names])

    def outcome(self, variable: Variable) -> "Finding | str | _Rule":
        """Return the finding, the reason why there is none, or the rule by which values are judged."""
        pair, name = self._cells.pair, variable.name
        if missing := lacking(name, pair):
            return _all_different(variable, pair, missing)
        if along := cut_along(variable, pair):
            return along
        new, old = pair.new[name], pair.reference[name]
        if other := _other_meaning(new, old) or _other_kind(new, old):
            return _all_different(variable, pair, other)
        if self._cells.same(name, self._alike):
            return _alike(variable, pair)
        return _Rule(variable, pair, no_flips(), exactly=True)


class _Judge:
    """Values may differ as far as the two atlases state, or as the caller allows."""

    def __init__(self, cells: CellPair, held: Sequence[Variable], limits: Mapping[str, float]) -> None:
        self._cells, self._limits = cells, limits
        self._alike = cells.alike([each.name for each in held if each.name in cells.names])
        decisions = {"ending", "stability"}
        self._flips = no_flips() if decisions <= self._alike else flips(cells)

    def outcome(self, variable: Variable) -> "Finding | str | _Rule":
        """Return the finding, the reason why there is none, or the rule by which values are judged."""
        pair, name, limit = self._cells.pair, variable.name, self._limits.get(variable.name)
        elsewhere = _elsewhere(variable, pair)
        if missing := lacking(name, pair):
            may = may_lack(variable, pair)
            return elsewhere or (missing if may else _all_different(variable, pair, missing))
        new, old = pair.new[name], pair.reference[name]
        other = _other_meaning(new, old)
        if self._cells.same(name, self._alike) and not other:
            return _alike(variable, pair)
        if (reason := elsewhere or self._left_out(variable)) and limit is None:
            return reason
        if other := other or _other_kind(new, old):
            return _all_different(variable, pair, other, _excused(variable, pair, self._flips))
        return _Rule(variable, pair, self._flips, limit=limit)

    def _left_out(self, variable: Variable) -> str:
        """Return why a difference of a variable is not judged; empty if it is."""
        rule = variable.quantity.tolerance
        if variable.kind == FOREIGN:
            return "this version does not know it"
        # errors and work of the integration belong to its steps and its kernels, not to the motion
        return self._cells.pair.other_errors if rule in (ERROR_GAUGE, STEP_COUNT) else ""


def _excused(variable: Variable, pair: Pair, flips: Flips) -> Truths:
    """Return which values may differ because a borderline cell flips: the flag, or what follows from it."""
    name, shape = variable.name, pair.reference["ending"].shape
    if variable.kind == CURVE or not flips.both.size:
        # not np.full: curves, and the rows of an edge, may be many
        found = variable.kind == CURVE and flips.both.size > 0
        return np.broadcast_to(np.bool_(found), pair.reference[name].shape)
    if variable.kind == EDGE:
        # the bracket moves with the verdict that flips; the lines of theory do not depend on cells
        axis = pair.axes.index(variable.axis)
        moved = np.zeros((*shape[:axis], *shape[axis + 1 :]), bool)
        if name.startswith("boundary_"):
            places = np.unravel_index(flips.both, shape)
            moved[*places[:axis], *places[axis + 1 :]] = True
        return moved
    if variable.kind == CELL:
        return flips.of(name, Span(0, math.prod(shape))).reshape(shape)
    return np.zeros(pair.reference[name].shape, bool)


def _elsewhere(variable: Variable, pair: Pair) -> str:
    """Return why the values of a variable belong to other places in the two; empty if they do not."""
    if along := cut_along(variable, pair):
        return along
    ways = pair.boundaries
    # brackets around one place can be compared, however wide
    if ways[0] != ways[1] and (variable.kind == CURVE or variable.quantity.tolerance == EDGE_HALFWIDTH):
        return f"boundary differs: {' and '.join(ways)}"
    return ""


def _other_kind(new: "xr.DataArray", old: "xr.DataArray") -> str:
    if new.shape != old.shape:
        # curves of different numbers or lengths cannot be compared point by point
        return f"{counted(new.size, 'value')}, in the reference {old.size}"
    if new.dims != old.dims:
        return f"its dimensions differ: {', '.join(map(str, new.dims))} and {', '.join(map(str, old.dims))}"
    if {new.dtype.kind, old.dtype.kind} - set("biuf"):
        return f"its types differ: {new.dtype} and {old.dtype}"
    return ""


def _other_meaning(new: "xr.DataArray", old: "xr.DataArray") -> str:
    for key in _MEANING:
        if not np.array_equal(np.asarray(new.attrs.get(key)), np.asarray(old.attrs.get(key))):
            return f"its {key} differ: {new.attrs.get(key)} and {old.attrs.get(key)}"
    return ""


def _apart(new: Any, old: Any) -> tuple[Array, Truths]:
    """Return the absolute differences, NaN where a value is missing, and where only one of two is."""
    one, other = new.astype(np.float64), old.astype(np.float64)
    with np.errstate(invalid="ignore"):
        return np.abs(one - other), np.isnan(one) != np.isnan(other)


def _of_other_sign(variable: Variable, new: Any, old: Any) -> Truths:
    """Return where one of two times, errors or numbers of steps is negative, which none can be."""
    rule = variable.quantity.tolerance
    if rule not in (ERROR_GAUGE, STEP_COUNT) and rule.stated != TIMED:
        return np.zeros(old.shape, bool)
    differ: Truths = (new < 0.0) != (old < 0.0)
    return differ


def _reason(variable: Variable, pair: Pair) -> str:
    """Return why the values of a variable may differ as far as they may."""
    if variable.quantity.tolerance == GRID and variable.name not in pair.axes:
        # which no range has made
        return "a number that was given is known to rounding"
    return variable.quantity.tolerance.reason


def _alike(variable: Variable, pair: Pair) -> Finding:
    size = pair.reference[variable.name].size
    return Finding(variable.name, variable.quantity.units, size, 0, 0, True, reason=_reason(variable, pair))


def _all_different(variable: Variable, pair: Pair, note: str, excused: Truths | None = None) -> Finding:
    held = pair.reference if variable.name in pair.reference.variables else pair.new
    size = held[variable.name].size
    on_edge = size if excused is not None and excused.any() and excused.all() else 0
    return Finding(
        variable.name, variable.quantity.units, size, size - on_edge, on_edge, False,
        reason=_reason(variable, pair), note=note,
    )  # fmt: skip


def _finding(rule: _Rule, found: Differences, pair: Pair) -> Finding:
    variable, flags = rule.variable, rule.variable.quantity.flags
    return Finding(
        name=variable.name,
        units=variable.quantity.units,
        values=pair.reference[variable.name].size,
        different=found.different,
        on_edge=found.on_edge,
        bitwise=False,
        largest=0.0 if flags else max(found.largest, 0.0),
        allowed=0.0 if flags else found.allowed,
        share=found.share,
        worst=found.worst(variable.name, pair, flags),
        reason="it was given" if rule.given is not None else _reason(variable, pair),
    )


def _provenance(pair: Pair) -> dict[str, tuple[str, str]]:
    """Return the attributes in which the two differ: when, by what and in which words they were made."""
    found = _different(pair.new.attrs, pair.reference.attrs, _COMPARED)
    new, reference = pair.specs
    found |= {
        f"sweep_spec:{name}": (str(getattr(new, name)), str(getattr(reference, name)))
        for name in reference.words()
        if getattr(new, name) != getattr(reference, name)
    }
    if new == reference:
        found |= _different(
            {key: pair.new.attrs.get(key, "") for key in _COMPARED},
            {key: pair.reference.attrs.get(key, "") for key in _COMPARED},
            (),
        )
    for name in pair.reference.variables:
        if name in pair.new.variables:
            both = (pair.new[name].attrs, pair.reference[name].attrs)
            found |= {f"{name}:{key}": values for key, values in _different(*both, _MEANING).items()}
    return found


def _different(
    new: Mapping[Any, Any], old: Mapping[Any, Any], leave: tuple[str, ...]
) -> dict[str, tuple[str, str]]:
    return {
        str(key): (str(new.get(key, "")), str(old.get(key, "")))
        for key in dict.fromkeys([*old, *new])
        if key not in leave and str(new.get(key, "")) != str(old.get(key, ""))
    }
