"""The request for one motion: its start, its disk or system, and its duration.

It uses the words of a sweep, each with one number::

    TrajectorySpec.read(tilt="10deg", precession_rate=0.5, roll_rate="steady", duration="60s")
    TrajectorySpec.from_words(["tilt_rate=0.01", "roll_rate=3"])
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, make_dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from sweep.errors import RequestError
from sweep.model import registry
from sweep.model.bodies.model import BODIES
from sweep.model.description import Model
from sweep.model.disk.model import DISK
from sweep.model.quantity import Array, Input, Word
from sweep.motion.lossy_tables import LOSSY_BODY_MOTION, LOSSY_MOTION
from sweep.motion.tables import BODY_MOTION, DISK_MOTION, MotionKind, kind_of_model
from sweep.request.body import check_body_named, without_thin_body
from sweep.request.substitutes import resolved
from sweep.request.suggestions import unknown_word
from sweep.request.system_model import with_system
from sweep.request.values import at_word, read_number, words_given
from sweep.request.words import AUTOMATIC, MOST_STEPS, names, one_of, read_input, read_title, split_words

#: Largest size of a motion in bytes: a request for more is refused as a mistake.
_MOST_BYTES = 18 * 10**8

#: Number of samples of a motion with interval=auto; a fast motion gets more (`sweep.motion.trajectory`).
_SAMPLES = 1000


class MotionRequest:
    """One start and the settings of its integration, everything in SI. Make one with `read` or `from_words`.

    The fields of a request are the words of ``eulerdisk simulate`` (docs/motions.md), in the order of the tables of its
    `kind`. A rate may be a word that the model allows for it; `step` and `interval` may be ``"auto"``.
    """

    kind: ClassVar[MotionKind]

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Return a field: fields come from tables, which mypy does not understand."""

    @classmethod
    def read(cls, **words: Any) -> "MotionRequest":
        """Return the request of these words: text with units, or numbers in SI.

        A rate may also be given scaled, or as a speed, as in a sweep (docs/words.md). The words determine the model:
        any word of losses chooses the disk with losses; ``system`` is the text of a system, and ``model`` may be a
        system, as in a sweep.

        Raises
        ------
        RequestError
            If a word is not known, a value is not possible, or values do not fit together.
        """
        request_type = request_class(words)
        kind = request_type.kind
        check_body_named(kind.model, without_thin_body(words))
        words = {
            name: raw for name, raw in without_thin_body(words).items() if name not in ("model", "system")
        }
        check_names(words, kind)
        _check_kind(words, kind)
        raw_values: dict[str, Any] = {row.name: row.default for row in kind.rows}
        raw_values |= resolved(words, kind.model, read=read_number)
        spec = request_type(**{name: _read_word(kind, name, raw) for name, raw in raw_values.items()})
        _check_start(spec, words)
        _check_counts(spec, words)
        return spec

    @classmethod
    def from_words(cls, words: Sequence[str]) -> "MotionRequest":
        """Return the request of ``NAME=VALUE`` words, each name once; raises as `read` does."""
        return cls.read(**split_motion_words(words))

    @property
    def times(self) -> Array:
        """Times of the samples [s], shape (n,), evenly spaced from 0 to the duration; with interval=auto a guess."""
        if isinstance(self.interval, str):
            return np.linspace(0.0, self.duration, _SAMPLES + 1)
        # 10 s at 0.01 s are 1000 intervals despite the rounding of 0.01
        count = max(1, math.ceil(self.duration / self.interval * (1.0 - 1e-9)))
        return np.linspace(0.0, self.duration, count + 1)

    def words(self) -> dict[str, Any]:
        """Return every word with its value."""
        words: dict[str, Any] = asdict(self)  # type: ignore[call-overload]  # every kind is a dataclass
        return words | ({"system": self.kind.model.text} if self.kind.model.text else {})

    def canonical(self) -> str:
        """Return the request as ASCII JSON with sorted keys, numbers in SI, the same text for equal requests."""
        return json.dumps(self.words(), sort_keys=True, separators=(",", ":"), allow_nan=False)


def _field(row: Input | Word) -> tuple[str, object]:
    if isinstance(row, Word):
        return row.name, str
    return row.name, (float | str) if row.words else float


def _fields(kind: MotionKind) -> Any:
    """Return a dataclass with a field for each row, so that a new parameter of a model is a word of its motions too."""
    return make_dataclass("_Fields", map(_field, kind.rows), frozen=True, kw_only=True)


@dataclass(frozen=True, kw_only=True)
class TrajectorySpec(_fields(DISK_MOTION), MotionRequest):  # type: ignore[misc]  # see `_fields`
    """The request for a motion of the disk without losses; `read` returns requests for all motions.

    `roll_rate` may be ``"steady"``, or `precession_rate` ``"steady-slow"`` or ``"steady-fast"``.
    """

    kind = DISK_MOTION


@dataclass(frozen=True, kw_only=True)
class LossyTrajectorySpec(_fields(LOSSY_MOTION), MotionRequest):  # type: ignore[misc]  # see `_fields`
    """The request for a motion of the disk with losses; see `MotionRequest`."""

    kind = LOSSY_MOTION


#: All words of the motions of disks and bodies.
_NAMES = tuple(
    dict.fromkeys((*DISK_MOTION.names, *LOSSY_MOTION.names, *BODY_MOTION.names, *LOSSY_BODY_MOTION.names))
)

#: Words that only a sweep has -> what to say about them.
_ELSEWHERE = {
    name: "it is a word of eulerdisk run" for name in (*names(DISK), *names(BODIES)) if name not in _NAMES
} | {
    "model": "name the file of a system first, as in eulerdisk simulate mine.py; other words choose disk or body"
}


def request_class(words: Mapping[str, Any]) -> type[MotionRequest]:
    """Return the type of request that words make: a model, a system, a body or a loss among them decides.

    Raises
    ------
    RequestError
        If the system cannot be read, or the model has no motions.
    """
    if "model" in words or "system" in words:
        return _class_of(motions_of(with_system(words)["model"]).model)
    return _class_of(registry.chosen(without_thin_body(words)) or DISK)


def motions_of(model: Model | str) -> MotionKind:
    """Return the kind of motions of a model, or of a model with a name.

    Raises
    ------
    RequestError
        If the model has no motions.
    """
    found = registry.named(model) if isinstance(model, str) else model
    if found.motion:
        return kind_of_model(found)
    known = [other.name for other in registry.every() if other.motion]
    raise RequestError(
        f"Only the models {', '.join(known)} and systems have single motions; got the model {found.name}.",
        hint="Name another preset, or an atlas of another model.",
    )


@lru_cache(maxsize=64)
def _class_of(model: Model) -> type[MotionRequest]:
    kind = kind_of_model(model)
    for request_type in (TrajectorySpec, LossyTrajectorySpec):
        if request_type.kind is kind:
            return request_type
    new_type: type[MotionRequest] = dataclass(frozen=True, kw_only=True)(
        type("MotionSpec", (_fields(kind), MotionRequest), {"kind": kind, "__module__": __name__})
    )
    return new_type


def split_motion_words(words: Sequence[str]) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words of a request for one motion.

    Raises
    ------
    RequestError
        If a word has no ``=``, is not known, or comes twice.
    """
    return split_words(words, _NAMES, DISK, _ELSEWHERE)


def known_names() -> tuple[str, ...]:
    """Return all words of a request for a motion of a disk or another body, with or without losses."""
    return _NAMES


def check_names(words: Iterable[str], kind: MotionKind) -> None:
    """Refuse a name that is not a word of a request for one motion; words of other bodies are allowed.

    Raises
    ------
    RequestError
    """
    system = bool(kind.model.text)
    known = kind.names if system else _NAMES
    for name in words:
        if name not in known:
            of_run = dict.fromkeys(names(kind.model), "it is a word of eulerdisk run")
            unknown_word(name, known, kind.model, of_run if system else _ELSEWHERE)


def _check_kind(words: Iterable[str], kind: MotionKind) -> None:
    """Refuse a word of another kind of motion: for a disk, only the tilt at which it has fallen has two names."""
    for name in words:
        if name in kind.names:
            continue
        if kind in (BODY_MOTION, LOSSY_BODY_MOTION):
            unknown_word(name, kind.names, kind.model, {})
        which = "with losses is flat at" if kind is LOSSY_MOTION else "without losses has fallen at"
        raise RequestError(
            f"{name} is not a word of this motion: the disk {which} {kind.largest_tilt}.",
            hint=f"Write {kind.largest_tilt} instead of {name}, or leave it out.",
            where=name,
        )


def _read_word(kind: MotionKind, name: str, raw: object) -> float | str:
    if name == "title":
        return read_title(raw)
    if name in kind.words:
        return one_of(kind.words[name], raw)
    value = read_input(kind.inputs[name], raw, read_number)
    assert isinstance(value, float | str)
    return value


def _check_start(spec: MotionRequest, words: Mapping[str, Any]) -> None:
    """Refuse a disk that has already fallen, and a start that its model refuses; messages quote `words`."""
    name = spec.kind.largest_tilt
    if name and not spec.kind.rolls_on(spec) and abs(spec.tilt) >= getattr(spec, name):
        raise RequestError(
            f"This {spec.kind.called} has already fallen at its start: |tilt| must be below {name}; got "
            f"{_given(spec, words, 'tilt', name)}.",
            hint=f"Start with a smaller tilt, or give a larger {name}.",
            where="tilt",
        )
    try:
        spec.kind.model.check(spec.words())
    except RequestError as error:
        with_words = at_word(error, words, spec.words())
        if error.where not in ("precession_rate", "roll_rate"):
            raise with_words from None
        # a hint of the model may be a range, but a motion needs one number
        number = "Give a precession_rate, as in precession_rate=0.5, or a number for roll_rate."
        hint = number if ":" in error.hint else error.hint
        raise RequestError(with_words.message, hint=hint, where=with_words.where) from None


def _check_counts(spec: MotionRequest, words: Mapping[str, Any]) -> None:
    for name, most in (("interval", _MOST_BYTES // spec.kind.sample_size), ("step", MOST_STEPS)):
        value = getattr(spec, name)
        if isinstance(value, float) and not spec.duration / value <= most:
            raise RequestError(
                f"These are too many {'samples' if name == 'interval' else 'steps'}: duration / {name} must be at most "
                f"{most}; got {_given(spec, words, 'duration', name)}.",
                hint=f"Give a longer {name}, a shorter duration, or {name}={AUTOMATIC}.",
                where=name,
            )


def _given(spec: MotionRequest, words: Mapping[str, Any], *names: str) -> str:
    """Return words of a request as the user wrote them."""
    return words_given([spec.kind.inputs[name] for name in names], words, spec.words())


def start_of(spec: MotionRequest) -> Array:
    """Return the start of a motion, shape (number of parameters,), in the order of the model's parameters.

    Raises
    ------
    RequestError
        If no rate keeps the tilt constant, but the request asks for one.
    """
    model = spec.kind.model
    # a NumPy scalar works like the arrays that `Model.complete` expects
    given: dict[str, Any] = {
        name: value if isinstance(value := getattr(spec, name), str) else np.float64(value)
        for name in model.parameters
    }
    values = model.complete(spec, given)
    for rate in ("precession_rate", "roll_rate"):
        if isinstance(given.get(rate), str) and not np.isfinite(values[rate]):
            other = "precession_rate" if rate == "roll_rate" else "roll_rate"
            raise RequestError(
                f"No {rate} keeps this tilt constant; got {rate}={given[rate]} with {other}="
                f"{given[other]:.6g} tilt={math.degrees(spec.tilt):.6g}deg.",
                hint=f"Give a larger {other}, a tilt other than 0, or a number for {rate}.",
                where=rate,
            )
    return np.array([values[name] for name in model.parameters], dtype=np.float64)
