"""The request for one motion: its start, its duration, and the friction coefficient of the contact.

The words of a sweep, each with one number::

    TrajectorySpec.read(tilt="10deg", precession_rate=0.5, roll_rate="steady", duration="60s")
    TrajectorySpec.from_words(["tilt_rate=0.01", "roll_rate=3"])
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, make_dataclass, replace
from typing import Any, Self

import numpy as np

from kernels.disk.endings import FELL, HORIZON
from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import PARAMETERS, SETTINGS, VARIABLES
from sweep.model.quantity import ERROR_GAUGE, GRID, Array, Input, Quantity, Tolerance, Word, positive, table
from sweep.request.spec import MOST_STEPS
from sweep.request.substitutes import resolved
from sweep.request.suggestions import unknown_word
from sweep.request.values import read_number
from sweep.request.words import AUTOMATIC, names, one_of, read_input, read_title, split_words

#: The methods of integration of a single motion: the engine's own, and SciPy's for comparison.
MOTION_METHODS = ("rk4", "dop853")

ROLLS, SLIPS, LIFTS = 0, 1, 2

_EXACT = VARIABLES["ending"].tolerance
_STATE = Tolerance(1e-8, 1e-8, "the report's motions agree to this with an integrator of order 8")
_FORCE = Tolerance(1e-6, 1e-6, "forces follow from the squares of rates and a second derivative")


#: The words of a request for one motion whose values are numbers.
MOTION_INPUTS: Mapping[str, Input] = table(
    *PARAMETERS.values(),
    Input("mass", "m", "kg", "mass of the disk", GRID, default=1.0, rule="mass > 0", allows=positive),
    Input(
        "friction", r"\mu", "1", "friction coefficient of disk and plane", GRID,
        default=0.5, rule="friction > 0", allows=positive,
    ),
    replace(SETTINGS["duration"], long_name="time simulated", default=10.0),
    Input(
        "interval", r"\Delta t", "s", "time between samples at most", GRID,
        default="auto", rule="interval > 0, or auto", allows=positive, words=("auto",),
    ),
    replace(SETTINGS["step"], long_name="longest time step"),
    SETTINGS["fall_tilt"],
)  # fmt: skip

MOTION_WORDS: Mapping[str, Word] = table(
    Word("title", "what the motion is, in one line", ""),
    Word("method", "how the motion is integrated", MOTION_METHODS[0], MOTION_METHODS),
)

# fmt: off
#: The variables of the file of one motion; all but the last two have the dimension elapsed_time.
TRAJECTORY: Mapping[str, Quantity] = table(
    Quantity("tilt", r"\theta", "rad", "tilt of the plane of the disk from the vertical", _STATE,
             "0 = upright; positive towards (cos heading, sin heading)"),
    Quantity("tilt_rate", r"\dot\theta", "rad s-1", "rate of the tilt", _STATE),
    Quantity("precession_rate", r"\dot\psi", "rad s-1", "rate of the heading about the vertical", _STATE),
    Quantity("roll_rate", r"\dot\phi", "rad s-1", "rate of roll about the axis of the disk, in the precessing frame",
             _STATE),
    Quantity("heading", r"\psi", "rad", "heading, counted on from 0", _STATE,
             "the disk rolls towards (-sin heading, cos heading) while its roll rate is positive"),
    Quantity("roll_angle", r"\phi", "rad", "roll angle about the axis of the disk, counted on from 0", _STATE),
    Quantity("contact_x", "", "m", "x of the contact point on the plane", _STATE),
    Quantity("contact_y", "", "m", "y of the contact point on the plane", _STATE),
    Quantity("centre_x", "x_c", "m", "x of the centre of mass", _STATE),
    Quantity("centre_y", "y_c", "m", "y of the centre of mass", _STATE),
    Quantity("centre_z", "z_c", "m", "height of the centre of mass over the plane", _STATE),
    Quantity("energy", "E", "J", "energy, kinetic and potential", _STATE),
    Quantity("energy_drift", r"\Delta E/E", "1", "relative change of the energy since the start", ERROR_GAUGE,
             "the exact motion conserves energy, so this is an error of the integration"),
    Quantity("vertical_momentum", r"H\cdot e_3", "kg m2 s-1",
             "vertical angular momentum about the contact point", _STATE,
             "not conserved: the contact point moves, and not along the velocity of the centre"),
    Quantity("vertical_momentum_rate", r"m R^2 \dot\phi\,\dot\theta\cos\theta", "kg m2 s-2",
             "right-hand side of the balance law of the vertical momentum", _STATE,
             "mass radius^2 roll_rate tilt_rate cos(tilt)"),
    Quantity("vertical_momentum_residual", r"\delta H", "kg m2 s-1",
             "change of the vertical momentum less the integral of its rate", ERROR_GAUGE,
             "zero for the exact motion: the check of the balance law"),
    Quantity("normal_force", "N", "N", "normal force of the plane on the disk", _FORCE),
    Quantity("friction_across", r"\lambda_1", "N", "horizontal force across the track", _FORCE,
             "towards (cos heading, sin heading); multiplier of the first constraint"),
    Quantity("friction_along", r"\lambda_2", "N", "horizontal force along the track", _FORCE,
             "towards (-sin heading, cos heading); multiplier of the second constraint"),
    Quantity("friction_needed", r"\mu", "1", "friction coefficient needed to roll without slipping", _FORCE,
             "horizontal over normal force; missing where the normal force is not positive"),
    Quantity("contact", "", "1", "whether rolling without slipping is believable", _EXACT,
             "the motion itself never slips: slips marks where it would need more than the friction coefficient, "
             "lifts_off where the plane would have to pull",
             "i1", {ROLLS: "rolls", SLIPS: "slips", LIFTS: "lifts_off"}),
    Quantity("ending", "", "1", "how the integration ended", _EXACT,
             "horizon: the duration was over; fell: the tilt reached fall_tilt",
             "i1", {HORIZON: "horizon", FELL: "fell"}),
    VARIABLES["fall_time"],
)
# fmt: on

#: The only dimension. Not called time: CF checkers require a calendar date for that name.
TIME = Quantity("elapsed_time", "t", "s", "time since the start", GRID)


_NAMES = (*MOTION_INPUTS, *MOTION_WORDS, *DISK.substitutes)
#: Words of a sweep only, for suggestions.
_ELSEWHERE = {name: "it is a word of eulerdisk run" for name in names(DISK) if name not in _NAMES} | {
    "model": "eulerdisk simulate follows the disk, and no other model"
}

#: A sample takes 180 bytes: a request for more than 1.8 GB is taken for a mistake.
_MOST_SAMPLES = 10**7

#: Samples of a motion with interval=auto; a motion that turns fast gets more (`sweep.motion.trajectory`).
_SAMPLES = 1000


def _field(row: Input | Word) -> tuple[str, object]:
    if isinstance(row, Word):
        return row.name, str
    return row.name, (float | str) if row.words else float


#: A field for each row of the tables, so that a parameter which the disk gets is a word of a single motion too.
_Fields = make_dataclass(
    "_Fields",
    [*map(_field, MOTION_INPUTS.values()), *map(_field, MOTION_WORDS.values())],
    frozen=True,
    kw_only=True,
)


@dataclass(frozen=True, kw_only=True)
class TrajectorySpec(_Fields):  # type: ignore[misc, valid-type]  # made from tables, which mypy does not follow
    """One start and how it is integrated, everything in SI. Make one with `read` or `from_words`.

    Its fields are the words of ``eulerdisk simulate`` (docs/motions.md). `roll_rate` may be ``"steady"``, or
    `precession_rate` ``"steady-slow"`` or ``"steady-fast"``; `step` and `interval` may be ``"auto"``.
    """

    @classmethod
    def read(cls, **words: Any) -> Self:
        """Return the request of these words: text with units, or numbers in SI.

        Instead of a rate it may be given scaled, or as a speed, as in a sweep (docs/words.md).

        Raises
        ------
        RequestError
            If a word is not known, a value is not possible, or values do not go together.
        """
        check_names(words)
        words = resolved(words, DISK, read=read_number)
        given: dict[str, Any] = {name: row.default for name, row in MOTION_INPUTS.items()}
        given |= {name: row.default for name, row in MOTION_WORDS.items()} | words
        values: dict[str, Any] = {name: _read_word(name, raw) for name, raw in given.items()}
        spec = cls(**values)
        _check_start(spec)
        _check_counts(spec)
        return spec

    @classmethod
    def from_words(cls, words: Sequence[str]) -> Self:
        """Return the request of ``NAME=VALUE`` words, each name once; raises as `read` does."""
        return cls.read(**split_motion_words(words))

    @property
    def times(self) -> Array:
        """Times of the samples [s], shape (n,): evenly from 0 to the duration; with interval=auto the first guess."""
        if isinstance(self.interval, str):
            return np.linspace(0.0, self.duration, _SAMPLES + 1)
        # a whole number of them: 10 s at 0.01 s are 1000 in spite of the rounding of 0.01
        count = max(1, math.ceil(self.duration / self.interval * (1.0 - 1e-9)))
        return np.linspace(0.0, self.duration, count + 1)

    def canonical(self) -> str:
        """Return the request as ASCII JSON with sorted keys, numbers in SI, the same text for equal requests."""
        return json.dumps(asdict(self), sort_keys=True, separators=(",", ":"), allow_nan=False)


def split_motion_words(words: Sequence[str]) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words of a request for one motion.

    Raises
    ------
    RequestError
        If a word has no ``=``, is not known, or comes twice.
    """
    return split_words(words, _NAMES, DISK, _ELSEWHERE)


def check_names(words: Iterable[str]) -> None:
    """Refuse a name that is no word of a request for one motion.

    Raises
    ------
    RequestError
    """
    for name in words:
        if name not in _NAMES:
            unknown_word(name, _NAMES, DISK, _ELSEWHERE)


def _read_word(name: str, raw: object) -> float | str:
    if name == "title":
        return read_title(raw)
    if name in MOTION_WORDS:
        return one_of(MOTION_WORDS[name], raw)
    value = read_input(MOTION_INPUTS[name], raw, read_number)
    assert isinstance(value, float | str)
    return value


def _check_start(spec: TrajectorySpec) -> None:
    if abs(spec.tilt) >= spec.fall_tilt:
        raise RequestError(
            "This disk has fallen before it starts: |tilt| must be below fall_tilt; got "
            f"tilt={math.degrees(spec.tilt):.6g}deg fall_tilt={math.degrees(spec.fall_tilt):.6g}deg.",
            hint="Start with a smaller tilt, or give a larger fall_tilt.",
            where="tilt",
        )
    try:
        DISK.check(asdict(spec))
    except RequestError as error:
        # the disk's own hint is a range, and a motion takes one number
        hint = "Give a precession_rate, as in precession_rate=0.5, or a number for roll_rate."
        raise RequestError(error.message, hint=hint, where=error.where) from None


def _check_counts(spec: TrajectorySpec) -> None:
    for name, most in (("interval", _MOST_SAMPLES), ("step", MOST_STEPS)):
        value = getattr(spec, name)
        if isinstance(value, float) and not spec.duration / value <= most:
            raise RequestError(
                f"These are too many {'samples' if name == 'interval' else 'steps'}: duration / {name} must be at most "
                f"{most}; got duration={spec.duration!r} {name}={value!r}.",
                hint=f"Give a longer {name}, a shorter duration, or {name}={AUTOMATIC}.",
                where=name,
            )
