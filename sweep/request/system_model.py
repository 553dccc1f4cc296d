"""Models of the systems in requests."""

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

#: The end of a file's name and the separator before the name of a system in it.
_OF = ".py:"


def with_system(words: Mapping[str, Any], folder: Path | None = None) -> dict[str, Any]:
    """Return the words of a request with a given system converted to its model.

    Parameters
    ----------
    words : mapping of str to anything
        ``system`` is the text of a system, as stored in an atlas. ``model`` may be a file of systems, ``mine.py``, one
        system of several in it, ``mine.py:name``, or a function marked ``@system``.
    folder : Path, optional
        The folder of the spec file: paths are relative to it, and both words may be a file of systems or a preset.
        Without it ``system`` opens no file, because an atlas may come from an untrusted source.

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
            f"The model is {shown(named)}, but the system of the request is {definition.name}.",
            hint=f"Leave out one of them, or write model={definition.name}.",
            where="system",
        )
    return {**found, "model": _model(definition)}


def _named_definition(named: object, folder: Path | None) -> "Definition | None":
    """Return the system that a request names as its model; None if it names another model or no model."""
    if hasattr(named, "definition") and not isinstance(named, Model):
        found: Definition = named.definition
        return found
    if names_file(named):
        return _read_file(str(named), folder)
    is_preset = folder is not None and isinstance(named, str) and named in system_presets()
    return _read_file(str(system_preset_file(str(named)))) if is_preset else None


def _definition(text: str, folder: Path | None) -> "Definition":
    """Return the system of a request: from its text, or in a spec file also from a file or a preset."""
    name = text.strip()
    # the text of a system has at least two lines, because the decorator has its own
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
            f"system must be the text of a system; in a spec file it may also be a file or a preset; got "
            f"{shown(name)}.",
            hint="Give the file or the preset as the spec.",
            where="system",
        )
    raise RequestError(
        f"system must be a file, a preset of a system, or the text of a system; presets are {', '.join(known)}; got "
        f"{shown(name) or 'nothing'}.",
        hint=suggestion(name, known) or 'Write system = "mine.py", for instance.',
        where="system",
    )


def _read_file(words: str, folder: Path | None = None) -> "Definition":
    """Return the system in ``mine.py``, or for ``mine.py:name`` the system with this name."""
    # imported here, because most requests have no system and need not load its reader
    from sweep.request.system_file import read_system_file

    path, of, name = words.partition(_OF)
    where = Path(path + ".py" if of else path)
    return read_system_file(folder / where if folder else where, name)


def names_file(model: object) -> bool:
    """Return whether a request's model is a file of systems, or a system in one."""
    return isinstance(model, str) and (model.endswith(".py") or _OF in model)


def _model(definition: "Definition") -> Model:
    """Return the model of a system; refuse a system with the name of another model."""
    from sweep.model.system.model import model_of

    if definition.name in registry.names():
        raise RequestError(
            f"A system cannot be called {definition.name}: a model already has this name.",
            hint="Give its function another name.",
            where=definition.name,
        )
    return model_of(definition)
