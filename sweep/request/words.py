"""The words of a request: what each may say, which model they choose, and how some of them change others."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sweep.errors import RequestError, shown
from sweep.model import registry
from sweep.model.description import Model
from sweep.model.quantity import DURATION, STEP, Input, Word, table
from sweep.request.criterion import Criterion
from sweep.request.sources import Distribution
from sweep.request.start_list import WORDS, read_list_word
from sweep.request.start_table import Column, GivenTable, StartTable, read_table
from sweep.request.suggestions import suggestion, unknown_word
from sweep.request.units import plain_number
from sweep.request.values import (
    NOT_FINITE,
    Value,
    allowed,
    read_distribution,
    read_number,
    read_value,
    words_given,
)

#: The word for `step` that leaves the step to the engine, which chooses it from each cell's own rates.
AUTOMATIC = "auto"

#: The words for `boundary`: as the grid has it, or bisected; and the width if none is given.
GRID, REFINED, REFINED_WIDTH = "grid", "refined", 1e-9

#: Cells of a grid at most: their verdicts, a byte each, are in memory while the boundary is sought.
_MOST_CELLS = 10**9
#: Most steps of a cell: more take many seconds for each cell, and the kernels give such a cell up.
MOST_STEPS = 10**8


def options(model: Model) -> Mapping[str, Word]:
    """Return the settings of a request that are text, those of the model among them."""
    no_exact = "" if model.exact is not None else f"the model {model.name} has no exact reduction"
    return table(
        Word("title", "what the atlas is about, in one line", ""),
        Word("criterion", "what counts as unstable", model.default_criterion),
        Word("method", "how the motion is integrated", model.methods[0], model.methods, remark=no_exact),
        *model.options.values(),
        Word("boundary", "how closely the boundary is sought", GRID),
        Word("device", "what the cells are computed on", model.devices[0], model.devices),
    )


def names(model: Model) -> tuple[str, ...]:
    """Return all words of a request for a model: parameters, settings, options."""
    return (*model.parameters, *model.settings, *options(model), *WORDS)


def known_words(model: Model) -> tuple[str, ...]:
    """Return all words that a request for a model may give: `names`, and what stands for a parameter."""
    return tuple(dict.fromkeys((*names(model), *model.substitutes)))


def model_for(named: object, given: Iterable[str], otherwise: Model | None = None) -> Model:
    """Return the model of a request.

    Parameters
    ----------
    named : object
        What the request says of its model: a name, or the model; None if it says nothing.
    given : iterable of str
        The words that it has: one of them may choose the model.
    otherwise : Model, optional
        The model if none does; the default one if not given.

    Raises
    ------
    RequestError
        If there is no model of that name.
    """
    if isinstance(named, Model):
        return named
    if named is not None:
        return registry.named(str(named))
    model = otherwise or registry.named(registry.DEFAULT)
    known = known_words(model)
    return registry.chosen((name for name in given if name not in known), model.name) or model


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
    is_list = isinstance(words, Iterable) and not isinstance(words, str)
    listed = [*words] if is_list else []
    if not is_list or not all(isinstance(word, str) for word in listed):
        raise RequestError(
            f"Words are a list of texts NAME=VALUE; got {shown(words)}.",
            hint='Write ["alpha=0.5,1"], for instance.',
        )
    for word in listed:
        name, equals, value = (part.strip() for part in word.partition("="))
        if not equals or not name:
            raise RequestError(
                "A word is written NAME=VALUE.",
                hint=f"Write {name if name.isidentifier() else 'alpha'}=0.5, for instance.",
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
    if name in model.parameters:
        found = read_distribution(raw, model.parameters[name])
        if found is not None:
            return allowed(found, model.parameters[name], raw)
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


def read_axes(order: object, given: tuple[str, ...]) -> tuple[str, ...]:
    """Return the axes in the order that a request asks for; `given` is the order of its words."""
    names = order.split(",") if isinstance(order, str) else order
    if isinstance(names, Sequence) and sorted(map(str, names)) == sorted(given):
        return tuple(map(str, names))
    raise RequestError(
        f"axes holds the names given as a list or a range, each once; got {shown(order)} with "
        f"{', '.join(given) or 'no axis'}.",
        hint="Leave it out: the order given is the order of the axes.",
        where="axes",
    )


def check_method(values: Mapping[str, Any], model: Model) -> None:
    """Refuse a method that does not compute these cells."""
    methods = model.methods_for(values)
    if values["method"] not in methods:
        body = f" of a {values['body']}" if "body" in values else ""
        raise RequestError(
            f"The cells{body} are computed by method={' or '.join(methods)}; got method={values['method']}.",
            hint="Leave method out.",
            where="method",
        )


def check_steps(values: Mapping[str, Any], words: Mapping[str, Any]) -> None:
    """Refuse a step so short that a cell would never end; `words` has what was given for the values."""
    step, duration = values["step"], values["duration"]
    if isinstance(step, str) or duration / step <= MOST_STEPS:
        return
    raise RequestError(
        f"These are too many steps: duration / step must be at most {MOST_STEPS}; got "
        f"{words_given((DURATION, STEP), words, values)}.",
        hint="Give a longer step, a shorter duration, or step=auto.",
        where="step",
    )


def check_size(counts: Sequence[int]) -> None:
    """Refuse a grid of more cells than the search for its boundary takes."""
    if math.prod(counts) > _MOST_CELLS:
        raise RequestError(
            f"A grid has at most {_MOST_CELLS} cells; got {' x '.join(map(str, counts))} = {math.prod(counts)}.",
            hint="Lower the counts of the axes.",
            where="grid",
        )


def given_in(words: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the words that a request has, and the columns of its table, which has been read: they choose its model."""
    table = words.get("starts")
    return (*words, *(table.names if isinstance(table, StartTable | GivenTable) else ()))


def changes_in(words: Sequence[str], otherwise: Model | None = None) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words that change a spec of a model, or choose another one.

    Raises
    ------
    RequestError
    """
    found = pairs(words)
    check_known(found, model_for(None, given_in(with_table(found)), otherwise))
    return found


def check_known(words: Iterable[str], model: Model, others: Sequence[str] = ()) -> None:
    """Refuse a name that is no word of a request for a model, nor one of `others`.

    Raises
    ------
    RequestError
    """
    known = known_words(model)
    for name in words:
        if name not in known and name not in others:
            unknown_word(name, known, model, _elsewhere())


def with_table(words: Mapping[str, Any], folder: Path | None = None) -> dict[str, Any]:
    """Return words of which the table of starts, if one is given, has been read; its path begins at a folder."""
    raw = words.get("starts")
    if isinstance(raw, str) and raw.strip() and folder is not None:
        raw = folder / raw
    table = read_table(raw)
    others = {name: value for name, value in words.items() if name != "starts" or value is not None}
    return others if table is None else {**others, "starts": table}


def _elsewhere() -> Mapping[str, str]:
    """Words that stand elsewhere, and where, for suggestions."""
    words = {
        name: f"it is a word of the model {model.name}, which it chooses where the request names no model"
        for model in registry.every()
        for name in model.chosen_by
    }
    beside = "and of a disk with losses, beside a loss such as rolling_friction=10um"
    words |= dict.fromkeys(("mass", "friction"), f"it is a word of eulerdisk simulate, {beside}")
    words |= {"interval": "it is a word of eulerdisk simulate"}
    return words | {"model": f'a spec file names the model, as in model = "{registry.DEFAULT}"'}
