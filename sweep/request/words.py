"""The words of a request: their values, the model that they choose, and how changes replace each other."""

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

#: The value of `step` with which the engine chooses the step from each cell's rates.
AUTOMATIC = "auto"

#: The values of `boundary`: at the resolution of the grid, or bisected; and the default width of the bisection.
GRID, REFINED, REFINED_WIDTH = "grid", "refined", 1e-9

#: Largest number of cells of a grid: the search for the boundary keeps all verdicts, a byte each, in memory.
_MOST_CELLS = 10**9
#: Largest number of steps of a cell: more take many seconds for each cell, and the kernels give up such a cell.
MOST_STEPS = 10**8


def options(model: Model) -> Mapping[str, Word]:
    """Return the text options of a request, including the model's options."""
    no_cuda = "" if "cuda" in model.devices else "compiling cells with losses for a GPU takes minutes"
    no_exact = "" if model.exact is not None else f"the model {model.name} has no exact reduction"
    return table(
        Word("title", "title of the atlas, in one line", ""),
        Word("criterion", "what counts as unstable", model.default_criterion),
        Word("method", "how the motion is integrated", model.methods[0], model.methods, remark=no_exact),
        *model.options.values(),
        Word("boundary", "accuracy of the boundary", GRID),
        Word("device", "device that computes the cells", model.devices[0], model.devices, remark=no_cuda),
    )


def names(model: Model) -> tuple[str, ...]:
    """Return all words of a request for a model: parameters, settings, options."""
    return (*model.parameters, *model.settings, *options(model), *WORDS)


def known_words(model: Model) -> tuple[str, ...]:
    """Return all words that a request for a model may give: `names` and the substitutes of parameters."""
    return tuple(dict.fromkeys((*names(model), *model.substitutes)))


def model_for(named: object, given: Iterable[str], otherwise: Model | None = None) -> Model:
    """Return the model of a request.

    Parameters
    ----------
    named : object
        The model that the request names: its name, or the model itself; None if it names none.
    given : iterable of str
        The words of the request: one of them may choose the model.
    otherwise : Model, optional
        The model if no word chooses one; by default the default model.

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
        If a word has no ``=``, its name is not in `known`, or a name is given twice.
    """
    found = pairs(words)
    for name in found:
        if name not in known:
            unknown_word(name, known, model, elsewhere)
    return found


def pairs(words: Iterable[str]) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words, with any names.

    Raises
    ------
    RequestError
        If a word has no ``=``, or a name is given twice.
    """
    found: dict[str, str] = {}
    is_list = isinstance(words, Iterable) and not isinstance(words, str)
    listed = [*words] if is_list else []
    if not is_list or not all(isinstance(word, str) for word in listed):
        raise RequestError(
            f"Words must be a list of texts NAME=VALUE; got {shown(words)}.",
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
                f"{name} is given twice; got {name}={shown(found[name])} and {name}={shown(value)}.",
                hint="Leave one of them out.",
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
        The value as given: text, a number, a sequence, an axis or a criterion.
    model : Model

    Raises
    ------
    RequestError
        If the value cannot be read, or the rule of the quantity does not allow it.
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
        # an expression may have been read for another model with the same names: read it again
        if isinstance(raw, Criterion) and raw.kind != "expression":
            return raw
        text = str(raw) if isinstance(raw, Criterion) else _read_text(name, raw)
        return Criterion.parse(text, model)
    if name == "title":
        return read_title(raw)
    if name == "boundary":
        return _read_boundary(_read_text(name, raw))
    return one_of(options(model)[name], raw)


def read_input(quantity: Input, raw: object, read: Callable[[object, Input], Value]) -> Value | str:
    """Return the value given for a quantity: one of its words, a number, or with `read_value` an axis.

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
                f"{shown(raw)} is not a value of {quantity.name}, which is a number, a range, or "
                f"{' or '.join(quantity.words)}{quantity.meaning and f' ({quantity.meaning})'}.",
                hint=_word_meant(str(raw).strip(), quantity),
                where=error.where,
            ) from None
        raise


def _word_meant(text: str, quantity: Input) -> str:
    """Return the hint for a text that is not one of a quantity's words."""
    # if several words begin with the text, the nearest one would be a guess
    begun = [word for word in quantity.words if word.startswith(text)]
    if len(begun) > 1:
        return f"Write {' or '.join(f'{quantity.name}={word}' for word in begun)}."
    return suggestion(text, quantity.words) or f"Write {quantity.name}={quantity.words[0]}, or a value."


def _read_text(name: str, raw: object) -> str:
    if isinstance(raw, str):
        return raw.strip()
    raise RequestError(f"{name} must be text.", hint="Put it in quotes.", where=f"{name}={shown(raw)}")


def read_title(raw: object) -> str:
    """Return a title, one line of printable text.

    Raises
    ------
    RequestError
        If it is not one line of printable text.
    """
    text = _read_text("title", raw)
    if text.isprintable():
        return text
    raise RequestError(
        "A title is one line of printable text.",
        hint="Remove unprintable characters.",
        where=f"title={shown(repr(text))}",
    )


def one_of(word: Word, raw: object) -> str:
    """Return the choice that was given for a word; False and True mean ``no`` and ``yes``.

    Raises
    ------
    RequestError
        If it is not one of the word's choices.
    """
    if isinstance(raw, bool) and word.choices == ("no", "yes"):
        return word.choices[raw]
    text = _read_text(word.name, raw)
    if text in word.choices:
        return text
    raise RequestError(
        f"{word.name} is {' or '.join(word.choices)}{word.remark and f' ({word.remark})'}; got {shown(text)}.",
        hint="Write " + " or ".join(f"{word.name}={choice}" for choice in word.choices) + ".",
        where=word.name,
    )


def _read_boundary(text: str) -> str:
    word, _, width = text.partition(":")
    if text == GRID:
        return text
    value = plain_number(width) if width else REFINED_WIDTH
    if word.strip() == REFINED and 0.0 < value < float("inf"):
        return f"{REFINED}:{value!r}"
    raise RequestError(
        f"boundary must be {GRID}, {REFINED} or {REFINED}:WIDTH, with a width above 0 in the SI unit of the axis.",
        hint=f"Write boundary={REFINED}:1e-6.",
        where=f"boundary={shown(text)}",
    )


def read_axes(order: object, given: tuple[str, ...]) -> tuple[str, ...]:
    """Return the axes in the requested order; `given` is their order among the words."""
    names = order.split(",") if isinstance(order, str) else order
    if isinstance(names, Sequence) and sorted(map(str, names)) == sorted(given):
        return tuple(map(str, names))
    raise RequestError(
        f"axes must contain each name that has a list or a range exactly once; got {shown(order)} with "
        f"{', '.join(given) or 'no axis'}.",
        hint="Leave axes out: by default the axes have the order given.",
        where="axes",
    )


def check_method(values: Mapping[str, Any], model: Model) -> None:
    """Refuse a method that cannot compute these cells."""
    methods = model.methods_for(values)
    if values["method"] not in methods:
        body = f" of a {values['body']}" if "body" in values else ""
        raise RequestError(
            f"The cells{body} need method={' or '.join(methods)}; got method={values['method']}.",
            hint="Leave method out.",
            where="method",
        )


def check_steps(values: Mapping[str, Any], words: Mapping[str, Any]) -> None:
    """Refuse a step that gives a cell too many steps; `words` has the values as given."""
    step, duration = values["step"], values["duration"]
    if isinstance(step, str) or duration / step <= MOST_STEPS:
        return
    raise RequestError(
        f"Too many steps: duration / step must be at most {MOST_STEPS}; got "
        f"{words_given((DURATION, STEP), words, values)}.",
        hint="Give a longer step, a shorter duration, or step=auto.",
        where="step",
    )


def check_size(counts: Sequence[int]) -> None:
    """Refuse a grid with too many cells for the search for its boundary."""
    if math.prod(counts) > _MOST_CELLS:
        raise RequestError(
            f"A grid has at most {_MOST_CELLS} cells; got {' x '.join(map(str, counts))} = {math.prod(counts)}.",
            hint="Lower the counts of the axes.",
            where="grid",
        )


def given_in(words: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the words of a request and the columns of its table, which must have been read; they choose its model."""
    table = words.get("starts")
    return (*words, *(table.names if isinstance(table, StartTable | GivenTable) else ()))


def changes_in(words: Sequence[str], otherwise: Model | None = None) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words that change a spec of a model, or choose another model.

    Raises
    ------
    RequestError
    """
    found = pairs(words)
    check_known(found, model_for(None, given_in(with_table(found)), otherwise))
    return found


def check_known(words: Iterable[str], model: Model, others: Sequence[str] = ()) -> None:
    """Refuse a name that is neither a word of a request for a model nor one of `others`.

    Raises
    ------
    RequestError
    """
    known = known_words(model)
    for name in words:
        if name not in known and name not in others:
            unknown_word(name, known, model, _words_elsewhere())


def with_table(words: Mapping[str, Any], folder: Path | None = None) -> dict[str, Any]:
    """Return words after reading the table of starts, if one is given; its path is relative to a folder."""
    raw = words.get("starts")
    if isinstance(raw, str) and raw.strip() and folder is not None:
        raw = folder / raw
    table = read_table(raw)
    others = {name: value for name, value in words.items() if name != "starts" or value is not None}
    return others if table is None else {**others, "starts": table}


def _words_elsewhere() -> Mapping[str, str]:
    """Return words that belong elsewhere, with an explanation where, for suggestions."""
    words = {
        name: f"it is a word of the model {model.name}, and chooses this model if the request names none"
        for model in registry.every()
        for name in model.chosen_by
    }
    with_loss = "and of a disk with losses, together with a loss such as rolling_friction=10um"
    words |= dict.fromkeys(("mass", "friction"), f"it is a word of eulerdisk simulate, {with_loss}")
    words |= {"interval": "it is a word of eulerdisk simulate"}
    return words | {"model": f'a spec file names the model, as in model = "{registry.DEFAULT}"'}
