"""One point of the map: the numbers of the nearest stored cell, and the text of `eulerdisk explain`."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sweep.engine.compute import compute
from sweep.engine.grid import whole
from sweep.explorer.body import is_body
from sweep.explorer.fields import read_number, read_object
from sweep.explorer.lines import bracket_width
from sweep.explorer.plan import LEFT_OUT
from sweep.explorer.stored import Stored
from sweep.explorer.system import is_system
from sweep.explorer.view import View
from sweep.explorer.waiting import KERNELS
from sweep.model.description import Columns
from sweep.model.quantity import Array, Quantity
from sweep.motion.lossy_tables import LOSSY_BODY_MOTION, LOSSY_MOTION
from sweep.request.sources import Values
from sweep.request.spec import SweepSpec

#: Text for a place where no cell is stored and none can be computed.
NO_CELL = "No cell here."

#: Cells in the row in which the boundary near a point is sought.
_ROW = 96


def stored_point(view: View, stored: Stored | None, fields: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the stored cell nearest to a point; None if there is none.

    Parameters
    ----------
    view : View
    stored : Stored or None
    fields : mapping
        ``x`` and ``y``, the values of the two parameters in SI.

    Returns
    -------
    dict or None
        ``start``, ``numbers`` and ``verdict``: every number with its value in SI (None if there is none) and as text.

    Raises
    ------
    RequestError
    """
    x, y = place(fields)
    held = None if stored is None else stored.cell(view, float(x[0]), float(y[0]))
    if stored is None or held is None:
        return None
    start, columns = held
    return {
        "start": {
            name: _number_with_text(stored.spec.model.parameters[name], value)
            for name, value in start.items()
        },
        **numbers_of(stored.spec, columns),
        "stored": None,
    }


def place(fields: Mapping[str, Any]) -> tuple[Array, Array]:
    """Return the values of both parameters at a point, ``x`` and ``y`` of a request, shape (1,) each."""
    return np.array([read_number(fields, "x")]), np.array([read_number(fields, "y")])


def numbers_of(spec: SweepSpec, cell: Columns) -> dict[str, Any]:
    """Return the numbers of one cell, and its verdict in words, from columns with a single value."""
    variables = spec.model.cell_variables(spec)
    numbers = [
        {
            "name": name,
            "label": name.replace("_", " "),
            "description": quantity.long_name,
            **_number_with_text(quantity, float(cell[name][0])),
        }
        for name, quantity in variables.items()
        if name not in LEFT_OUT and name in cell
    ]
    return {"numbers": numbers, "verdict": variables["stability"].flag(float(cell["stability"][0]))}


def _number_with_text(quantity: Quantity, value: float) -> dict[str, Any]:
    if quantity.flags is not None:
        return {"value": value if np.isfinite(value) else None, "text": quantity.flag(value)}
    if not np.isfinite(value):
        return {"value": None, "text": "none"}
    return {"value": value, "text": quantity.spell(value, 3 if quantity.dtype == "f4" else 6)}


def _spec_of_motion(view: View, fields: Mapping[str, Any]) -> SweepSpec | None:
    """Return the spec of the single cell of a motion that has to be integrated.

    None for other motions or without one.
    """
    from sweep.explorer.motion import check_start, is_lossy, words_of

    losses = read_object(fields.get("losses") or {}, "losses")
    lossy = is_lossy(view.spec, losses)
    if "losses" not in fields or is_system(view.spec) or (view.is_live and not lossy):
        return None
    start = {name: float(values[0]) for name, values in view.starts(*place(fields)).items()}
    check_start(view.spec, start)
    if not lossy:
        return view.spec.replace(**{side.name: start[side.name] for side in (view.x, view.y)})
    words = words_of(view.spec, start, losses)
    # a rate that keeps the tilt constant stays a word: it determines what the start perturbs
    words |= {name: getattr(view.spec, name) for name in view.spec.computed}
    model = (LOSSY_BODY_MOTION if is_body(view.spec) else LOSSY_MOTION).model
    if view.spec.model is model:
        words |= {name: getattr(view.spec, name) for name in ("step", "tolerance")}
    # follow it to its end, like the motion that is drawn
    words["duration"] = max(view.spec.duration, float(model.settings["duration"].default))
    return SweepSpec(model=model.name, criterion=view.spec.criterion, **words)


def _compute(spec: SweepSpec) -> Columns:
    """Return the columns of all cells of a small spec."""
    for kernel in spec.model.kernels(spec):
        # compiling takes seconds, in which maps continue
        kernel.make_ready()
    with KERNELS:
        return compute(spec, whole(spec))


def explanation(view: View, stored: Stored | None, fields: Mapping[str, Any]) -> str:
    """Explain the cell at a point, in the row of the window along the control parameter, or the nearest stored cell.

    With losses, only the cell of the motion is explained.

    Parameters
    ----------
    view : View
    stored : Stored or None
        The atlas whose cells are explained if none can be computed.
    fields : mapping
        As for `stored_point`, and ``losses`` if a motion is shown.

    Raises
    ------
    RequestError
    """
    from sweep.atlas.dataset import assemble
    from sweep.checks.explain import explain
    from sweep.checks.explanation import write_computed_cell

    x, y = place(fields)
    at = {view.x.name: float(x[0]), view.y.name: float(y[0])}
    if alone := _spec_of_motion(view, fields):
        return write_computed_cell(explain(assemble(alone, _compute(alone), "explorer"), {}), at)
    if stored is not None and not view.is_live:
        return NO_CELL if stored.cell(view, *at.values()) is None else stored.explained(view, at)
    axes = {name: Values((value,)) for name, value in at.items()}
    refined = {}
    controls = view.live.model.controls(at)
    if controls:
        side = view.x if view.x.name == controls[0] else view.y
        row = np.append(side.at(np.linspace(-1.0, 1.0, _ROW)), at[side.name])
        axes[side.name] = Values(tuple(np.unique(row).tolist()))
        refined = {"boundary": f"refined:{bracket_width(view)!r}"}
    spec = view.live.replace(**axes, **refined)
    # computes single cells on one thread, like motions, in parallel with maps
    return write_computed_cell(explain(assemble(spec, _compute(spec), "explorer"), at), at)
