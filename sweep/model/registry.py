"""The models of a request that have a name of their own: the disk and other bodies, each without and with losses.

A system of a user is a model too (`sweep.model.system.model`): a request carries it as text. A spec or a file can only
name one of these: nothing in it is ever imported.
"""

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from importlib import import_module
from types import MappingProxyType

from sweep.errors import RequestError, shown
from sweep.model.description import Model

#: The model of a request that names none, and has no word that chooses another one.
DEFAULT = "disk"

#: Model that comes with this distribution -> the module and the object.
_OWN: Mapping[str, tuple[str, str]] = MappingProxyType({
    DEFAULT: ("sweep.model.disk.model", "DISK"),
    "lossy_disk": ("sweep.model.lossy_disk.model", "LOSSY_DISK"),
    "bodies": ("sweep.model.bodies.model", "BODIES"),
    "lossy_bodies": ("sweep.model.lossy_bodies.model", "LOSSY_BODIES"),
})  # fmt: skip

#: Two models, and that of a request which has words of both.
_OF_BOTH = {"lossy_disk", "bodies"}, "lossy_bodies"


def names() -> tuple[str, ...]:
    """Return the names of all models, the default first."""
    return tuple(_OWN)


@lru_cache
def named(name: str) -> Model:
    """Return the model with a name.

    Raises
    ------
    RequestError
        If there is none.
    """
    if name not in _OWN:
        raise RequestError(
            f"There is no model {shown(name)!r}. The models are {', '.join(names())}, and systems of your own.",
            hint="Name one of these, or a file with a system, such as mine.py.",
            where="model",
        )
    module, found = _OWN[name]
    own: Model = getattr(import_module(module), found)
    return own


def every() -> Iterator[Model]:
    """Yield the models, the default first."""
    return map(named, names())


def chosen(strange: Iterable[str], beside: str = DEFAULT) -> Model | None:
    """Return the model that some words choose (`sweep.model.description.Model.chosen_by`); None if none does.

    Parameters
    ----------
    strange : iterable of str
        The words of a request that its model does not know.
    beside : str
        The name of its model.
    """
    words = {*strange}
    found = [model for model in every() if not words.isdisjoint(model.chosen_by)] if words else []
    two, both = _OF_BOTH
    if found and two <= {beside, *(model.name for model in found)}:
        return named(both)
    return found[0] if found else None
