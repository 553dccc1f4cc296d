"""The word ``body``: the thin disk needs none, and a request is of one body alone."""

from collections.abc import Mapping
from typing import Any

from sweep.model import registry
from sweep.model.description import Model
from sweep.request.words import names

#: The body that is no body of revolution, but the disk.
THIN = "disk"

#: Models of other bodies -> those of the thin disk.
_THIN_MODELS = {"bodies": registry.DEFAULT, "lossy_bodies": "lossy_disk"}


def thin_model(model: Model) -> Model:
    """Return the model of the thin disk that stands beside a model."""
    return registry.named(_THIN_MODELS.get(model.name, registry.DEFAULT))


def without_thin_body(words: Mapping[str, Any]) -> dict[str, Any]:
    """Return words without ``body=disk``, which asks for the model of a request that names none."""
    return {name: raw for name, raw in words.items() if name != "body" or str(raw).strip() != THIN}


def of_one_body(held: Mapping[str, Any], changes: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return words and changes without ``body=disk``: where that is a change, without the words of another body too."""
    thin, kept = without_thin_body(changes), without_thin_body(held)
    if len(thin) == len(changes):
        return kept, thin
    gone = {*names(registry.named("bodies"))} - {*names(registry.named(registry.DEFAULT))}
    gone |= {"model"} if held.get("model") in _THIN_MODELS else set()
    return {name: raw for name, raw in kept.items() if name not in gone}, thin
