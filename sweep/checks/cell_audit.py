"""The cells of an atlas held against the exact reference of its model, and against a repetition of its integration."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from sweep.checks.statement import MOST_NAMED, Statement, unchecked
from sweep.engine.compute import measure, measured_quantities
from sweep.engine.grid import Span, blocks, starts_of
from sweep.model.description import MISSING, CellCheck, Columns, ExactReference, Starts
from sweep.model.quantity import Quantity, Truths
from sweep.request.spec import MOST_STEPS, SweepSpec

#: Steps that are repeated at most: about a second. Of an atlas of more steps every k-th cell is integrated again.
_MOST_STEPS = 1e9

#: The count of the steps of each cell.
_STEPS = "steps"

#: Share of the cells of a block whose times have to come out the same, to the bit, if the processor computes as the one
#: that made the atlas; and the number of cells that may be corrupt in a small block.
_SAME, _FEW = 0.99, 3

_AGAIN = "its computation, repeated"


class CellAudit:
    """What is found of the cells of an atlas, block by block.

    Parameters
    ----------
    spec : SweepSpec
    reference : ExactReference
    stored : mapping of str to array, shape (spec.size,)
        The variables of the atlas with one value per cell.
    own : bool
        Whether the code that made the atlas is this code, by its hash.

    Attributes
    ----------
    repeated : bool
        Whether cells that were integrated again came out the same, to the bit: another processor rounds otherwise.
    """

    def __init__(self, spec: SweepSpec, reference: ExactReference, stored: Columns, own: bool) -> None:
        self.repeated = own
        self._spec, self._reference, self._stored, self._own = spec, reference, stored, own
        self._tallies: dict[tuple[str, str], _Tally] = {}
        self._wrong: dict[str, _Places] = {}
        self._stride = _stride(spec, stored) if own else 0
        self._quantities = {
            **spec.model.cell_variables(spec),
            **{n: spec.model.parameters[n] for n in spec.computed},
        }

    def audited(self, names: Iterable[str]) -> dict[str, npt.NDArray[np.generic]]:
        """Check all cells, and return the variables of the audit: arrays of shape (spec.size,)."""
        spec, audit = self._spec, self._reference.audit
        found = {name: np.empty(spec.size, audit.variables[name].dtype) for name in names}
        for span in blocks(spec.size):
            here = slice(span.start, span.stop)
            starts, stored = starts_of(spec, span), {name: each[here] for name, each in self._stored.items()}
            variables, checks = self._reference.check(spec, starts, stored)
            others = self._others(span, starts, stored)
            agreeing = ~np.isin(variables["audit"], (*audit.disagreeing, audit.missing))
            wrong: dict[str, Truths] = {}
            for each in (*checks, *others):
                self._tally(each).add(span.start, each)
                if not each.share and (self._own or not each.promise):
                    wrong[each.name] = each.wrong | wrong.get(each.name, np.zeros(len(span), bool))
            for name, cells in wrong.items():
                self._wrong.setdefault(name, _Places()).add(span.start, cells)
            some = np.any(list(wrong.values()), axis=0) & agreeing
            variables["audit"] = np.where(some, audit.other, variables["audit"])
            for name, column in found.items():
                column[here] = variables[name]
        return found

    def statements(self) -> Iterator[Statement]:
        """Yield what was found of each variable, in the order of the file; each once."""
        for name, quantity in self._quantities.items():
            tallies = [each for (variable, _), each in self._tallies.items() if variable == name]
            if name in self._stored and tallies:
                counting = [each for each in tallies if each.counts(self._own)]
                yield _joined(name, quantity, counting, self._wrong.get(name, _Places()), self._spec)

    def _tally(self, check: CellCheck) -> "_Tally":
        return self._tallies.setdefault((check.name, check.against), _Tally(check))

    def _others(self, span: Span, starts: Starts, stored: Columns) -> list[CellCheck]:
        """Return the checks by repetition: of the integration, and else of what follows from the stored extremes."""
        checks = list(self._again(span, starts, stored)) if self._stride else []
        if self._stride != 1:
            more = self._spec.model.measure_more(self._spec, starts, stored)
            for name, values in more.items():
                if name in stored:
                    against = "its computation, repeated from the stored extremes"
                    there = np.ones(stored[name].shape, bool)
                    checks.append(
                        _repeated(self._quantities[name], against, stored[name], values, False, there)
                    )
        return checks

    def _again(self, span: Span, starts: Starts, stored: Columns) -> Iterator[CellCheck]:
        """Yield the checks by a repetition of the integration of every k-th cell."""
        spec, first = self._spec, -span.start % self._stride
        which = slice(first, None, self._stride)
        measured = measure(spec, {name: np.ascontiguousarray(each[which]) for name, each in starts.items()})
        kept = {name: each[which] for name, each in stored.items()}
        there = ~spec.model.endings.have(MISSING, kept["ending"])
        exactly = _same_rounding(spec, kept, measured, there)
        self.repeated &= exactly
        for name in measured_quantities(spec):
            if name in stored:
                against = _AGAIN if exactly else f"{_AGAIN} on a processor that rounds otherwise"
                check = _repeated(self._quantities[name], against, kept[name], measured[name], exactly, there)
                yield _spread(check, which, len(span))


def _stride(spec: SweepSpec, stored: Columns) -> int:
    """Return of how many cells one is integrated again."""
    # the steps of a corrupt file may be anything
    counts = np.abs(np.nan_to_num(np.asarray(stored.get(_STEPS, np.ones(spec.size)), np.float64), posinf=0.0))
    return max(1, int(np.ceil(np.minimum(counts, MOST_STEPS).sum() / _MOST_STEPS)))


def _same_rounding(spec: SweepSpec, stored: Columns, measured: Columns, there: Truths) -> bool:
    """Return whether the times, or else the extremes, came out the same to the bit in nearly all cells that are there.

    Their last bits depend on whether the processor has a fused multiply-add.
    """
    names = [
        name
        for name in spec.model.measures
        if name in stored and name not in spec.model.extremes and stored[name].dtype == np.float64
    ]
    pairs = [(stored[name], measured[name]) for name in names]
    if not any(np.isfinite(pair[1]).any() for pair in pairs):
        pairs = [(stored[name], measured[name]) for name in spec.model.extremes]
    for ours, theirs in pairs:
        known = there & (np.isfinite(ours) | np.isfinite(theirs))
        other = int(np.count_nonzero(known & (ours != theirs)))
        count = int(np.count_nonzero(known))
        if count and (other <= _FEW < count or other <= (1.0 - _SAME) * count):
            return True
    return not any(np.isfinite(theirs).any() for _, theirs in pairs)


def _repeated(
    quantity: Quantity,
    against: str,
    stored: npt.NDArray[np.generic],
    again: npt.NDArray[np.generic],
    exactly: bool,
    judged: Truths,
) -> CellCheck:
    """Return the check of a variable by a repetition: to the bit, or within its tolerance."""
    ours, theirs = np.asarray(stored, np.float64), np.asarray(again, np.float64)
    same = (ours == theirs) | (np.isnan(ours) & np.isnan(theirs))
    with np.errstate(invalid="ignore"):
        difference = np.where(same, 0.0, np.abs(ours - theirs))
    bound = quantity.tolerance
    allowed = bound.absolute + bound.relative * np.abs(np.nan_to_num(theirs))
    none = np.zeros(ours.shape)
    return CellCheck(quantity.name, against, difference, none if exactly else allowed, judged)


def _spread(check: CellCheck, which: slice, count: int) -> CellCheck:
    """Return a check of every k-th cell as one of all cells, of which the others are not judged."""
    if which == slice(0, None, 1):
        return check
    difference, allowed, judged = np.zeros(count), np.zeros(count), np.zeros(count, bool)
    difference[which], allowed[which], judged[which] = check.difference, check.allowed, check.judged
    return CellCheck(check.name, check.against, difference, allowed, judged)


class _Places:
    """How many cells, and the first of them by their flat indices."""

    def __init__(self) -> None:
        self.count = 0
        self.first: list[int] = []

    def add(self, start: int, cells: Truths) -> None:
        """Add those of the cells from `start` on for which the array of bool is true."""
        self.first += (start + np.flatnonzero(cells)[: MOST_NAMED - len(self.first)]).tolist()
        self.count += int(np.count_nonzero(cells))


class _Tally:
    """What one check has found so far: counts, the worst cell, the first cells that are further off than is allowed."""

    def __init__(self, check: CellCheck) -> None:
        self.against, self.share, self.promise = check.against, check.share, check.promise
        self.judged, self.beyond = 0, _Places()
        self.difference, self.allowed, self._ratio = np.nan, np.nan, -1.0

    def add(self, start: int, check: CellCheck) -> None:
        """Add the cells from `start` on."""
        self.judged += int(np.count_nonzero(check.judged))
        self.beyond.add(start, check.wrong)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(check.difference == 0.0, 0.0, check.difference / check.allowed)
        ratio = np.where(check.judged, np.nan_to_num(ratio, nan=np.inf, posinf=np.inf), -1.0)
        worst = int(np.argmax(ratio)) if ratio.size else 0
        if ratio.size and ratio[worst] > self._ratio:
            self._ratio = float(ratio[worst])
            self.difference, self.allowed = float(check.difference[worst]), float(check.allowed[worst])

    def counts(self, own: bool) -> bool:
        """Whether the check says anything of an atlas made by this code, or by other code."""
        return self.judged > 0 and (own or not self.promise)

    @property
    def fails(self) -> bool:
        """Whether more cells are further off than is allowed than the share lets pass.

        Of few cells more than the share may be beyond it by chance: five times the square root of the expected number,
        and five.
        """
        expected = self.share * self.judged
        return self.beyond.count > (expected + 5.0 * np.sqrt(expected) + 5.0 if self.share else 0.0)

    @property
    def ratio(self) -> float:
        """Largest difference over what is allowed for it."""
        return self._ratio

    @property
    def words(self) -> str:
        """What the variable was held against, with the share of cells that are beyond it where some may be."""
        if not self.share:
            return self.against
        found, allowed = 100.0 * self.beyond.count / self.judged, 100.0 * self.share
        return f"{self.against} ({found:.2g} % of cells beyond it, {allowed:g} % allowed)"


def _joined(
    name: str, quantity: Quantity, tallies: Sequence[_Tally], wrong: _Places, spec: SweepSpec
) -> Statement:
    """Return the statement of a variable from all its checks: the numbers are those of the worst one."""
    if not tallies:
        return unchecked(name, "made by other code, which promised nothing of it")
    worst = max(tallies, key=lambda each: (each.fails, not each.share, each.ratio))
    # a promise about a share of the cells is broken by them together
    wrong = worst.beyond if worst.fails and worst.share else wrong
    return Statement(
        name,
        "; ".join(each.words for each in tallies),
        judged=max(each.judged for each in tallies),
        wrong=wrong.count,
        difference=worst.difference,
        allowed=worst.allowed,
        units=quantity.units,
        named=[cell_in_words(spec, place) for place in wrong.first],
    )


def cell_in_words(spec: SweepSpec, place: int) -> str:
    """Return the coordinates of a cell, given by its flat index."""
    return row_in_words(spec, dict(zip(spec.axes, np.unravel_index(place, spec.shape), strict=True)))


def row_in_words(spec: SweepSpec, places: Mapping[str, np.intp]) -> str:
    """Return the coordinates of a row or a cell, given by its places along some axes."""
    parameters = spec.model.parameters
    words = [
        f"{name} {parameters[name].spell(getattr(spec, name).array()[place])}"
        for name, place in places.items()
    ]
    return ", ".join(words) or "the one cell"
