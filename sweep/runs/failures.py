"""The cells of a run that could not be computed: how many, of which kind, and where the first few are."""

from dataclasses import dataclass, field

import numpy as np

from sweep.engine.compute import Block
from sweep.model.description import FAILED
from sweep.request.spec import SweepSpec

#: How many cells are listed.
LISTED = 10


@dataclass
class Failures:
    """Cells whose ending says that they could not be computed.

    `counts` maps each code of these endings to the number of cells; `first` holds (cell, ending) of the first ones in C
    order.
    """

    counts: dict[int, int]
    first: list[tuple[int, int]] = field(default_factory=list)

    @classmethod
    def none(cls, spec: SweepSpec) -> "Failures":
        """Return the count of a run before its first cell."""
        return cls(dict.fromkeys(spec.model.endings.codes(FAILED), 0))

    @property
    def total(self) -> int:
        """Number of failed cells."""
        return sum(self.counts.values())

    def count(self, block: Block) -> None:
        """Count the failed cells of the next block in C order."""
        endings = block.columns["ending"]
        for code in self.counts:
            self.counts[code] += int(np.count_nonzero(endings == code))
        if len(self.first) < LISTED and self.total:
            failed = np.flatnonzero(np.isin(endings, list(self.counts)))[: LISTED - len(self.first)]
            self.first += [(block.span.start + int(at), int(endings[at])) for at in failed]

    def describe(self, spec: SweepSpec) -> list[str]:
        """Return one line on how many cells failed, and one for each of the first ones: its coordinates and ending."""
        names = spec.model.endings.flags
        kinds = " and ".join(f"{count} {names[code]}" for code, count in self.counts.items() if count)
        share = 100.0 * self.total / spec.size
        return [
            f"{self.total} of {spec.size} cells could not be computed ({share:.3g} %): {kinds}",
            *(f"    {_coordinates(spec, cell)}: {names[code]}" for cell, code in self.first),
            *(["    ..."] if self.total > len(self.first) else []),
        ]


def _coordinates(spec: SweepSpec, cell: int) -> str:
    words = []
    for name, place in zip(spec.axes, np.unravel_index(cell, spec.shape), strict=True):
        quantity = spec.model.parameters[name]
        units = "deg" if quantity.units == "rad" else ""
        words.append(f"{name}={getattr(spec, name).array()[place] * quantity.plot_scale:.9g}{units}")
    return " ".join(words) or "the only cell"
