"""The words of `eulerdisk explain` for a point of the map."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sweep.explorer.lines import bracket_width
from sweep.explorer.point import NO_CELL, place
from sweep.explorer.stored import Stored
from sweep.explorer.turns import KERNELS
from sweep.explorer.view import View
from sweep.request.axes import Values

#: Cells of the row in which the boundary beside a point is looked for.
_ROW = 96


def explanation(view: View, stored: Stored | None, fields: Mapping[str, Any]) -> str:
    """Explain the cell at a point, in the row of the window along the control parameter; or the nearest stored cell.

    Parameters
    ----------
    view : View
    stored : Stored or None
        Its cells are explained where none can be computed.
    fields : mapping
        ``x`` and ``y``, the values of the two parameters in SI.

    Raises
    ------
    RequestError
    """
    from sweep.atlas.dataset import assemble
    from sweep.checks.explain import explain
    from sweep.engine.compute import compute
    from sweep.engine.grid import whole

    x, y = place(fields)
    at = {view.x.name: float(x[0]), view.y.name: float(y[0])}
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
    with KERNELS:
        columns = compute(spec, whole(spec))
    # what follows computes single cells, with one thread, as motions do beside the maps
    text = explain(assemble(spec, columns, "explorer"), at).text
    parameters = spec.model.parameters
    where = ", ".join(f"{name} {parameters[name].spell(value)}" for name, value in at.items())
    # its first line counts the cells of the row, which nobody has asked for
    return f"cell        {where}\n{text[text.index('start  ') :]}"
