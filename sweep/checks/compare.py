"""The regression check: compare an atlas with a reference.

Coordinates must agree with the specs. Decisions (endings, verdicts) must be equal, measures must agree within the
accuracy that the two atlases state (`sweep.checks.variables`), and a value that is missing in one must be missing in
the other. In a borderline cell the last bit decides: such flips are counted separately. The new atlas must have every
cell variable of the reference; a variable that only the new atlas has is noted, but is not a difference.
"""

import math
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from sweep.atlas.selection import as_atlas
from sweep.checks.alignment import Pair, align
from sweep.checks.cell_pair import CellPair
from sweep.checks.finding import MEANING, Finding, HeldVariable
from sweep.checks.variables import read_limits, variables
from sweep.errors import RequestError
from sweep.files.reading import atlas_of
from sweep.progress.display import following
from sweep.progress.timetable import Progress, Stage, Timetable

if TYPE_CHECKING:
    import xarray as xr

#: Name of the progress stage.
COMPARING: Final = "comparing"

#: Attributes whose contents `align` has compared.
_COMPARED = ("sweep_spec", "sweep_fingerprint")


@dataclass(frozen=True)
class Comparison:
    """The result of a comparison: `same` if no value differs, except where borderline cells flipped."""

    cells: int
    common: bool
    findings: tuple[Finding, ...]
    #: attribute -> (new, reference): the time, program and wording of the requests, which may differ
    provenance: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Whether the two atlases agree."""
        return not any(finding.different for finding in self.findings)

    @property
    def identical(self) -> bool:
        """Whether the two atlases have the same variables with the same bits; attributes may differ."""
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
    """Replace NaN and infinity, which JSON lacks, by None: ratios to an allowed 0, values of damaged files."""
    if isinstance(value, dict):
        return {key: _without_infinities(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_infinities(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def compare(
    new: "xr.Dataset | str | os.PathLike[str]",
    reference: "xr.Dataset | str | os.PathLike[str]",
    *,
    common: bool = False,
    tolerances: Mapping[str, float | str] | None = None,
    exact: bool = False,
    progress: Progress = None,
) -> Comparison:
    """Compare an atlas with a trusted one.

    Cells are read block by block: files of any size with equal grids take some tens of megabytes of memory.

    Parameters
    ----------
    new, reference : xarray.Dataset, str or Path
        Atlases from `sweep.run` or `sweep.open_atlas`, selections from them, or their files.
    common : bool
        Compare only the cells that both atlases have. Otherwise their grids must be equal.
    tolerances : mapping of str to float or str, optional
        Variable -> allowed difference, in SI or as text with a unit, instead of the accuracy that the atlases state.
    exact : bool
        Require all bits of all variables to be equal: no cell counts as borderline, and no variable is skipped.
    progress : bool or callable, optional
        As in `sweep.run`.

    Returns
    -------
    Comparison

    Raises
    ------
    RequestError
        If a coordinate disagrees with its spec; if the atlases are not comparable, because their parameters, criterion,
        method, duration, fall_tilt or grids differ; or if a tolerance or `progress` is invalid.
    """
    with atlas_of(new) as one, atlas_of(reference) as other:
        pair = align(as_atlas(one), as_atlas(other), common=common)
        findings, notes = _compared(pair, tolerances or {}, exact, progress)
        size = pair.reference["ending"].size
        return Comparison(size, common, findings, _provenance(pair), notes)


def _compared(
    pair: Pair, tolerances: Mapping[str, float | str], exact: bool, progress: Progress
) -> tuple[tuple[Finding, ...], tuple[str, ...]]:
    """Return the findings on the variables of two aligned atlases, and notes on the variables not compared."""
    held = [HeldVariable(each, pair, exact) for each in variables(pair)]
    if exact and tolerances:
        raise RequestError(
            "The option exact requires equal bits and allows no tolerances; got both.",
            hint="Omit exact or the tolerances.",
        )
    measured = {each.variable.name: each.variable.quantity for each in held if each.variable.has_tolerance}
    for name, limit in read_limits(tolerances, measured).items():
        next(each for each in held if each.variable.name == name).limit = limit
    with following(progress) as show:
        timetable = Timetable([Stage(COMPARING, pair.reference["ending"].size)], show)
        timetable.begin(COMPARING)
        cells = CellPair(pair, timetable.report)
        per_cell = [each for each in held if each.variable.name in cells.names]
        flipped = [np.zeros(0, np.intp)]
        for block in cells.blocks():
            flips = {} if exact else cells.flips(block)
            flipped += [block.places[each] for each in flips.values()]
            for each in per_cell:
                each.add_cells(block, flips)
    on_edge = np.unique(np.concatenate(flipped))
    for each in held:
        if each.variable.name not in cells.names:
            each.add_whole(on_edge)
    findings, notes = [], list(pair.notes)
    for each in held:
        found = each.outcome(bool(on_edge.size))
        if isinstance(found, str):
            notes.append(f"{each.variable.name} is not compared: {found}")
        else:
            findings.append(found)
    return tuple(findings), tuple(notes)


def _provenance(pair: Pair) -> dict[str, tuple[str, str]]:
    """Return the attributes that differ: the time, program and wording of the requests."""
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
            found |= {f"{name}:{key}": values for key, values in _different(*both, MEANING).items()}
    return found


def _different(
    new: Mapping[Any, Any], old: Mapping[Any, Any], leave: tuple[str, ...]
) -> dict[str, tuple[str, str]]:
    return {
        str(key): (str(new.get(key, "")), str(old.get(key, "")))
        for key in dict.fromkeys([*old, *new])
        if key not in leave and str(new.get(key, "")) != str(old.get(key, ""))
    }
