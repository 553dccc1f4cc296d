"""The words of a request: where they come from, and what each may say."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from sweep.errors import RequestError, shown
from sweep.request.criterion import Criterion
from sweep.request.quantities import Value, read_number, read_value
from sweep.request.unknown import perhaps, unknown_word
from sweep.schema import (
    AUTOMATIC,
    DEVICES,
    GRID,
    METHODS,
    PARAMETERS,
    REFINED,
    REFINED_WIDTH,
    SETTINGS,
    STEADY_PRECESSION,
    STEADY_ROLL,
    Array,
    Input,
)

#: Words that stand in the place of a number.
_INSTEAD = (
    ("roll_rate", STEADY_ROLL),
    ("step", AUTOMATIC),
    *(("precession_rate", word) for word in STEADY_PRECESSION),
)

_PRESETS = Path(__file__).parents[1] / "presets"


def presets() -> tuple[str, ...]:
    """Return the names of the presets."""
    return tuple(sorted(path.stem for path in _PRESETS.glob("*.toml")))


def find_spec_file(spec: str | Path) -> Path:
    """Return the path of a preset or of a file; text without a folder or ``.toml`` is the name of a preset.

    Raises
    ------
    RequestError
        If it is the name of neither.
    """
    path = Path(spec)
    if isinstance(spec, Path) or path.suffix == ".toml" or path.name != spec:
        return path
    if spec not in presets():
        raise RequestError(
            f"there is no preset {spec!r}",
            "a spec is a preset or a .toml file; presets are " + ", ".join(presets()),
            spec or "nothing",
            perhaps(spec, presets()) or _spec_first(str(spec)),
        )
    return _PRESETS / f"{spec}.toml"


def _spec_first(given: str) -> str:
    if "=" in given:
        return f"name a preset or a file before the changes, as in rolling {given}"
    return "name a preset, or a file as in my-sweep.toml"


def place(path: Path) -> str:
    """Return what messages call a spec file: a preset by its name, any other by its path."""
    return f"preset {path.stem}" if path.parent == _PRESETS else str(path)


def read_file(path: Path) -> dict[str, object]:
    """Return the words in a TOML file, in their order.

    Raises
    ------
    RequestError
        If the file cannot be read or is not TOML.
    """
    import tomllib

    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as problem:
        raise RequestError(
            "the spec file cannot be read",
            f"a spec is a file that can be read, or a preset: {', '.join(presets())}",
            problem.strerror or type(problem).__name__,
            "check the path",
            str(path),
        ) from problem
    except (
        ValueError
    ) as problem:  # a TOML error with its line, text that is not UTF-8, or a number beyond any size
        raise RequestError(
            "the spec file is not TOML",
            'a spec file holds lines NAME = VALUE, text in quotes, as in tilt = "0.1deg:5deg:200:log"',
            str(problem),
            "correct that line",
            str(path),
        ) from problem


def split_words(words: Iterable[str], names: Sequence[str]) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words, in their order.

    Raises
    ------
    RequestError
        If a word has no ``=``, its name is not one of `names`, or a name comes twice.
    """
    found: dict[str, str] = {}
    for word in words:
        name, equals, value = (part.strip() for part in word.partition("="))
        if not equals or not name:
            raise RequestError(
                "not a NAME=VALUE word",
                "changes to a spec are NAME=VALUE",
                word or "nothing",
                "write it as in alpha=0.5,1",
            )
        if name not in names:
            unknown_word(name, names)
        if name in found:
            given = f"{name}={found[name]} and {name}={value}"
            raise RequestError("given twice", "each name is given once", given, "leave one out", name)
        found[name] = value
    return found


def read_word(name: str, raw: object) -> Value | Criterion | str:
    """Return the value of a word in SI.

    Parameters
    ----------
    name : str
        A name of `PARAMETERS`, `SETTINGS` or `WORDS`.
    raw : object
        What was given for it: text, a number, a sequence, an axis or a criterion.

    Raises
    ------
    RequestError
        If the value cannot be read or the rule of the quantity does not allow it.
    """
    instead = [word for known, word in _INSTEAD if known == name]
    if isinstance(raw, str) and raw.strip() in instead:
        return raw.strip()
    if name in PARAMETERS:
        return allowed(_number_or(instead, read_value, raw, PARAMETERS[name]), PARAMETERS[name], raw)
    if name in SETTINGS:
        return allowed(_number_or(instead, read_number, raw, SETTINGS[name]), SETTINGS[name], raw)
    if isinstance(raw, Criterion) and name == "criterion":
        return raw
    if isinstance(raw, bool) and name == "contact":
        raw = _SWITCH[raw]
    return _TEXTS[name](_text(name, raw))


def _number_or(
    instead: Sequence[str], read: Callable[[object, Input], Value], raw: object, quantity: Input
) -> Value:
    """Read a value of which a word may stand in the place."""
    try:
        return read(raw, quantity)
    except RequestError as error:
        # a word, but not one of these
        if instead and isinstance(raw, str) and raw.strip().replace("-", "").isalpha():
            error.rule += f"; or {' or '.join(instead)}"
            error.do = perhaps(raw, instead) or f"write a value, or {quantity.name}={instead[0]}"
        raise


def allowed(value: Value, quantity: Input, raw: object) -> Value:
    """Return a value that the rule of its quantity allows.

    Raises
    ------
    RequestError
        If the rule does not allow it; `raw` is what was given.
    """
    ends = np.array([value]) if isinstance(value, float) else value.ends()
    if quantity.allows(ends).all():
        return value
    outside = ends[~quantity.allows(ends)][0]
    raise RequestError(
        f"{quantity.spell(outside)} is not possible",
        quantity.rule,
        f"{quantity.name}={shown(raw)}",
        _degrees_meant(quantity, raw, ends) or f"choose values with {quantity.rule}",
        quantity.name,
    )


def _degrees_meant(quantity: Input, raw: object, ends: Array) -> str:
    if not quantity.allows(np.radians(ends)).all():
        return ""
    if quantity.units != "rad" or (isinstance(raw, str) and any(map(str.isalpha, raw.replace("log", "")))):
        return ""
    example = (
        f"{quantity.name}={raw}deg"
        if isinstance(raw, str | int | float) and ":" not in str(raw)
        else "1deg:5deg:200"
    )
    return f"a bare number is in radians; for degrees write them, as in {example}"


def _text(name: str, raw: object) -> str:
    if isinstance(raw, str):
        return raw.strip()
    raise RequestError("not text", f"{name} is text", f"{name}={shown(raw)}", "put it in quotes", name)


def read_title(raw: object) -> str:
    """Return a title, one line of printable text.

    Raises
    ------
    RequestError
        If it is something else.
    """
    text = _text("title", raw)
    if text.isprintable():
        return text
    raise RequestError(
        "not a title",
        "a title is one line of printable text",
        shown(repr(text)),
        "leave out what does not print",
        "title",
    )


def one_of(name: str, raw: object, choices: Sequence[str]) -> str:
    """Return the word that was given for `name`, which is one of `choices`.

    Raises
    ------
    RequestError
        If it is none of them.
    """
    text = _text(name, raw)
    if text in choices:
        return text
    raise RequestError(
        f"unknown {name}",
        f"{name} is {' or '.join(choices)}",
        f"{name}={text}",
        "write " + " or ".join(f"{name}={choice}" for choice in choices),
        name,
    )


def _method(text: str) -> str:
    return one_of("method", text, METHODS)


def _device(text: str) -> str:
    return one_of("device", text, DEVICES)


def _contact(text: str) -> str:
    return one_of("contact", text, _SWITCH)


def _boundary(text: str) -> str:
    word, _, width = text.partition(":")
    if text == GRID:
        return text
    try:
        value = float(width or REFINED_WIDTH)
    except ValueError:
        value = 0.0
    if word.strip() == REFINED and 0.0 < value < float("inf"):
        return f"{REFINED}:{value!r}"
    raise RequestError(
        "not a way to look for the boundary",
        f"boundary is {GRID}, {REFINED} or {REFINED}:WIDTH with a width above 0 in the SI unit of the axis",
        f"boundary={shown(text)}",
        f"write boundary={REFINED}:1e-6",
        "boundary",
    )


#: False and True, as TOML and Python may write them.
_SWITCH = ("no", "yes")

_TEXTS: Mapping[str, Callable[[str], Criterion | str]] = {
    "boundary": _boundary,
    "contact": _contact,
    "criterion": Criterion.parse,
    "device": _device,
    "method": _method,
    "title": read_title,
}
