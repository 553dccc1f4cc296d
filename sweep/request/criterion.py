"""What counts as unstable: the stability criterion and its verdicts.

``departure:5deg``: the tilt leaves its steady value by more than 5 degrees. ``amplification:10``: it leaves it by
more than ten times the scale of the perturbation that was put in.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NoReturn, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown
from sweep.request.quantities import read_number
from sweep.schema import STABLE, UNDECIDED, UNSTABLE, VARIABLES, Array, Quantity

_KINDS: Mapping[str, Quantity] = MappingProxyType(
    {
        "departure": replace(VARIABLES["peak_tilt"], name="departure"),
        "amplification": VARIABLES["amplification"],
    }
)
_CODES = {name: code for code, name in (VARIABLES["ending"].flags or {}).items()}
_DO = "write departure:5deg or amplification:10"


@dataclass(frozen=True)
class Criterion:
    """A limit to how far the tilt may leave its steady value.

    Parameters
    ----------
    kind : {"departure", "amplification"}
        What is limited: the distance from the steady tilt, or that distance over the scale of the perturbation.
    limit : float
        The largest stable value: rad, between 0 and pi (departure), or a positive number (amplification).

    Raises
    ------
    RequestError
        If the kind is not known or the limit out of its range.
    """

    kind: str
    limit: float

    def __post_init__(self) -> None:
        """Refuse an unknown kind and an impossible limit."""
        if self.kind not in _KINDS:
            _refuse("not a criterion", "a criterion is departure:ANGLE or amplification:NUMBER", self.kind)
        object.__setattr__(self, "limit", read_number(self.limit, _KINDS[self.kind]))
        if not self.limit > 0.0:
            _refuse("this limit leaves nothing stable", "the limit of a criterion is above 0", str(self))
        # Two tilts inside +-90 deg are never further apart: such a limit is degrees taken for radians.
        if self.kind == "departure" and self.limit >= math.pi:
            _refuse(
                "no tilt departs that far", "a departure is below 180 deg; a bare number is in rad", str(self)
            )

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the criterion that a text spells; `str` gives the text back.

        Raises
        ------
        RequestError
            If the text is not ``departure:ANGLE`` or ``amplification:NUMBER``.
        """
        kind, colon, limit = text.partition(":")
        kind = kind.strip()
        if kind not in _KINDS or not colon:
            _refuse("not a criterion", "a criterion is departure:ANGLE or amplification:NUMBER", text)
        try:
            return cls(kind, read_number(limit, _KINDS[kind]))
        except RequestError as error:
            raise error.at("criterion", f"criterion={shown(text)}") from None

    def __str__(self) -> str:
        """Return the criterion as it is written in a request; `parse` gives exactly this criterion back."""
        if self.kind == "departure":
            return f"{self.kind}:{_angle(self.limit)}"
        return f"{self.kind}:{self.limit!r}".removesuffix(".0")

    def verdict(
        self,
        ending: npt.NDArray[np.integer],
        tilt_min: Array,
        tilt_max: Array,
        steady_tilt: Array | float,
        scale: Array | float,
    ) -> npt.NDArray[np.int8]:
        """Return the stability of cells: 0 undecided, 1 stable, 2 unstable.

        Parameters
        ----------
        ending : array of int, shape (...)
            How each cell ended, a code of `kernels.disk.endings`.
        tilt_min, tilt_max : array of float, shape (...)
            Extreme tilts in rad; what they hold where a cell has none does not matter.
        steady_tilt : array of float, broadcastable
            Tilt of the undisturbed motion in rad, 0 for an upright disk.
        scale : array of float, broadcastable
            Scale of the perturbation in rad (see `perturbation_scale`); an amplification criterion needs it.

        Returns
        -------
        array of int8, shape (...)

        Notes
        -----
        A fall is unstable. A departure beyond the limit is unstable, be it that time then ran out. Only a cell whose
        extremes are final (bounded) and within the limit is stable. All others are undecided, and so is every
        cell that could not be resolved, whatever its extremes say.
        """
        reach = np.maximum(np.abs(tilt_max - steady_tilt), np.abs(tilt_min - steady_tilt))
        limit: Array | float = self.limit
        if self.kind == "amplification":
            # nothing is amplified where nothing was put in
            limit = np.where(np.asarray(scale) > 0.0, self.limit * np.asarray(scale), np.nan)
        bounded = ending == _CODES["bounded"]
        # Both comparisons are false for NaN: a cell without numbers is neither stable nor unstable.
        beyond = (bounded | (ending == _CODES["horizon"])) & (reach > limit)
        kept = np.where(bounded & (reach <= limit), STABLE, UNDECIDED)
        return np.where(beyond | (ending == _CODES["fell"]), UNSTABLE, kept).astype(np.int8)


def perturbation_scale(
    tilt: Array | float,
    tilt_rate: Array | float,
    steady_tilt: Array | float,
    alpha: Array | float,
    radius: Array | float,
    gravity: Array | float,
) -> Array:
    """Return the scale of the perturbation in a start, in rad.

    Parameters
    ----------
    tilt, tilt_rate : array of float, broadcastable
        The start, in rad and rad/s.
    steady_tilt : array of float, broadcastable
        Tilt of the undisturbed motion, in rad.
    alpha, radius, gravity : array of float, broadcastable
        Mass distribution (0 < alpha <= 1), radius in m and gravity in m/s2.

    Returns
    -------
    array of float, shape of the broadcast
        sqrt((tilt - steady_tilt)^2 + (tilt_rate / W)^2), with W^2 = 2 gravity / ((2 + alpha) radius).

    Notes
    -----
    W is the rate at which a disk standing still falls from upright (the tilt grows as exp(W t)): it turns a kick into
    the tilt that the kick is worth.
    """
    fall_rate = np.sqrt(2.0 * np.asarray(gravity) / ((2.0 + np.asarray(alpha)) * np.asarray(radius)))
    return np.asarray(np.hypot(np.asarray(tilt) - steady_tilt, tilt_rate / fall_rate))


def _angle(radians: float) -> str:
    # Degrees where they say exactly the same angle, because 5deg can be read and 0.08726646259971647rad cannot.
    degrees = round(math.degrees(radians), 9)
    return f"{degrees:.15g}deg" if math.radians(float(f"{degrees:.15g}")) == radians else f"{radians!r}rad"


def _refuse(what: str, rule: str, given: str) -> NoReturn:
    raise RequestError(what, rule, given, _DO, "criterion")
