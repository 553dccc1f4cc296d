"""Words that change a spec, a preset or a spec file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sweep.model import registry
from sweep.model.description import Model
from sweep.request.start_list import WORDS
from sweep.request.start_table import StartTable, names_in, read_table
from sweep.request.substitutes import changed, parameter_of
from sweep.request.suggestions import unknown_word
from sweep.request.words import known_words, pairs


def given_in(words: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the words that a request has, and the columns of the table that it names: they choose its model."""
    table = words.get("starts")
    # arrays and data frames have no truth value
    none = table is None or (isinstance(table, str) and not table.strip())
    return (*words, *(() if none else names_in(table)))


def split_changes(words: Sequence[str], model: Model) -> dict[str, str]:
    """Return the names and values of ``NAME=VALUE`` words that change a spec.

    Raises
    ------
    RequestError
    """
    return dict(_known(pairs(words), model))


def known_changes(changes: Mapping[str, Any], model: Model) -> Mapping[str, Any]:
    """Return changes of a spec file, of which every name has to be one that the command line knows too."""
    return _known(changes, model, ("axes",))


def _known(words: Mapping[str, Any], model: Model, others: Sequence[str] = ()) -> Mapping[str, Any]:
    known = known_words(model)
    for name in words:
        if name not in known and name not in others:
            unknown_word(name, known, model, elsewhere())
    return words


def changed_words(
    held: Mapping[str, Any], path: Path, changes: Mapping[str, Any], model: Model
) -> dict[str, Any]:
    """Return the words of a spec file with changes.

    Parameters
    ----------
    held : mapping of str to anything
        The words in the file.
    path : Path
        The file: the path of a table that it names begins at its folder.
    changes : mapping of str to anything
        Words that replace them. Columns of a table among them take the place of words of the file too.
    model : Model

    Raises
    ------
    RequestError
        If a table cannot be read, or the changes give a parameter in two ways.
    """
    changes = with_table(changes, model)
    if "starts" not in changes:
        held = with_table(beside(path, held), model)
    return changed(without_columns(held, changes, model), changes, model)


def beside(path: Path, words: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return words of a spec file; the path of the table that they name begins at the folder of the file."""
    named = words.get("starts")
    return {**words, "starts": path.parent / named} if isinstance(named, str) and named.strip() else words


def with_table(words: Mapping[str, Any], model: Model) -> dict[str, Any]:
    """Return words of which the table of starts, if one is given, has been read."""
    raw = words.get("starts", "")
    # arrays and data frames have no truth value
    none = isinstance(raw, str) and not raw.strip()
    return {**words} if none else {**words, "starts": read_table(raw, model)}


def without_columns(words: Mapping[str, Any], changes: Mapping[str, Any], model: Model) -> dict[str, Any]:
    """Return words of a preset, a file or a spec without those for which a table among changes of them has columns."""
    table = changes.get("starts")
    gone = (*table.names, *WORDS) if isinstance(table, StartTable) else ()
    return {name: value for name, value in words.items() if parameter_of(name, model) not in gone}


def elsewhere() -> Mapping[str, str]:
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
