"""The models that a request can name: the disk and other bodies, each without and with losses.

A user's system is a model too (`sweep.model.system.model`), but a request carries it as text. A spec or a file can only
name one of these models: nothing else is ever imported because of it.
"""

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from importlib import import_module
from types import MappingProxyType

from sweep.errors import RequestError, shown
from sweep.model.description import Model

#: The model of a request that names none and contains no word of another model.
DEFAULT = "disk"

#: Name of a model -> its module and its object there.
_OWN: Mapping[str, tuple[str, str]] = MappingProxyType({
    DEFAULT: ("sweep.model.disk.model", "DISK"),
    "lossy_disk": ("sweep.model.lossy_disk.model", "LOSSY_DISK"),
    "bodies": ("sweep.model.bodies.model", "BODIES"),
    "lossy_bodies": ("sweep.model.lossy_bodies.model", "LOSSY_BODIES"),
})  # fmt: skip

#: Two models, and the model of a request with words of both.
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
        If there is no such model.
    """
    if name not in _OWN:
        raise RequestError(
            f"There is no model {shown(name)!r}. The models are {', '.join(names())}, and your own systems.",
            hint="Name one of these, or a file with a system, such as mine.py.",
            where="model",
        )
    module, attribute = _OWN[name]
    model: Model = getattr(import_module(module), attribute)
    return model


def every() -> Iterator[Model]:
    """Yield the models, the default first."""
    return map(named, names())


def chosen(strange: Iterable[str], beside: str = DEFAULT) -> Model | None:
    """Return the model that unknown words of a request choose (`Model.chosen_by`); None if they choose none.

    Parameters
    ----------
    strange : iterable of str
        The words of a request that its model does not know.
    beside : str
        The name of its model.
    """
    words = {*strange}
    models = [model for model in every() if not words.isdisjoint(model.chosen_by)] if words else []
    two, both = _OF_BOTH
    if models and two <= {beside, *(model.name for model in models)}:
        return named(both)
    return models[0] if models else None
