"""Data with which the page computes cells of a body of revolution."""

from typing import Any

from sweep.model.bodies.model import BODIES
from sweep.model.bodies.shape import has_poles
from sweep.model.bodies.tables import CALLED, LENGTHS, OF_THE_BODY
from sweep.model.lossy_bodies.model import LOSSY_BODIES
from sweep.model.lossy_bodies.tables import FACED
from sweep.request.spec import SweepSpec

#: Parameter -> the ends of its slider in SI, and how it is spread.
SLIDERS = {
    "tube": (0.0, 0.9, "linear"),
    "thickness": (0.0, 2.0, "linear"),
    "fillet": (0.0, 0.5, "linear"),
    "offset": (-0.5, 0.5, "linear"),
    "flattening": (-1.0, 0.8, "linear"),
    "axial_moment": (0.05, 1.0, "linear"),
    "transverse_moment": (0.05, 1.0, "linear"),
}

#: Milliseconds that a cell is taken to need until one has been computed.
COST = 0.02


def is_body(spec: SweepSpec | None) -> bool:
    """Return whether there is a spec, and it asks for another body than the thin disk."""
    return spec is not None and spec.model in (BODIES, LOSSY_BODIES)


def is_of_body(spec: SweepSpec, name: str) -> bool:
    """Return whether a parameter or a setting is one of the body of a spec: others have no place on its page."""
    if name == "fall_tilt":
        return not has_poles(spec.body)
    return not any(name in lengths for lengths in LENGTHS.values()) or name in LENGTHS[spec.body]


def body_cells(spec: SweepSpec) -> dict[str, Any]:
    """Return what the kernels of a body are called with (`kernels.page.bodies`), which JSON can hold.

    Returns
    -------
    dict
        ``number`` of the body; ``shape``, the parameters that make it; ``hollow`` and ``follows``, whether a torus is
        hollow, and the axial and the transverse moment follow from the shape: 0 or 1.
    """
    moments = (spec.axial_moment, spec.transverse_moment)
    return {
        "number": list(LENGTHS).index(spec.body),
        "shape": list(SLIDERS),
        "hollow": int(spec.filling == "hollow"),
        "follows": [int(each == OF_THE_BODY) for each in moments],
    }


def body_motion(spec: SweepSpec) -> dict[str, Any]:
    """Return what the page has to know of a body to follow its motions, and to draw it, which JSON can hold.

    Returns
    -------
    dict
        ``name`` of the body; ``number`` of it; ``called``, in words; ``poles``, whether it rolls on through them;
        ``faced``, whether it has a face, under which air is.
    """
    return {
        "name": spec.body,
        "number": list(LENGTHS).index(spec.body),
        "called": CALLED[spec.body],
        "poles": has_poles(spec.body),
        "faced": spec.body in FACED,
    }
