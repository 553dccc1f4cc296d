"""Losses of a motion: the sliders of the page with their ranges, and the words that they ask for."""

from collections.abc import Mapping
from typing import Any

from sweep.errors import RequestError, shown
from sweep.model.lossy_disk.air import needs_of
from sweep.model.lossy_disk.tables import (
    AIR_LAWS,
    ARMS,
    LOSS_PARAMETERS,
    NO_AIR,
    OPTIONS,
    PARAMETERS,
    UNKNOWN,
    UNLIMITED,
)
from sweep.motion.lossy_tables import LOSSY_BODY_MOTION, LOSSY_MOTION
from sweep.request.spec import SweepSpec

#: Air at room temperature: viscosity [Pa s], density [kg/m3].
AIR = {"air_viscosity": 1.8e-5, "air_density": 1.2}

#: Mass [kg] that is used if a law needs one and none is given.
MASS = 1.0

#: Names of the words for losses.
LOSS_WORDS = (*LOSS_PARAMETERS, "mass", "friction", "air_law")

#: Range of a slider for lever arms, in radii: a toy on its mirror has 4e-4.
_ARMS = (1e-6, 0.1)

#: Range of a slider for viscous contour friction, in units of m R^2 sqrt(g/R).
_DAMPING = (1e-6, 0.1)

#: Ranges of the sliders for the mass [kg] and for the friction coefficient.
_MASSES, _FRICTION = (1e-3, 100.0), (0.02, 2.0)


def has_losses(spec: SweepSpec) -> bool:
    """Return whether the cells of a spec have losses."""
    return spec.model in (LOSSY_MOTION.model, LOSSY_BODY_MOTION.model)


def slider_rows() -> list[dict[str, Any]]:
    """Return the controls for the losses of a motion, as the page draws them.

    Returns
    -------
    list of dict
        For a slider: ``name``, ``label``, ``description``, ``unit``, ``factor``, ``low`` and ``high`` (on a logarithmic
        scale) as multiples of what it is ``scaled`` by (radius, m R^2 sqrt(g/R), or 1), what omitting the word means
        (``none``), and at which ``end`` of the slider that is. For a choice: ``name``, ``label``, ``description`` and
        ``choices``.
    """
    law = OPTIONS["air_law"]
    return [
        *(_row(name, _ARMS, "none", scaled="radius") for name in ARMS),
        _row("contour_damping", _DAMPING, "none", scaled="damping"),
        {"name": "air_law", "label": "air", "description": law.long_name, "choices": list(AIR_LAWS)},
        _row("friction", _FRICTION, UNLIMITED, end="high"),
        _row("mass", _MASSES, UNKNOWN),
    ]


def _row(
    name: str, ends: tuple[float, float], none: str, scaled: str = "one", end: str = "low"
) -> dict[str, Any]:
    quantity = PARAMETERS[name]
    unit, factor = ("mm", 1e3) if quantity.units == "m" else (quantity.shown_units, 1.0)
    return {
        "name": name, "label": name.replace("_", " "), "description": quantity.long_name, "unit": unit,
        "factor": factor, "low": ends[0], "high": ends[1], "none": none, "end": end, "scaled": scaled,
    }  # fmt: skip


def loss_words(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the words of a request for a motion with losses.

    Parameters
    ----------
    given : mapping of str to number or text
        What the controls ask for, in SI. Air at room temperature and a mass of 1 kg are added where a law needs them; a
        mass without any law is not a loss.

    Raises
    ------
    RequestError
        If a name is not that of a loss.
    """
    for name in given:
        if name not in LOSS_WORDS:
            raise RequestError(
                f"{shown(name)} is not a loss; losses are {', '.join(LOSS_WORDS)}.",
                hint="Leave it out.",
                where="losses",
            )
        if isinstance(given[name], bool) or not isinstance(given[name], int | float | str):
            raise RequestError(
                f"{name} must be a number or a word; got {shown(given[name])}.",
                hint="Leave it out.",
                where=name,
            )
    if {*given} <= {"mass"}:
        return {}
    # selects the model with losses even if only the friction coefficient is given
    words = {"air_law": NO_AIR} | dict(given)
    law = words["air_law"]
    words = {name: AIR[name] for name in needs_of(str(law)) if name in AIR} | words
    if needs_mass(words):
        words = {"mass": MASS} | words
    return words


def needs_mass(words: Mapping[str, Any]) -> bool:
    """Return whether a law in the words depends on the mass of the disk."""
    return words.get("air_law", NO_AIR) != NO_AIR or bool(words.get("contour_damping"))
