"""The regression check: compare an atlas with a reference.

Coordinates have to be those of the specs. Decisions (endings, verdicts) must be equal, measures must agree within what
the two atlases state (`sweep.checks.allowed`), and a value that is missing in one must be missing in the other. In a
borderline cell the last bit decides: such flips are counted apart. What a reference holds of its cells, the new atlas
must hold; what only the new one holds is named, and no difference.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.dataset import require
from sweep.checks.alignment import Pair, align
from sweep.checks.allowed import allowed, read_limits
from sweep.checks.borderline import endings_on_edge, verdicts_on_edge
from sweep.checks.difference import Cell, bitwise, other_bits, share_of, worst
from sweep.checks.variables import (
    CELL,
    CURVE,
    EDGE,
    FOREIGN,
    Variable,
    cut_along,
    lacking,
    may_lack,
    variables,
)
from sweep.errors import RequestError
from sweep.model.quantity import EDGE_HALFWIDTH, ERROR_GAUGE, STEP_COUNT, TIMED, Array, Truths

if TYPE_CHECKING:
    import xarray as xr

#: Attributes of a variable that give its numbers their meaning.
_MEANING = ("units", "flag_values", "flag_meanings")

#: Attributes of an atlas whose contents `align` has compared.
_COMPARED = ("sweep_spec", "sweep_fingerprint")


@dataclass(frozen=True)
class Finding:
    """The comparison of one variable.

    `different` counts the values beyond what is allowed, `on_edge` those that differ because a borderline cell flipped.
    Of the other values that both have, `largest` is the largest absolute difference, `allowed` what is allowed there,
    both in the units of the variable, and `share` the largest difference over what is allowed. `bitwise` says whether
    all bits are the same, `reason` why that much is allowed.
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
                del finding["worst"]["place"]
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
) -> Comparison:
    """Compare an atlas with a trusted one.

    Parameters
    ----------
    new, reference : xarray.Dataset
        Atlases, as `sweep.run` or `sweep.open_atlas` returns them.
    common : bool
        Compare only the cells that both have; otherwise the grids must be the same.
    tolerances : mapping of str to float or str, optional
        Variable -> largest difference allowed, in SI or as text with a unit, instead of what the atlases state.
    exact : bool
        All bits of all variables have to be the same; no cell is borderline, and no variable is left out.

    Returns
    -------
    Comparison

    Raises
    ------
    RequestError
        If a coordinate of one is not that of its spec; if the two are not comparable: other parameters, criterion,
        method, duration or fall_tilt, or other grids; or if a tolerance cannot be that of a variable.
    """
    pair = align(new, reference, common=common)
    for dataset in (new, reference):
        require(dataset, ("stability", *pair.spec.model.extremes))
    held = list(variables(pair))
    if exact and tolerances:
        raise RequestError(
            "Equal bits leave no tolerance: exact goes without tolerances; got both.",
            hint="Leave one of them out.",
        )
    measured = {each.name: each.quantity for each in held if each.has_tolerance}
    limits = read_limits(tolerances or {}, measured)
    judge = _Exact(pair) if exact else _Judge(pair, limits)
    findings, notes = [], []
    for each in held:
        found = judge(each)
        if isinstance(found, Finding):
            findings.append(found)
        else:
            notes.append(f"{each.name} is not compared: {found}")
    cells = pair.reference["ending"].size
    return Comparison(cells, common, tuple(findings), _provenance(pair), (*pair.notes, *notes))


class _Exact:
    """All bits of all variables have to be the same."""

    def __init__(self, pair: Pair) -> None:
        self._pair = pair

    def __call__(self, variable: Variable) -> Finding | str:
        pair, name = self._pair, variable.name
        if missing := lacking(name, pair):
            return _all_different(variable, pair, missing)
        if along := cut_along(variable, pair):
            return along
        new, old = pair.new[name], pair.reference[name]
        if other := _other_meaning(new, old) or _other_kind(new, old):
            return _all_different(variable, pair, other)
        if bitwise(new, old):
            return _alike(variable, pair)
        beyond = other_bits(new.values, old.values)
        distance, gaps = _apart(new.values, old.values)
        return _finding(
            variable, pair, beyond, np.zeros_like(beyond), gaps, distance, np.zeros_like(distance)
        )


class _Judge:
    """Values may differ as far as the two atlases state, or as the caller allows."""

    def __init__(self, pair: Pair, limits: Mapping[str, float]) -> None:
        self._pair, self._limits = pair, limits
        self._endings = endings_on_edge(pair)
        self._verdicts = verdicts_on_edge(pair, self._endings)

    def __call__(self, variable: Variable) -> Finding | str:
        pair, name, limit = self._pair, variable.name, self._limits.get(variable.name)
        elsewhere = _elsewhere(variable, pair)
        if missing := lacking(name, pair):
            may = may_lack(variable, pair)
            return elsewhere or (missing if may else _all_different(variable, pair, missing))
        new, old = pair.new[name], pair.reference[name]
        other = _other_meaning(new, old)
        if bitwise(new, old) and not other:
            return _alike(variable, pair)
        if (reason := elsewhere or self._left_out(variable)) and limit is None:
            return reason
        excused = self._excused(variable)
        if other := other or _other_kind(new, old):
            return _all_different(variable, pair, other, excused)
        distance, gaps = _apart(new.values, old.values)
        most = allowed(variable.quantity, pair) if limit is None else np.full(old.shape, limit)
        return _finding(
            variable,
            pair,
            gaps | (distance > most) | np.isnan(most) | _of_other_sign(variable, new.values, old.values),
            excused,
            gaps,
            distance,
            most,
            limit is not None,
        )

    def _left_out(self, variable: Variable) -> str:
        """Return why a difference of a variable is not judged; empty if it is."""
        rule = variable.quantity.tolerance
        if variable.kind == FOREIGN:
            return "this version does not know it"
        # errors and work of the integration belong to its steps and its kernels, not to the motion
        return self._pair.other_errors if rule in (ERROR_GAUGE, STEP_COUNT) else ""

    def _excused(self, variable: Variable) -> Truths:
        """Return which values may differ because a borderline cell flips: the flag, or what follows from it."""
        pair, name = self._pair, variable.name
        flips = self._endings | self._verdicts
        if variable.kind == CURVE:
            return np.full(pair.reference[name].shape, bool(flips.any()))
        if variable.kind == EDGE:
            # the bracket moves with the verdict that flips; the lines of theory do not depend on cells
            moved = np.any(flips, axis=pair.axes.index(variable.axis))
            return moved if name.startswith("boundary_") else np.zeros_like(moved)
        if variable.kind == CELL:
            return self._verdicts if name == "stability" else self._endings
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
        return f"{new.size} values, in the reference {old.size}"
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


def _alike(variable: Variable, pair: Pair) -> Finding:
    size = pair.reference[variable.name].size
    return Finding(
        variable.name, variable.quantity.units, size, 0, 0, True, reason=variable.quantity.tolerance.reason
    )


def _all_different(variable: Variable, pair: Pair, note: str, excused: Truths | None = None) -> Finding:
    held = pair.reference if variable.name in pair.reference.variables else pair.new
    size = held[variable.name].size
    on_edge = size if excused is not None and excused.any() and excused.all() else 0
    return Finding(
        variable.name, variable.quantity.units, size, size - on_edge, on_edge, False,
        reason=variable.quantity.tolerance.reason, note=note,
    )  # fmt: skip


def _finding(
    variable: Variable,
    pair: Pair,
    beyond: Truths,
    excused: Truths,
    gaps: Truths,
    distance: Array,
    most: Array,
    given: bool = False,
) -> Finding:
    judged = np.where(excused | np.isnan(distance), 0.0, distance)
    place = np.unravel_index(int(np.argmax(judged)), judged.shape) if judged.size else ()
    share = share_of(judged, most)
    return Finding(
        name=variable.name,
        units=variable.quantity.units,
        values=beyond.size,
        different=int((beyond & ~excused).sum()),
        on_edge=int((beyond & excused).sum()),
        bitwise=False,
        largest=float(judged[place]),
        allowed=float(most[place]),
        share=float(share.max()) if share.size else 0.0,
        worst=worst(variable.name, pair, beyond & ~excused, gaps & ~excused, judged, most),
        reason="it was given" if given else variable.quantity.tolerance.reason,
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
