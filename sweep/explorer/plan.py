"""The plan, as JSON, by which the page computes cells and motions of a view."""

import math
from collections.abc import Mapping
from typing import Any

from sweep.errors import RequestError
from sweep.explorer.body import body_cells, body_motion, is_body
from sweep.explorer.losses import AIR, LOSS_WORDS, MASS, has_losses, slider_rows
from sweep.explorer.quantities import described, shown_of
from sweep.explorer.system import is_system, system_cells
from sweep.explorer.view import View
from sweep.model.description import Model
from sweep.model.disk.initial_conditions import circling
from sweep.model.disk.path import PATH_VARIABLES
from sweep.model.disk.tables import STEADY_PRECESSION, STEADY_ROLL, WOBBLE
from sweep.model.lossy_disk.tables import AIR_LAWS, LOSSES, NO_AIR
from sweep.model.quantity import (
    AMPLIFIED,
    EXTREME,
    FAILED,
    LOST,
    PROMISED,
    SENSITIVE,
    TIMED,
    UNDECIDED,
    Input,
    Quantity,
)
from sweep.model.system.model import SystemModel
from sweep.motion.lossy_tables import LAWS, LOSSY_BODY_MOTION, LOSSY_MOTION
from sweep.motion.tables import BODY_MOTION, DISK_MOTION, TRAJECTORY, MotionKind
from sweep.request.criterion import ROUNDING
from sweep.request.criterion_kinds import LOST_TIME, REACH
from sweep.request.expression import Comparison, Expression, Not, Number, Term, variables
from sweep.request.spec import SweepSpec

#: Words for rates -> their numbers in `kernels.page.starts`; 0 for a rate given as a number.
_RATES = {**dict(zip(STEADY_PRECESSION, (1, 2), strict=True)), STEADY_ROLL: 3, WOBBLE: 4}

#: Columns that describe how a cell was computed, or that the exact reduction does not provide.
LEFT_OUT = ("steps", "refinements", "energy_drift", "fall_time", "stability")

_WEIGHT_TIMES_RADIUS = "weight \u00d7 radius"

#: Arrays of a motion whose unit differs from that of the variable in a file -> label and unit.
_SCALED: Mapping[str, tuple[str, str]] = {
    "time": ("time", "s"),
    "friction_needed": ("friction needed", ""),
    "normal_force": ("normal force", "weight"),
    "friction_across": ("friction across the track", "weight"),
    "friction_along": ("friction along the track", "weight"),
    "energy": ("energy", _WEIGHT_TIMES_RADIUS),
    "potential": ("potential \u2212 energy", _WEIGHT_TIMES_RADIUS),
    **{name: (words, _WEIGHT_TIMES_RADIUS) for name, words in LAWS.items()},
}

#: Arrays of a motion that are variables of its file, in the same unit.
_SAMPLES = (
    "tilt", "tilt_rate", "precession_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y",
    "centre_x", "centre_y", "centre_z",
)  # fmt: skip


def plan(view: View) -> dict[str, Any]:
    """Return the plan by which the page computes the cells and motions of a view.

    Parameters
    ----------
    view : View

    Returns
    -------
    dict
        ``cells``, how the cells of the map are computed, None if they cannot be, and ``refused``, the reason;
        ``lossy``, how a cell with losses is computed; ``disk``, how the starts of motions are completed; ``motion``,
        how motions are followed, None if there are none. The type Plans in the page's types.js describes their
        contents.

    Raises
    ------
    RequestError
        If the words of the view are invalid.
    """
    spec, cells, refused = view.spec, None, None
    try:
        cells = cells_of(view.live)
    except RequestError as error:
        refused = {"error": error.message, "hint": error.hint}
    lossy = spec.model is LOSSY_MOTION.model
    rolls = not is_system(spec)
    return {
        "cells": cells,
        "refused": refused,
        "lossy": cells_of(_extend_to_end(spec)) if lossy else None,
        "disk": (cells or _plan_without_verdict(spec)) if rolls else None,
        "motion": _motion_of(spec) if rolls else None,
    }


def _extend_to_end(spec: SweepSpec) -> SweepSpec:
    """Return a spec whose cells are followed as long as the motion that is drawn."""
    usual = float(spec.model.settings["duration"].default)
    return spec.replace(duration=max(spec.duration, usual))


def _plan_without_verdict(spec: SweepSpec) -> dict[str, Any]:
    """Return how the starts of a spec are completed and reduced without a verdict."""
    model = (BODY_MOTION if is_body(spec) else DISK_MOTION).model
    fall_tilt = getattr(spec, "fall_tilt", model.settings["fall_tilt"].default)
    never = {"terms": [{"value": 0.0}, {"value": 1.0}], "signs": [">"]}
    outcomes = [[UNDECIDED] * 3] * (max(each.code for each in model.endings) + 1)
    return {
        **_cells(spec, model),
        **_body_of(spec),
        "settings": {"fall_tilt": fall_tilt, "tolerance": spec.tolerance},
        "criterion": {"text": "", "timed": False, "outcomes": outcomes, "condition": never, "named": []},
    }


def cells_of(spec: SweepSpec) -> dict[str, Any]:
    """Return how the cells of a spec are computed: by the exact reduction, with losses, or as a system."""
    system = {"system": system_cells(spec.model)} if isinstance(spec.model, SystemModel) else {}
    return {**_cells(spec, spec.model), "criterion": _criterion(spec), **system, **_body_of(spec)}


def _body_of(spec: SweepSpec) -> dict[str, Any]:
    return {"body": body_cells(spec)} if is_body(spec) else {}


def _cells(spec: SweepSpec, model: Model) -> dict[str, Any]:
    """Return how cells of a model with the starts of a spec are computed, except for their verdicts."""
    endings, shown = model.endings, shown_of(spec)
    computed = {name: _RATES[str(getattr(spec, name))] for name in spec.computed}
    settings = [name for name in ("fall_tilt", "tolerance") if name in model.settings]
    lossy = model is LOSSY_MOTION.model
    variables = model.cell_variables(spec) if model is spec.model else model.variables
    return {
        "model": model.name,
        "parameters": list(model.parameters),
        "held": {name: _fixed_value(spec, name) for name in model.parameters},
        "rates": [computed.get("precession_rate", 0), computed.get("roll_rate", 0)],
        "from_start": bool(spec.computed) and circling(spec),
        "settings": {name: getattr(spec, name, None) for name in settings},
        "kernel_settings": model.kernel_settings(spec).tolist() if model.exact is None else [],
        "measures": list(model.measures),
        "counts": list(model.counts),
        "losses": [measure for _, measure in LOSSES.values()] if lossy else [],
        "contact": getattr(spec, "contact", "no") == "yes",
        "path": [name for name in PATH_VARIABLES if name in variables],
        "unresolved": endings.code("unresolved"),
        "lost": endings.codes(LOST),
        "failed": endings.codes(FAILED),
        "shown": list(shown),
        "timed": [name for name, each in shown.items() if each.timed],
        "singles": [name for name, each in variables.items() if each.dtype == "f4"],
        "starts": [described(row) for row in model.parameters.values()],
        "numbers": [described(quantity) for name, quantity in variables.items() if name not in LEFT_OUT],
    }


def _fixed_value(spec: SweepSpec, name: str) -> float | None:
    """Return the value of a parameter that is no axis; None if it is not a number, or infinite."""
    value = spec.constants.get(name, getattr(spec, name))
    return value if isinstance(value, float) and math.isfinite(value) else None


def _criterion(spec: SweepSpec) -> dict[str, Any]:
    """Return the verdicts of cells by their endings, and the condition that decides the others."""
    criterion, endings = spec.criterion, spec.model.endings
    outcomes = [[UNDECIDED] * 3 for _ in range(max(each.code for each in endings) + 1)]
    for each in endings:
        outcomes[each.code] = list(criterion.row.outcomes.get(each.role, (UNDECIDED,) * 3))
    criterion.check_new_cells()
    assert criterion.condition is not None
    names = {LOST_TIME: endings.lost_time}
    enough = {"ending", *spec.model.from_extremes}.issuperset(criterion.needs(spec.model))
    return {
        "text": str(criterion),
        "timed": not enough,
        "outcomes": outcomes,
        "condition": _condition(criterion.condition, names),
        "named": [names.get(name, name) for name in variables(criterion.condition)],
        "errors": {
            names.get(name, name): rule
            for name in variables(criterion.condition)
            if (rule := _error_rule(spec, names.get(name, name))) is not None
        },
    }


def _error_rule(spec: SweepSpec, name: str) -> dict[str, Any] | None:
    """Return how the errors of a criterion's variable are bounded (ErrorRule in types.js); None if it has no bound."""
    model, quantities = spec.model, spec.model.cell_variables(spec)
    extremes = {"stated": model.error_name, "times": PROMISED, "rounding": ROUNDING}
    if name == REACH:
        return {"by": EXTREME, **extremes}
    if name not in quantities or name in model.parameters:
        return None
    rule = quantities[name].tolerance
    if quantities[name].flags is not None:
        return {"unknown": [each.code for each in model.endings if each.role == SENSITIVE]}
    room = {"absolute": rule.absolute, "relative": rule.relative}
    if rule.stated in (EXTREME, AMPLIFIED, TIMED):
        return {"by": rule.stated, **extremes, **room}
    return {"stated": rule.stated, "times": PROMISED, **room} if rule.stated in quantities else room


def _condition(tree: Expression, names: Mapping[str, str]) -> dict[str, Any]:
    if isinstance(tree, Not):
        return {"not": _condition(tree.part, names)}
    if isinstance(tree, Comparison):
        return {"terms": [_term(each, names) for each in tree.terms], "signs": list(tree.signs)}
    return {"word": tree.word, "parts": [_condition(each, names) for each in tree.parts]}


def _term(term: Term, names: Mapping[str, str]) -> dict[str, Any]:
    if isinstance(term, Number):
        return {"value": float(term.value)}
    return {"name": names.get(term.name, term.name), "factor": term.factor, "absolute": term.absolute}


def _motion_of(spec: SweepSpec) -> dict[str, Any]:
    """Return how motions are followed: the settings of the cells, in SI."""
    lossy = has_losses(spec)
    tilts = {
        kind.largest_tilt: getattr(spec, kind.largest_tilt, kind.inputs[kind.largest_tilt].default)
        for kind in (DISK_MOTION, LOSSY_MOTION)
    }
    losses = {name: getattr(spec, name) for name in LOSS_WORDS} if lossy else {}
    return {
        "lossy": lossy,
        **tilts,
        "losses": {name: _plain(value) for name, value in losses.items()},
        "body": body_motion(spec) if is_body(spec) else None,
    }


def _plain(value: Any) -> float | str | None:
    """Return a number or a word; None where cells differ."""
    return value if isinstance(value, float) else str(value) if isinstance(value, str) else None


def motion_tables() -> dict[str, Any]:
    """Return what all motions share: labels, words, sliders of losses (MotionTables in types.js)."""
    samples = {name: TRAJECTORY[name] for name in _SAMPLES}
    return {
        "quantities": {
            **{
                name: {"label": label, "unit": unit, "factor": 1.0} for name, (label, unit) in _SCALED.items()
            },
            **{name: _describe(each) for name, each in samples.items()},
        },
        "disk": _endings(DISK_MOTION),
        "lossy": _endings(LOSSY_MOTION),
        "body": _endings(BODY_MOTION),
        "ledger": dict(LAWS),
        "lossy_body": _endings(LOSSY_BODY_MOTION),
        "lossy_parameters": list(LOSSY_MOTION.model.parameters),
        "lossy_body_parameters": list(LOSSY_BODY_MOTION.model.parameters),
        "rules": {
            name: _rule(row)
            for name, row in {**BODY_MOTION.model.parameters, **DISK_MOTION.model.parameters}.items()
        },
        "sliders": slider_rows(),
        "air_laws": list(AIR_LAWS),
        "no_air": NO_AIR,
        "air": AIR,
        "mass": MASS,
    }


def _describe(quantity: Quantity) -> dict[str, Any]:
    unit = quantity.shown_units.replace(" s-1", "/s")
    return {"label": quantity.name.replace("_", " "), "unit": unit, "factor": quantity.plot_scale}


def _endings(kind: MotionKind) -> dict[str, str]:
    """Return the description of each ending of a motion by its code, except for motions that reached the time limit."""
    flags = kind.variables["ending"].flags or {}
    named = {str(code): kind.variables["ending"].flag(code) for code in flags}
    return {code: kind.endings[name] for code, name in named.items() if name in kind.endings}


def _rule(row: Input) -> dict[str, Any]:
    return {**described(row), "rule": row.rule}
