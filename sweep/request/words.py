"""The words of a request: where they come from, what each may say, and which one was meant by an unknown one."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from sweep.errors import RequestError, shown
from sweep.model import registry
from sweep.model.description import Model
from sweep.model.quantity import Array, Input, Word, table
from sweep.request.as_given import as_given, numbers_in, rule_in
from sweep.request.criterion import Criterion
from sweep.request.distributions import Distribution, is_distribution, read_distribution
from sweep.request.regular_files import read_regular
from sweep.request.start_list import WORDS, read_list_word
from sweep.request.start_table import Column, StartTable
from sweep.request.suggestions import suggestion, unknown_word
from sweep.request.values import NOT_FINITE, Value, plain_number, read_number, read_value

#: The word for `step` that leaves the step to the engine, which chooses it from each cell's own rates.
AUTOMATIC = "auto"

#: The words for `boundary`: as the grid has it, or bisected; and the width if none is given.
GRID, REFINED, REFINED_WIDTH = "grid", "refined", 1e-9

#: Bytes of a spec file at most, a list of 50,000 values; and dots between two commas or ends of lines: of a key of
#: 20,000 parts the parser makes gigabytes.
_MOST_BYTES, _MOST_DOTS = 2**20, 50

#: Tables of a spec file that hold a sweep each, for `eulerdisk batch`; and how they are misspelt.
SWEEP_TABLES = ("sweep", "sweeps")


def options(model: Model) -> Mapping[str, Word]:
    """Return the settings of a request that are text, those of the model among them."""
    no_exact = "" if model.exact is not None else f"the model {model.name} has no exact reduction"
    return table(
        Word("title", "what the atlas is about, in one line", ""),
        Word("criterion", "what counts as unstable", "departure:5deg"),
        Word("method", "how the motion is integrated", model.methods[0], model.methods, remark=no_exact),
        *model.options.values(),
        Word("boundary", "how closely the boundary is sought", GRID, added_later=True),
        Word("device", "what the cells are computed on", model.devices[0], model.devices, added_later=True),
    )


def names(model: Model) -> tuple[str, ...]:
    """Return all words of a request for a model: parameters, settings, options."""
    return (*model.parameters, *model.settings, *options(model), *WORDS)


def known_words(model: Model) -> tuple[str, ...]:
    """Return all words that a request for a model may give: `names`, and what stands for a parameter."""
    return (*names(model), *model.substitutes)


def model_for(named: object, given: Iterable[str], otherwise: str = registry.DEFAULT) -> Model:
    """Return the model of a request.

    Parameters
    ----------
    named : object
        What the request says of its model; None if it says nothing.
    given : iterable of str
        The words that it has: one of them may choose the model.
    otherwise : str
        The model if none does.

    Raises
    ------
    RequestError
        If there is no model of that name.
    """
    if named is not None:
        return registry.named(str(named))
    model = registry.named(otherwise)
    known = known_words(model)
    return registry.chosen(name for name in given if name not in known) or model


def presets(model: Model) -> tuple[str, ...]:
    """Return the names of the presets of a model."""
    return tuple(sorted(path.stem for path in model.presets.glob("*.toml")))


def _every_preset() -> tuple[str, ...]:
    """Return the names of all presets, those of the default model first."""
    return tuple(name for model in registry.every() for name in presets(model))


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
    # the presets of the default model first: the other models need not be loaded then
    if spec in presets(registry.named(registry.DEFAULT)):
        return registry.named(registry.DEFAULT).presets / f"{spec}.toml"
    for model in registry.every():
        if spec in presets(model):
            return model.presets / f"{spec}.toml"
    known = _every_preset()
    example = f"rolling {spec}" if "=" in spec else "rolling"
    from_atlas = f"Where a command goes on from an atlas, it is given with --from {shown(spec)}." * (
        path.suffix == ".nc"
    )
    raise RequestError(
        f"There is no preset {spec or 'without a name'}. A spec is a preset or a .toml file; presets are "
        f"{', '.join(known)}.",
        hint=from_atlas
        or suggestion(spec, known)
        or f"Name a preset, as in {example}, or a file, as in my-sweep.toml.",
        where=shown(spec),
    )


def place(path: Path) -> str:
    """Return what messages call a spec file: a preset by its name, any other by its path."""
    return f"preset {path.stem}" if path.parent.name == "presets" else str(path)


def read_file(path: Path) -> dict[str, object]:
    """Return the words in a TOML file, in their order.

    Raises
    ------
    RequestError
        If the file cannot be read or is not TOML.
    """
    import tomllib

    try:
        text = read_regular(path, _MOST_BYTES).decode("utf-8-sig")
        if any(part.count(".") > _MOST_DOTS for line in text.splitlines() for part in line.split(",")):
            raise RecursionError
        return tomllib.loads(text)
    except OSError as problem:
        raise RequestError(
            f"The spec file cannot be read: {problem.strerror or type(problem).__name__}. A spec is a .toml file or a "
            f"preset: {', '.join(_every_preset())}.",
            hint="Check the path.",
            where=str(path),
        ) from problem
    # a TOML error with its line, text that is not UTF-8, or a number beyond any size
    except ValueError as problem:
        raise RequestError(
            f"The spec file is not TOML: {problem}. A spec file holds lines NAME = VALUE, text in quotes, as in "
            'tilt = "0.1deg:5deg:200:log".',
            hint="Correct that line.",
            where=str(path),
        ) from problem
    except RecursionError as problem:
        raise RequestError(
            "The spec file is no request: its arrays, tables or dotted names are nested too deep to be read. A spec "
            "file holds lines NAME = VALUE.",
            hint="Write lists as in alpha = [0.5, 1].",
            where=str(path),
        ) from problem


def split_words(
    words: Iterable[str], known: Sequence[str], model: Model, elsewhere: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words, in their order.

    Raises
    ------
    RequestError
        If a word has no ``=``, its name is not one of `known`, or a name comes twice.
    """
    found = pairs(words)
    for name in found:
        if name not in known:
            unknown_word(name, known, model, elsewhere)
    return found


def pairs(words: Iterable[str]) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words with any names.

    Raises
    ------
    RequestError
        If a word has no ``=``, or a name comes twice.
    """
    found: dict[str, str] = {}
    for word in words:
        name, equals, value = (part.strip() for part in word.partition("="))
        if not equals or not name:
            raise RequestError(
                "A word is written NAME=VALUE.",
                hint="Write it as in alpha=0.5,1.",
                where=shown(word) or "an empty word",
            )
        if name in found:
            raise RequestError(
                f"Each name is given once; got {name}={shown(found[name])} and {name}={shown(value)}.",
                hint="Leave one out.",
                where=name,
            )
        found[name] = value
    return found


def read_word(
    name: str, raw: object, model: Model
) -> Value | Distribution | Column | StartTable | Criterion | int | str:
    """Return the value of a word in SI.

    Parameters
    ----------
    name : str
        One of `names`.
    raw : object
        What was given for it: text, a number, a sequence, an axis or a criterion.
    model : Model

    Raises
    ------
    RequestError
        If the value cannot be read or the rule of the quantity does not allow it.
    """
    if name in WORDS:
        return read_list_word(name, raw, model)
    if isinstance(raw, Column):
        return raw
    if name in model.parameters and is_distribution(raw):
        return read_distribution(raw, model.parameters[name])
    if name in model.parameters:
        return read_input(model.parameters[name], raw, read_value)
    if name in model.settings:
        return read_input(model.settings[name], raw, read_number)
    if name == "criterion":
        # a criterion was perhaps read for another model, whose variables have the same names
        if isinstance(raw, Criterion) and raw.kind != "expression":
            return raw
        text = str(raw) if isinstance(raw, Criterion) else _text(name, raw)
        return Criterion.parse(text, model)
    if name == "title":
        return read_title(raw)
    if name == "boundary":
        return _boundary(_text(name, raw))
    return one_of(options(model)[name], raw)


def read_input(quantity: Input, raw: object, read: Callable[[object, Input], Value]) -> Value | str:
    """Return the number, or with `read_value` also the axis, that was given for a quantity, or one of its words.

    Raises
    ------
    RequestError
    """
    if isinstance(raw, str) and raw.strip() in quantity.words:
        return raw.strip()
    try:
        return allowed(read(raw, quantity), quantity, raw)
    except RequestError as error:
        word = isinstance(raw, str) and raw.strip().replace("-", "").isalpha()
        if quantity.words and word and not NOT_FINITE.fullmatch(str(raw).strip()):
            raise RequestError(
                f"{shown(raw)} is no value of {quantity.name}, which is a number, a range, or "
                f"{' or '.join(quantity.words)}{quantity.meaning and f' ({quantity.meaning})'}.",
                hint=_word_meant(str(raw).strip(), quantity),
                where=error.where,
            ) from None
        raise


def _word_meant(text: str, quantity: Input) -> str:
    """Return what to write instead of a text that is none of the words of a quantity."""
    # the nearest of several that begin alike would be a guess
    begun = [word for word in quantity.words if word.startswith(text)]
    if len(begun) > 1:
        return f"Write {' or '.join(f'{quantity.name}={word}' for word in begun)}."
    return suggestion(text, quantity.words) or f"Write {quantity.name}={quantity.words[0]}, or a value."


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
    outside = as_given(float(ends[~quantity.allows(ends)][0]), quantity, raw)
    rule = rule_in(quantity, outside.unit)
    raise RequestError(
        f"{outside.text} is not possible: {rule}.",
        hint=degrees_meant(quantity, quantity.name, raw, ends) or f"Choose values with {rule}.",
        where=f"{quantity.name}={shown(raw)}",
    )


def degrees_meant(quantity: Input, word: str, raw: object, ends: Array) -> str:
    """Return the hint that a bare number is in radians, where it would be possible in degrees; otherwise nothing.

    `word` and `raw` are what was given: a word that stands for an angle has other numbers than the angle.
    """
    if word != quantity.name or not quantity.allows(np.radians(ends)).all():
        return ""
    if quantity.units != "rad" or any(unit for _, unit in numbers_in(raw)):
        return ""
    example = "1deg:5deg:200"
    if isinstance(raw, str | int | float) and str(raw).count(":") < 2:
        example = f"{quantity.name}={re.sub('[^,:]+', lambda each: f'{each[0].strip()}deg', str(raw))}"
    return f"A bare number is in radians; for degrees write them, as in {example}."


def _text(name: str, raw: object) -> str:
    if isinstance(raw, str):
        return raw.strip()
    raise RequestError(f"{name} is text.", hint="Put it in quotes.", where=f"{name}={shown(raw)}")


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
        "A title is one line of printable text.",
        hint="Leave out what does not print.",
        where=f"title={shown(repr(text))}",
    )


def one_of(word: Word, raw: object) -> str:
    """Return the choice that was given for a word; False and True stand for ``no`` and ``yes``.

    Raises
    ------
    RequestError
        If it is none of its choices.
    """
    if isinstance(raw, bool) and word.choices == ("no", "yes"):
        return word.choices[raw]
    text = _text(word.name, raw)
    if text in word.choices:
        return text
    raise RequestError(
        f"{word.name} is {' or '.join(word.choices)}{word.remark and f' ({word.remark})'}; got {shown(text)}.",
        hint="Write " + " or ".join(f"{word.name}={choice}" for choice in word.choices) + ".",
        where=word.name,
    )


def _boundary(text: str) -> str:
    word, _, width = text.partition(":")
    if text == GRID:
        return text
    value = plain_number(width) if width else REFINED_WIDTH
    if word.strip() == REFINED and 0.0 < value < float("inf"):
        return f"{REFINED}:{value!r}"
    raise RequestError(
        f"boundary is {GRID}, {REFINED} or {REFINED}:WIDTH with a width above 0 in the SI unit of the axis.",
        hint=f"Write boundary={REFINED}:1e-6.",
        where=f"boundary={shown(text)}",
    )
