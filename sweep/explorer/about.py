"""The data that the page needs first: parameters, quantities, criteria and its initial view."""

import contextlib
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from sweep.errors import RequestError
from sweep.explorer.body import COST, SLIDERS, is_body, is_of_body
from sweep.explorer.losses import LOSS_WORDS, has_losses
from sweep.explorer.own_module import has_own_module
from sweep.explorer.plan import motion_tables
from sweep.explorer.quantities import Shown, described, shown_of
from sweep.explorer.stored import Stored
from sweep.explorer.system import is_system
from sweep.explorer.view import base_names, exact, middle, other_names, preset
from sweep.model.bodies.tables import NONE as NO_LENGTH
from sweep.model.quantity import Array, Input
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec

#: Parameter or setting -> the ends of its slider in SI, and its scale.
_SLIDERS: Mapping[str, tuple[float, float, str]] = {
    "tilt": (math.radians(-60.0), math.radians(60.0), "linear"),
    "tilt_rate": (-2.0, 2.0, "linear"),
    "precession_rate": (-10.0, 10.0, "linear"),
    "roll_rate": (-10.0, 10.0, "linear"),
    "alpha": (0.05, 1.0, "linear"),
    "radius": (0.005, 1.0, "log"),
    "gravity": (0.1, 30.0, "log"),
    "fall_tilt": (math.radians(10.0), math.radians(89.0), "linear"),
    **SLIDERS,
}

#: A parameter that allows this value counts as unlimited: in SI, far outside every slider.
_FAR = 1e6

#: Number of halvings that lead from there to neighbouring doubles, or close enough to an end at zero.
_HALVINGS = 200

#: Assumed milliseconds per cell of a system until a cell has been computed. Some need 0.1, some 30; for the latter, the
#: first picture has few cells, so that it appears within 2 s.
_SYSTEM_COST = 5.0

#: Criterion -> what it limits, its unit, and the ends of its slider in that unit.
_CRITERIA: Mapping[str, tuple[str, str, float, float]] = {
    "departure": ("how far the tilt leaves its steady value", "deg", 0.1, 80.0),
    "amplification": ("that distance divided by the size of the perturbation", "", 1.1, 1000.0),
}


def about(given: SweepSpec | None, stored: Stored | None = None) -> dict[str, Any]:
    """Return the data that the page asks for first; values are in SI, and ``factor`` converts to the displayed unit.

    Parameters
    ----------
    given : SweepSpec or None
        The explorer's own subject, the first base, with the empty name.
    stored : Stored, optional
        The atlas whose spec `given` is.

    Returns
    -------
    dict
        ``bases``, the first of which is shown; ``others``, the presets that have no map; ``parameters``,
        ``quantities``, ``criteria``, ``losses``, ``atlas``. The page's types.js describes their contents.
    """
    bases, of_system = {} if given is None else {"": given}, is_system(given)
    # a page has one module of kernels, either of the disk, or of a body, or of a system
    if not has_own_module(given):
        bases |= {name: preset(name) for name in base_names()}
    by_base = {name: _quantities(spec, stored if name == "" else None) for name, spec in bases.items()}
    shown = {name: each for held in by_base.values() for name, each in held.items()}
    peaks = {spec.model.peak for spec in bases.values()}
    rows = {
        name: row
        for spec in bases.values()
        for name, row in {**spec.model.parameters, **spec.model.settings}.items()
        if (name in spec.model.parameters or (name in _SLIDERS and not of_system))
        and (not is_body(spec) or is_of_body(spec, name))
    }
    return {
        "bases": [{**base_of(name, spec), "quantities": list(by_base[name])} for name, spec in bases.items()],
        "others": list(other_names()),
        "parameters": [
            _input(row, _slider_of(row) if of_system else _SLIDERS.get(row.name)) for row in rows.values()
        ],
        "quantities": [
            {**described(each.quantity), "is_peak": name in peaks} for name, each in shown.items()
        ],
        "criteria": [
            {"word": word, "description": description, "unit": unit, "low": low, "high": high}
            for word, (description, unit, low, high) in _CRITERIA.items()
            if not of_system
        ],
        "losses": list(LOSS_WORDS),
        "motions": motion_tables(),
        "atlas": None if stored is None else _atlas(stored),
    }


def _live(spec: SweepSpec) -> SweepSpec:
    """Return a spec whose cells can be computed, or the spec itself if there is none."""
    with contextlib.suppress(RequestError):
        return exact(spec) if spec.model.exact is not None else spec
    return spec


def _is_live(live: SweepSpec) -> bool:
    """Return whether the cells of a spec from `_live` are computed on demand."""
    return live.method == "exact" or is_system(live)


def _quantities(spec: SweepSpec, stored: Stored | None) -> dict[str, Shown]:
    """Return the quantities of a base that the map can show, from computed and from stored cells."""
    live = _live(spec)
    computed = shown_of(live) if stored is None or _is_live(live) else {}
    return computed | (stored.quantities() if stored is not None else {})


def _atlas(stored: Stored) -> dict[str, Any]:
    spec, live = stored.spec, _live(stored.spec)
    view = sides(spec)
    shape = [len(getattr(spec, side["name"])) for side in view.values()]
    is_live = _is_live(live)
    beyond = "computed beyond the grid and between its cells" if is_live else "no cells beyond the grid"
    return {
        "label": stored.label,
        "base": "",
        "live": is_live,
        "note": f"{shape[0]} x {shape[1]} cells are stored, method={spec.method}; {beyond}.",
        **view,
    }


def base_of(name: str, spec: SweepSpec) -> dict[str, Any]:
    """Return a base: its name, its words, and the view that shows all of it."""
    view = sides(spec)
    axes = [side["name"] for side in view.values()]
    shown = [each for each in spec.model.parameters if not is_body(spec) or is_of_body(spec, each)]
    held = {each: getattr(spec, each) for each in shown if each not in axes}
    words = {
        each: middle(value) if isinstance(value, Range | Values) else value for each, value in held.items()
    }
    words["criterion"] = str(spec.criterion)
    goes = getattr(spec, "path", "no") == "yes"
    return {
        "name": name,
        "label": name or str(spec.title) or "as given",
        "description": spec.headline,
        "words": words,
        "view": {"base": name, "words": {}, **view},
        "rolls": not is_system(spec),
        "cost": _SYSTEM_COST
        if is_system(spec)
        else COST
        if (is_body(spec) and not has_losses(spec)) or goes
        else 0.0,
    }


def sides(spec: SweepSpec) -> dict[str, dict[str, Any]]:
    """Return the window that shows the first two axes of a spec completely, oriented as in a figure.

    If the spec has fewer axes, parameters of the model replace them.
    """
    model = spec.model
    names = list(dict.fromkeys((*spec.axes, *model.controls(model.parameters), *model.parameters)))[:2]
    y = model.upward(names)
    x = next(name for name in names if name != y)
    return {"x": _side(spec, x), "y": _side(spec, y)}


def _side(spec: SweepSpec, name: str) -> dict[str, Any]:
    held = getattr(spec, name)
    if not isinstance(held, Range | Values) or len(held) < 2:
        low, high, scale = _slider_of(spec.model.parameters[name]) if is_system(spec) else _SLIDERS[name]
    else:
        low, high = map(float, held.ends())
        scale = "log" if is_logarithmic(held.array()) else "linear"
    if scale == "log":
        low, high = math.log(low), math.log(high)
    return {"name": name, "centre": 0.5 * (low + high), "half": 0.5 * (high - low), "scale": scale}


def is_logarithmic(values: Array) -> bool:
    """Return whether the values of an axis are evenly spaced in their logarithm."""
    if values[0] <= 0.0 or values.size < 3:
        return False
    return bool(abs(values[1] / values[0] - values[-1] / values[-2]) < 1e-6 * values[1] / values[0])


def _slider_of(row: Input) -> tuple[float, float, str]:
    """Return the slider of a state or a parameter of a system: from 0 to twice its default, or around 0."""
    default = float(row.default)
    low, high = sorted((0.0, 2.0 * default)) if default else (-1.0, 1.0)
    return low, high, "linear"


def _input(row: Input, slider: tuple[float, float, str] | None) -> dict[str, Any]:
    low, high, scale = slider or (None, None, "linear")
    least, most = (None if slider is None else _end(row, slider[0], far) for far in (-_FAR, _FAR))
    return {
        **described(row),
        "low": low,
        "high": high,
        "least": least,
        "most": most,
        "scale": scale,
        "control": row.control,
        # a body's page shows only the lengths that the body has
        "words": [word for word in row.words if word != NO_LENGTH],
    }


def _end(row: Input, allowed: float, far: float) -> float | None:
    """Return the last allowed value on the way to a far one; None if the far one is also allowed.

    The rule of every parameter is an interval, so bisection finds its end.
    """
    if row.allows(np.array([far]))[0]:
        return None
    beyond = far
    for _ in range(_HALVINGS):
        middle = 0.5 * (allowed + beyond)
        if row.allows(np.array([middle]))[0]:
            allowed = middle
        else:
            beyond = middle
    return allowed
