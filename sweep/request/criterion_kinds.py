"""The kinds of criteria, a row for each: its notation, condition, verdicts and words.

Some conditions have a short form. A cell is unstable under ``departure:5deg`` if the tilt leaves its steady value by
more than 5 degrees, under ``amplification:10`` if it leaves it by more than ten times the size of the perturbation,
and under ``aloft:10s`` if the disk falls within 10 seconds.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from sweep.model.quantity import (
    DECISION,
    FINAL,
    LOST,
    OPEN,
    SENSITIVE,
    STABLE,
    UNDECIDED,
    UNDISTURBED,
    UNSTABLE,
    Quantity,
)
from sweep.request.expression import Comparison, Number, Variable

#: Names in the conditions of `KINDS` that are not variables of a cell: the coordinate's largest distance from its
#: undisturbed value, the size of the perturbation, and the time at which the motion was lost. No expression can use
#: them, because they contain blanks.
REACH, SCALE, LOST_TIME = "the reach", "the scale", "the lost time"

#: Role of an ending -> the verdicts if the condition is true, if it is false, and if a value is missing. Cells whose
#: endings have other roles are undecided.
Outcomes = Mapping[str, tuple[int, int, int]]

#: A lost motion is unstable. A motion beyond the limit is unstable too, even if time ran out later. Only a cell whose
#: extremes are final and within the limit is stable.
BY_REACH: Outcomes = {
    FINAL: (UNSTABLE, STABLE, UNDECIDED),
    OPEN: (UNSTABLE, UNDECIDED, UNDECIDED),
    LOST: (UNSTABLE, UNSTABLE, UNSTABLE),
}
#: A motion that was not lost before the limit is stable if it continues forever or for the duration, and undecided if
#: its continuation is unknown.
_BY_TIME: Outcomes = {
    FINAL: (STABLE, STABLE, STABLE),
    OPEN: (UNDECIDED, STABLE, STABLE),
    LOST: (UNSTABLE, STABLE, STABLE),
}
#: A cell is unstable where the condition is true, even if time ran out later. Where it is false, a cell is stable if
#: its ending is final (a fall is), and undecided if time ran out or nothing was disturbed. If a cell is too sensitive
#: to its start for its ending to be known, its accurate variables decide (`Criterion.decide`).
_BY_EXPRESSION: Outcomes = {
    FINAL: (UNSTABLE, STABLE, STABLE),
    SENSITIVE: (UNSTABLE, STABLE, UNDECIDED),
    LOST: (UNSTABLE, STABLE, STABLE),
    OPEN: (UNSTABLE, UNDECIDED, UNDECIDED),
    UNDISTURBED: (UNSTABLE, UNDECIDED, UNDECIDED),
}


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of criteria.

    Parameters
    ----------
    name : str
    outcomes : mapping of str to tuple of int
    form, example : str
        Its notation, and an example; empty for a kind that no request can ask for.
    quantity : Quantity, optional
        The quantity of the limit, in ``KIND:LIMIT``.
    condition : callable, optional
        Limit -> the condition that makes a cell unstable.
    limit : str
        The limit in words, with a placeholder for the number.
    positive : str
        Why the limit has to be above 0.
    unstable, label, caption, comment : str
        Templates, filled with `Criterion.words`: what makes a cell unstable, in a sentence; the criterion's label in a
        figure; its short caption there; the file's ASCII comment on the verdicts, if they do not follow from a limit.
    """

    name: str
    outcomes: Outcomes
    form: str = ""
    example: str = ""
    quantity: Quantity | None = None
    condition: Callable[[float], Comparison] | None = None
    limit: str = "{}"
    positive: str = "The limit of a criterion must be above 0, or nothing is stable"
    unstable: str = "{text}"
    label: str = "{text}"
    caption: str = "{text}"
    comment: str = ""


def _limit_of_reach(
    quantity: Quantity, form: str, example: str, limit: str, largest: Callable[[float], Number | Variable]
) -> Kind:
    """Return a kind that limits how far the coordinate goes; `largest` turns the limit into this distance."""
    return Kind(
        name=quantity.name,
        form=f"{quantity.name}:{form}",
        example=f"{quantity.name}:{example}",
        quantity=quantity,
        condition=lambda given: Comparison((Variable(REACH), largest(given)), (">",)),
        outcomes=BY_REACH,
        limit=limit,
        unstable="the {coordinate} leaves its steady value by more than {limit}{or_lost}",
        label="{kind} {short}",
        caption="{kind} above {short}{or_lost}",
    )


_TIME = Quantity("aloft", "", "s", "time before which the motion must not be lost", DECISION)
_DEPARTURE = Quantity("departure", "", "rad", "largest distance from the steady value", DECISION)
_AMPLIFICATION = Quantity("amplification", "", "1", "that distance over the perturbation", DECISION)

_ROWS = (
    Kind(
        name="aloft",
        form="aloft:TIME",
        example="aloft:10s",
        quantity=_TIME,
        condition=lambda given: Comparison((Variable(LOST_TIME), Number(given, "s")), ("<",)),
        outcomes=_BY_TIME,
        positive="The time of a criterion must be above 0, or every motion is stable",
        unstable="{lost} in less than {limit}",
        label="{kind} {short}",
        caption="{kind} for less than {short}",
        comment="unstable where {lost_time} of a lost motion is below {limit}; stable where the motion lasts as long; "
        "an unresolved cell is undecided",
    ),
    _limit_of_reach(
        _AMPLIFICATION, "NUMBER", "10", "{} times the perturbation", lambda given: Variable(SCALE, given)
    ),
    _limit_of_reach(_DEPARTURE, "ANGLE", "5deg", "{}", lambda given: Number(given, "rad")),
    Kind(
        name="expression",
        outcomes=_BY_EXPRESSION,
        form="an expression over the variables of a cell",
        example="peak_tilt > 10deg",
        comment="unstable where {text}, a comparison with a missing value being false; else stable where the ending is "
        "{final}; an unresolved cell is undecided",
    ),
    Kind(
        name="function",
        outcomes=_BY_EXPRESSION,
        unstable="the {text}, which judged this atlas in memory, returns True",
        comment="unstable where the Python {text} says so",
    ),
)
KINDS: Mapping[str, Kind] = MappingProxyType({each.name: each for each in _ROWS})
