"""What one motion of a model is: the words of its request and the variables of its file."""

from collections.abc import Mapping
from dataclasses import dataclass

from sweep.model.description import Model
from sweep.model.quantity import GRID, Input, Quantity, Word

#: The only dimension. Not called time: CF checkers require a calendar date for that name.
TIME = Quantity("elapsed_time", "t", "s", "time since the start", GRID)


@dataclass(frozen=True)
class MotionKind:
    """The motions of one model.

    Attributes
    ----------
    model : Model
    inputs : mapping of str to Input
        The words of a request whose values are numbers: the parameters of the model first.
    words : mapping of str to Word
        Those whose values are text.
    variables : mapping of str to Quantity
        What the file holds; what has one value for each sample has the dimension elapsed_time.
    fixed : tuple of str
        Inputs that the file holds as scalar coordinates; the start is the first sample.
    largest_tilt : str
        The input that every tilt of a motion stays below.
    ending_time : str
        The variable with the moment [s] at which the motion came to its end before its duration.
    endings : mapping of str to str
        Flag of the variable ending -> what the disk did then, in words.
    headline : str
        The title of a motion without one.
    summary : str
        What the file holds, for its attributes.
    kernels : str
        The module of the compiled functions that integrate it.
    figure : str
        ``module:function`` that draws one motion.
    stops : bool
        Whether a motion comes to an end of its own: its samples are closer towards it, and a film that cannot show all
        of a motion shows its end.
    """

    model: Model
    inputs: Mapping[str, Input]
    words: Mapping[str, Word]
    variables: Mapping[str, Quantity]
    fixed: tuple[str, ...]
    largest_tilt: str
    ending_time: str
    endings: Mapping[str, str]
    headline: str
    summary: str
    kernels: str
    figure: str
    stops: bool = False

    @property
    def rows(self) -> tuple[Input | Word, ...]:
        """The rows of both tables of words."""
        return (*self.inputs.values(), *self.words.values())

    @property
    def names(self) -> tuple[str, ...]:
        """All words of a request."""
        return (*self.inputs, *self.words, *self.model.substitutes)
