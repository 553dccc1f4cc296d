"""The system that a request gives, as its model."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweep.errors import RequestError, shown
from sweep.model import registry
from sweep.model.description import Model

if TYPE_CHECKING:
    from sweep.model.system.definition import Definition

#: Between a file of systems and the name of one of them.
_OF = ".py:"


def with_system(words: Mapping[str, Any], folder: Path | None = None) -> dict[str, Any]:
    """Return the words of a request in which a system that they give has become its model.

    Parameters
    ----------
    words : mapping of str to anything
        ``system`` is the text of a system, as an atlas carries it; ``model`` may be a file of systems, ``mine.py``, or
        one of several in it, ``mine.py:name``, or what the mark ``@system`` makes.
    folder : Path, optional
        Where the path of a file begins.

    Raises
    ------
    RequestError
    """
    found = dict(words)
    text, named = found.pop("system", None), found.get("model")
    file = names_file(named)
    marked = hasattr(named, "definition") and not isinstance(named, Model)
    if text is None and not file and not marked:
        return found
    # most requests are of no system, and need not wait for its reader
    from sweep.request.system_file import read_system, read_system_file

    if text is not None:
        definition = read_system(str(text), where="the system of the request")
        if named not in (None, definition.name):
            raise RequestError(
                f"The model is {shown(named)}, and the system of the request is {definition.name}.",
                hint=f"Leave out one of both, or write model={definition.name}.",
                where="system",
            )
        found["model"] = _model(definition)
    elif file:
        path, of, name = str(named).partition(_OF)
        where = Path(path + ".py" if of else path)
        found["model"] = _model(read_system_file(folder / where if folder else where, name))
    else:
        found["model"] = _model(named.definition)  # type: ignore[union-attr]
    return found


def names_file(model: object) -> bool:
    """Return whether what a request says of its model is a file of systems, or one of several in it."""
    return isinstance(model, str) and (model.endswith(".py") or _OF in model)


def _model(definition: "Definition") -> Model:
    """Return the model of a system; refuse one that is called like another model."""
    from sweep.model.system.model import model_of

    if definition.name in registry.names():
        raise RequestError(
            f"A system cannot be called {definition.name}: a model has that name.",
            hint="Give its function another name.",
            where=definition.name,
        )
    return model_of(definition)
