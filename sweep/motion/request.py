"""The request for one motion: its start, its duration, and the friction coefficient of the contact.

The words of a sweep, each with one number::

    TrajectorySpec(tilt="10deg", precession_rate=0.5, roll_rate="steady", duration="60s")
    TrajectorySpec.from_words(["tilt_rate=0.01", "roll_rate=3"])
"""

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from sweep.errors import RequestError
from sweep.model.disk.model import DISK
from sweep.motion.quantities import MOTION_INPUTS, MOTION_WORDS
from sweep.request.spec import MOST_STEPS
from sweep.request.values import read_number
from sweep.request.words import AUTOMATIC, names, one_of, read_input, read_title, split_words, unknown_word

_NAMES = (*MOTION_INPUTS, *MOTION_WORDS)
#: Words of a sweep only, for suggestions.
_ELSEWHERE = {name: "run" for name in names(DISK) if name not in _NAMES}

#: A sample takes 180 bytes: a request for more than 1.8 GB is taken for a mistake.
_MOST_SAMPLES = 10**7

#: Samples of a motion with interval=auto; a motion that turns fast gets more (`sweep.motion.trajectory`).
_SAMPLES = 1000


@dataclass(frozen=True, kw_only=True)
class TrajectorySpec:
    """One start and how it is integrated, everything in SI. Make one with `read` or `from_words`.

    `roll_rate` may be ``"steady"``, `step` and `interval` may be ``"auto"``; the names are those of
    `motion.quantities.MOTION_INPUTS` and `motion.quantities.MOTION_WORDS`.
    """

    tilt: float
    tilt_rate: float
    precession_rate: float
    roll_rate: float | str
    alpha: float
    radius: float
    gravity: float
    mass: float
    friction: float
    duration: float
    interval: float | str
    step: float | str
    fall_tilt: float
    title: str
    method: str

    @classmethod
    def read(cls, **words: Any) -> Self:
        """Return the request of these words: text with units, or numbers in SI.

        Raises
        ------
        RequestError
            If a word is not known, a value is not possible, or values do not go together.
        """
        for name in words:
            if name not in _NAMES:
                unknown_word(name, _NAMES, DISK, _ELSEWHERE)
        given: dict[str, Any] = {name: row.default for name, row in MOTION_INPUTS.items()}
        given |= {name: row.default for name, row in MOTION_WORDS.items()} | words
        values: dict[str, Any] = {name: _read_word(name, raw) for name, raw in given.items()}
        spec = cls(**values)
        _check_start(spec)
        _check_counts(spec)
        return spec

    @classmethod
    def from_words(cls, words: Sequence[str]) -> Self:
        """Return the request of ``NAME=VALUE`` words, each name once.

        Raises
        ------
        RequestError
            As in `read`.
        """
        return cls.read(**split_words(words, _NAMES, DISK, _ELSEWHERE))

    @property
    def times(self) -> "np.ndarray[Any, np.dtype[np.float64]]":
        """Times of the samples [s], shape (n,): evenly from 0 to the duration; with interval=auto the first guess."""
        return np.linspace(0.0, self.duration, self._intervals() + 1)

    def canonical(self) -> str:
        """Return the request as ASCII JSON with sorted keys, numbers in SI, the same text for equal requests."""
        return json.dumps(asdict(self), sort_keys=True, separators=(",", ":"), allow_nan=False)

    def _intervals(self) -> int:
        if isinstance(self.interval, str):
            return _SAMPLES
        # a whole number of them: 10 s at 0.01 s are 1000 in spite of the rounding of 0.01
        return max(1, math.ceil(self.duration / self.interval * (1.0 - 1e-9)))


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
