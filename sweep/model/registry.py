"""The models of a request: the disk without and with losses, and those that installed distributions register.

A distribution registers a model as an entry point of the group ``eulerdisk.models``; the name of the entry point is the
name of the model. A spec or a file can only name a registered model: nothing in it is ever imported.
"""

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType

from sweep.errors import RequestError, shown
from sweep.model.description import Model

#: The model of a request that names none, and has no word that chooses another one.
DEFAULT = "disk"

#: Model that comes with this distribution -> the module and the object.
_OWN: Mapping[str, tuple[str, str]] = MappingProxyType({
    DEFAULT: ("sweep.model.disk.model", "DISK"),
    "lossy_disk": ("sweep.model.lossy_disk.model", "LOSSY_DISK"),
})  # fmt: skip

#: Group of the entry points.
GROUP = "eulerdisk.models"


def names() -> tuple[str, ...]:
    """Return the names of all models, the default first."""
    return (*_OWN, *sorted(each.name for each in _registered()))


@lru_cache
def named(name: str) -> Model:
    """Return the model that is registered under a name.

    Raises
    ------
    RequestError
        If there is none, or what is registered cannot be imported, for any reason, or is no model of that name.
    """
    if name in _OWN:
        module, found = _OWN[name]
        own: Model = getattr(import_module(module), found)
        return own
    for each in _registered():
        if each.name == name:
            return _load(each)
    raise RequestError(
        f"There is no model {shown(name)!r}. The models are {', '.join(names())}.",
        hint="Install the distribution that brings it, or name one of these.",
        where="model",
    )


def every() -> Iterator[Model]:
    """Yield the models that can be loaded, the default first; `named` says why another one cannot be."""
    for name in names():
        try:
            model = named(name)
        except RequestError:
            # a request that does not name a broken model must not fail because of it
            continue
        yield model


def chosen(strange: Iterable[str]) -> Model | None:
    """Return the model that one of some words chooses (`sweep.model.description.Model.chosen_by`); None if none does.

    Parameters
    ----------
    strange : iterable of str
        The words of a request that its model does not know.
    """
    words = {*strange}
    found = (model for model in every() if not words.isdisjoint(model.chosen_by))
    return next(found, None) if words else None


def _load(registered: EntryPoint) -> Model:
    try:
        found = registered.load()
    except Exception as error:
        # the module of another distribution may raise anything when it is imported; the repr has no line break
        raise _refused(registered, f"it cannot be imported: {error!r}") from error
    if isinstance(found, Model) and found.name == registered.name:
        return found
    raise _refused(registered, "it is no sweep.model.description.Model of that name")


def _refused(registered: EntryPoint, problem: str) -> RequestError:
    return RequestError(
        f"{registered.value} is registered as the model {registered.name}, but {problem}.",
        hint="Ask the author of the distribution that registers it.",
        where=f"model={registered.name}",
    )


@lru_cache
def _registered() -> tuple[EntryPoint, ...]:
    return tuple(each for each in entry_points(group=GROUP) if each.name not in _OWN)
