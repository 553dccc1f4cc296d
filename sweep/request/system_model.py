"""The system that a request gives, as its model."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sweep.errors import RequestError, shown
from sweep.model import registry
from sweep.model.description import Model
from sweep.request.spec_file import system_preset_file, system_presets
from sweep.request.suggestions import suggestion

if TYPE_CHECKING:
    from sweep.model.system.definition import Definition

#: Between a file of systems and the name of one of them.
_OF = ".py:"


def with_system(words: Mapping[str, Any], folder: Path | None = None) -> dict[str, Any]:
    """Return the words of a request in which a system that they give has become its model.

    Parameters
    ----------
    words : mapping of str to anything
        ``system`` is the text of a system, as an atlas carries it. ``model`` may be a file of systems, ``mine.py``, or
        one of several in it, ``mine.py:name``, or what the mark ``@system`` makes.
    folder : Path, optional
        That of the file in which a person wrote the words: paths begin there, and both words may be a file of systems
        or a preset of one. Without it ``system`` opens no file: what an atlas carries comes from anybody.

    Raises
    ------
    RequestError
    """
    found = dict(words)
    text, named = found.pop("system", None), found.get("model")
    definition = _named_definition(named, folder) if text is None else _definition(str(text), folder)
    if definition is None:
        return found
    if text is not None and named not in (None, definition.name):
        raise RequestError(
            f"The model is {shown(named)}, and the system of the request is {definition.name}.",
            hint=f"Leave out one of both, or write model={definition.name}.",
            where="system",
        )
    return {**found, "model": _model(definition)}


def _named_definition(named: object, folder: Path | None) -> "Definition | None":
    """Return the system that a request names as its model; None if it names another model, or none."""
    if hasattr(named, "definition") and not isinstance(named, Model):
        found: Definition = named.definition
        return found
    if names_file(named):
        return _read_file(str(named), folder)
    is_preset = folder is not None and isinstance(named, str) and named in system_presets()
    return _read_file(str(system_preset_file(str(named)))) if is_preset else None


def _definition(text: str, folder: Path | None) -> "Definition":
    """Return the system of a request: from its text, or in a spec file from the file or the preset that it names."""
    name = text.strip()
    # a text of a system has its mark on a line of its own
    if "\n" in name:
        from sweep.request.system_file import read_system

        return read_system(text, where="the system of the request")
    known = system_presets()
    if folder is not None and names_file(name):
        return _read_file(name, folder)
    if folder is not None and name in known:
        return _read_file(str(system_preset_file(name)))
    if folder is None:
        raise RequestError(
            f"system is the text of a system; only a spec file names a file or a preset with it; got {shown(name)}.",
            hint="Give the file or the preset itself as the spec.",
            where="system",
        )
    raise RequestError(
        f"system is a file, a preset of a system, or the text of one; presets are {', '.join(known)}; got "
        f"{shown(name) or 'nothing'}.",
        hint=suggestion(name, known) or 'Write system = "mine.py", for instance.',
        where="system",
    )


def _read_file(words: str, folder: Path | None = None) -> "Definition":
    """Return the system in ``mine.py``, or the one of several that ``mine.py:name`` names."""
    # most requests are of no system, and need not wait for its reader
    from sweep.request.system_file import read_system_file

    path, of, name = words.partition(_OF)
    where = Path(path + ".py" if of else path)
    return read_system_file(folder / where if folder else where, name)


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
