"""The words of losses that a page may give, and what they ask of a motion."""

from collections.abc import Mapping
from typing import Any

from sweep.errors import RequestError, shown
from sweep.model.lossy_disk.tables import BILDSTEN, LOSS_PARAMETERS, NO_AIR

#: Air at room temperature: viscosity [Pa s], density [kg/m3].
_AIR = {"air_viscosity": 1.8e-5, "air_density": 1.2}

#: The mass [kg] where none is given and a law needs one.
MASS = 1.0

#: Names of the words.
LOSS_WORDS = (*LOSS_PARAMETERS, "mass", "friction", "air_law")


def loss_words(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the words of a request for a motion with losses.

    Parameters
    ----------
    given : mapping of str to number or text
        What the controls ask for, in SI. Air at room temperature and a mass of 1 kg are added where a law needs them;
        a mass alone is no loss.

    Raises
    ------
    RequestError
        If a name is none of a loss.
    """
    for name in given:
        if name not in LOSS_WORDS:
            raise RequestError(
                f"{shown(name)} is no loss; losses are {', '.join(LOSS_WORDS)}.",
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
    # the word that says that the disk is one with losses, if only the friction coefficient is given
    words = {"air_law": NO_AIR} | dict(given)
    law = words["air_law"]
    if law != NO_AIR:
        words = {"air_viscosity": _AIR["air_viscosity"]} | words
        if law == BILDSTEN:
            words = {"air_density": _AIR["air_density"]} | words
    if needs_mass(words):
        words = {"mass": MASS} | words
    return words


def needs_mass(words: Mapping[str, Any]) -> bool:
    """Return whether a law of some words depends on the mass of the disk."""
    return words.get("air_law", NO_AIR) != NO_AIR or bool(words.get("contour_damping"))
