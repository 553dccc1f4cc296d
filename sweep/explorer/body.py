"""Data with which the page computes cells of a body of revolution."""

from typing import Any

from sweep.model.bodies.model import BODIES
from sweep.model.bodies.shape import has_poles
from sweep.model.bodies.tables import CALLED, LENGTHS, OF_THE_BODY
from sweep.model.lossy_bodies.model import LOSSY_BODIES
from sweep.model.lossy_bodies.tables import FACED
from sweep.request.spec import SweepSpec

#: Parameter -> the ends of its slider in SI, and its scale.
SLIDERS = {
    "tube": (0.0, 0.9, "linear"),
    "thickness": (0.0, 2.0, "linear"),
    "fillet": (0.0, 0.5, "linear"),
    "offset": (-0.5, 0.5, "linear"),
    "flattening": (-1.0, 0.8, "linear"),
    "axial_moment": (0.05, 1.0, "linear"),
    "transverse_moment": (0.05, 1.0, "linear"),
}

#: Assumed milliseconds per cell until a cell has been computed.
COST = 0.02


def is_body(spec: SweepSpec | None) -> bool:
    """Return whether a spec is given and asks for a body other than the thin disk."""
    return spec is not None and spec.model in (BODIES, LOSSY_BODIES)


def is_of_body(spec: SweepSpec, name: str) -> bool:
    """Return whether a parameter or a setting belongs to the body of a spec; others are not on its page."""
    if name == "fall_tilt":
        return not has_poles(spec.body)
    return not any(name in lengths for lengths in LENGTHS.values()) or name in LENGTHS[spec.body]


def body_cells(spec: SweepSpec) -> dict[str, Any]:
    """Return the arguments of the kernels of a body (`kernels.page.bodies`), suitable for JSON.

    Returns
    -------
    dict
        ``number`` of the body; ``shape``, the parameters that define it; ``hollow`` and ``follows``, 0 or 1: whether a
        torus is hollow, and whether the axial and transverse moments of inertia follow from the shape.
    """
    moments = (spec.axial_moment, spec.transverse_moment)
    return {
        "number": list(LENGTHS).index(spec.body),
        "shape": list(SLIDERS),
        "hollow": int(spec.filling == "hollow"),
        "follows": [int(each == OF_THE_BODY) for each in moments],
    }


def body_motion(spec: SweepSpec) -> dict[str, Any]:
    """Return the data of a body that the page needs to follow and draw its motions, suitable for JSON.

    Returns
    -------
    dict
        ``name`` and ``number`` of the body; ``called``, its name in words; ``poles``, whether it rolls on through its
        poles; ``faced``, whether it has a face, which can trap air beneath it.
    """
    return {
        "name": spec.body,
        "number": list(LENGTHS).index(spec.body),
        "called": CALLED[spec.body],
        "poles": has_poles(spec.body),
        "faced": spec.body in FACED,
    }
