"""The kinds of criteria: how each is written, its condition, its verdicts and its words, one row for each.

Some conditions are written shorter than as an expression: ``departure:5deg`` is that the tilt leaves its steady value
by more than 5 degrees, ``amplification:10`` that it leaves it by more than ten times the scale of the perturbation,
``aloft:10s`` that the disk falls before 10 seconds are over.
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

#: Names in the conditions of `KINDS`, beside the variables of a cell: how far the coordinate went from its undisturbed
#: value, the size of the perturbation, and the time at which the motion was lost. No expression can spell them.
REACH, SCALE, LOST_TIME = "the reach", "the scale", "the lost time"

#: Role of an ending -> the verdict where the condition is true, where it is false, and where a value is missing. Cells
#: with other roles are undecided.
Outcomes = Mapping[str, tuple[int, int, int]]

#: A lost motion is unstable, and so is one beyond the limit, even if time ran out after it. Only a cell whose extremes
#: are final and within the limit is stable.
BY_REACH: Outcomes = {
    FINAL: (UNSTABLE, STABLE, UNDECIDED),
    OPEN: (UNSTABLE, UNDECIDED, UNDECIDED),
    LOST: (UNSTABLE, UNSTABLE, UNSTABLE),
}
#: A motion that ended otherwise than by a loss before the time is stable if it goes on for all time or for the
#: duration, and undecided if how it went on is not known.
_BY_TIME: Outcomes = {
    FINAL: (STABLE, STABLE, STABLE),
    OPEN: (UNDECIDED, STABLE, STABLE),
    LOST: (UNSTABLE, STABLE, STABLE),
}
#: Unstable where the condition is true, also for what was measured until time ran out. Where it is false a cell is
#: stable if its ending is final, a fall too, and undecided if time ran out or nothing was disturbed. Of one that is too
#: sensitive to its start to say how it ends, what is known well enough decides (`Criterion.decide`).
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
        How it is written, and an example; empty for a kind that no request can ask for.
    quantity : Quantity, optional
        What the limit is read as, in ``KIND:LIMIT``.
    condition : callable, optional
        Limit -> where a cell is unstable.
    limit : str
        The limit in words, with a place for the number.
    positive : str
        Why the limit has to be above 0.
    unstable, label, caption, comment : str
        What makes a cell unstable, in a sentence; the criterion as a figure names it, and what is unstable as short as
        it says it; what the file says of the verdicts, if they do not follow from a limit; ASCII. With places for
        what `Criterion.words` holds.
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
    """Return a kind that limits how far the coordinate goes, to `largest` of the limit."""
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
        positive="The time of a criterion must be above 0, or every motion lasts as long",
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
        unstable="the {text} says so, which judged this atlas in memory",
        comment="unstable where the Python {text} says so",
    ),
)
KINDS: Mapping[str, Kind] = MappingProxyType({each.name: each for each in _ROWS})
