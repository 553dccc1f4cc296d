"""The word ``body``: the body of a request; without it the body is the thin disk."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from sweep.errors import RequestError, are, shown
from sweep.model import registry
from sweep.model.description import Model
from sweep.request.words import given_in, names

#: The value of ``body`` that means the thin disk, not another body of revolution.
THIN = "disk"

#: Models of other bodies -> the matching models of the thin disk.
_THIN_MODELS = {"bodies": registry.DEFAULT, "lossy_bodies": "lossy_disk"}


def thin_model(model: Model) -> Model:
    """Return the thin-disk model that matches a model."""
    return registry.named(_THIN_MODELS.get(model.name, registry.DEFAULT))


def without_thin_body(words: Mapping[str, Any]) -> dict[str, Any]:
    """Return words without ``body=disk``, which is the same as naming no body."""
    return {name: raw for name, raw in words.items() if name != "body" or str(raw).strip() != THIN}


def check_body_named(model: Model, words: Mapping[str, Any]) -> None:
    """Refuse losses of a body without losses, and a length, moment or filling without a named body.

    Parameters
    ----------
    model : Model
        The model that the words choose.
    words : mapping of str to anything
        The words of a request, as given.

    Raises
    ------
    RequestError
    """
    if "body" not in model.options:
        return
    if "body" in words:
        _check_losses_known(model, str(words["body"]).strip())
        return
    from sweep.model.bodies.tables import CHOOSING

    given = [name for name in given_in(words) if name in CHOOSING]
    if not given:
        return
    got = " ".join(f"{name}={shown(words[name])}" for name in given if name in words)
    said = " and ".join(given)
    raise RequestError(
        f"{said} {are(len(given), 'applies', 'apply')} only to bodies other than the thin disk, and the request names "
        f"no body; got {got or f'a column {said}'}.",
        hint=_body_to_add(given, model.options["body"].choices),
        where=given[0],
    )


def _body_to_add(given: Sequence[str], known: Sequence[str]) -> str:
    """Return the hint for lengths, moments and filling that are given without a body."""
    whole, first = _bodies_with(given, known), _bodies_with(given[:1], known)
    if whole:
        return f"Add {' or '.join(whole)}, or leave {' and '.join(given)} out."
    if first:
        return f"No body takes all of these words: add {' or '.join(first)}, and leave out all except {given[0]}."
    return f"No body with losses takes it: leave {given[0]} out."


def _check_losses_known(model: Model, body: str) -> None:
    """Refuse a body that only the model without losses knows."""
    from sweep.model.bodies.tables import CALLED

    having = model.options["body"].choices
    if body in having or body not in CALLED:
        return
    named = [f"body={each}" for each in having]
    raise RequestError(
        f"A {CALLED[body]} rolls without losses: only the thin disk, {', '.join(named[:-1])} and {named[-1]} have "
        f"losses; got body={body} with losses.",
        hint=f"Leave the losses out, or write {' or '.join(named)}.",
        where="body",
    )


def _bodies_with(given: Collection[str], known: Sequence[str]) -> list[str]:
    """Return the words for the known bodies that take all given words; only the complete ones if there are any."""
    from sweep.model.bodies.tables import LENGTHS, OPTIONAL

    every = {name for own in LENGTHS.values() for name in own}
    having = {
        body: own
        for body, own in LENGTHS.items()
        if body in known
        and every.intersection(given) <= {*own}
        and ("filling" not in given or body == "torus")
    }
    # an arc needs both moments, because its shape does not give them; so does a body with its load on one side
    moments = {"axial_moment", "transverse_moment"}
    whole = [
        body
        for body, own in having.items()
        if {*own} - {*OPTIONAL} <= {*given}
        and ((body != "arc" and "offset" not in given) or moments <= {*given})
    ]
    return [f"body={body}" for body in whole or having]


def of_one_body(held: Mapping[str, Any], changes: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return words and changes without ``body=disk``; if that is a change, drop the words of other bodies too."""
    thin, kept = without_thin_body(changes), without_thin_body(held)
    if len(thin) == len(changes):
        return kept, thin
    gone = {*names(registry.named("bodies"))} - {*names(registry.named(registry.DEFAULT))}
    gone |= {"model"} if held.get("model") in _THIN_MODELS else set()
    return {name: raw for name, raw in kept.items() if name not in gone}, thin
