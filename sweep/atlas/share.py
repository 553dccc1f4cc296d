"""The unstable share of a list of starts, with its confidence interval."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas.dataset import place_of, require, spec_named
from sweep.errors import RequestError, counted
from sweep.model.quantity import FAILED, MISSING, STABLE, UNSTABLE

if TYPE_CHECKING:
    import xarray as xr

#: Quantile of the normal distribution at 97.5 %: plus and minus this value enclose 95 %.
_QUANTILE = 1.959963984540054


@dataclass(frozen=True)
class Share:
    """The number of unstable starts of a list, and of others.

    Attributes
    ----------
    unstable, stable : int
        Starts with a verdict.
    undecided, failed, missing : int
        Starts without a verdict: undecided by the criterion, impossible to compute, or not computed.
    """

    unstable: int
    stable: int
    undecided: int
    failed: int
    missing: int

    @property
    def decided(self) -> int:
        """Number of starts with a verdict."""
        return self.unstable + self.stable

    @property
    def value(self) -> float:
        """Unstable share of the decided starts; NaN if there are none."""
        return self.unstable / self.decided if self.decided else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % confidence interval for the probability that a start is unstable.

        Notes
        -----
        Wilson, J. Am. Stat. Assoc. 22 (1927) 209. The starts must be drawn independently of each other.
        """
        return wilson(self.unstable, self.decided)

    def percentages(self) -> tuple[str, str, str]:
        """Return the share and the ends of its interval in per cent, with as many digits as the interval justifies."""
        low, high = self.interval
        digits = max(0, min(8, 1 - math.floor(math.log10(100.0 * (high - low)))))
        value, least, most = (f"{100.0 * each:.{digits}f}" for each in (self.value, low, high))
        return value, least, most


def wilson(count: int, total: int, quantile: float = _QUANTILE) -> tuple[float, float]:
    """Return Wilson's interval for a probability, from `count` hits in `total` draws; (0, 1) without draws."""
    if not total:
        return 0.0, 1.0
    share, weight = count / total, quantile**2 / total
    middle = (share + 0.5 * weight) / (1.0 + weight)
    half = math.sqrt(weight * (share * (1.0 - share) + 0.25 * weight)) / (1.0 + weight)
    # without hits, or with only hits, one end is known
    return (middle - half if count else 0.0), (middle + half if count < total else 1.0)


def unstable_share(dataset: "xr.Dataset") -> Share:
    """Return the unstable share of a list of starts, or of a selection from one.

    Raises
    ------
    RequestError
        If the atlas is a grid, whose share depends only on where its axes end.
    """
    spec = spec_named(dataset)
    if not spec.is_list:
        raise RequestError(
            "The unstable share needs random starts; this atlas is a grid, whose share depends only on where its axes "
            "end.",
            hint="Run it with distributions and samples, as in roll_rate=uniform:2:4 samples=1e6.",
            where=place_of(dataset),
        )
    require(dataset, ("stability", "ending"))
    verdicts, endings = (np.asarray(dataset[name].values) for name in ("stability", "ending"))
    failed, missing = (spec.model.endings.have(role, endings) for role in (FAILED, MISSING))
    unstable, stable = (int(np.count_nonzero(verdicts == code)) for code in (UNSTABLE, STABLE))
    lost = int(np.count_nonzero(failed)), int(np.count_nonzero(missing))
    return Share(unstable, stable, verdicts.size - unstable - stable - sum(lost), *lost)


def in_words(found: Share) -> str:
    """Return a share as a line of a report."""
    apart = {"undecided": found.undecided, "failed": found.failed, "not computed": found.missing}
    rest = ", ".join(f"{count} {word}" for word, count in apart.items() if count)
    left_out = f"; left out: {rest}" if rest else ""
    if not found.decided:
        return f"no start has a verdict{left_out}"
    share, low, high = found.percentages()
    decided = counted(found.decided, "start")
    return f"{share} % of {decided} with a verdict; 95 % interval {low} to {high} % (Wilson){left_out}"
