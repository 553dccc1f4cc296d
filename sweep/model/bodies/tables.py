"""The tables of bodies of revolution: the words of a request, and the differences from the disk's tables."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from kernels.bodies import shapes
from kernels.disk import endings as code
from sweep.model.disk import tables as disk
from sweep.model.disk.path import PATH
from sweep.model.quantity import (
    GRID,
    OPEN,
    Array,
    Ending,
    Endings,
    Input,
    Quantity,
    Substitute,
    Truths,
    Word,
    positive,
    table,
)

#: The word for a moment of inertia that follows from the shape of a homogeneous body.
OF_THE_BODY = "body"

#: The word for a length that a body does not have, or that is 0.
NONE = "none"

#: Body -> its lengths, the required ones first.
LENGTHS: Mapping[str, tuple[str, ...]] = MappingProxyType({
    "torus": ("tube",), "rounded": ("thickness",), "rim": ("thickness", "fillet"), "arc": ("fillet", "offset"),
    "ball": ("offset",), "spheroid": ("flattening", "offset"),
})  # fmt: skip
assert tuple(LENGTHS) == shapes.NAMES

#: Lengths that default to 0.
OPTIONAL = ("fillet", "offset")

#: Body -> its name in a sentence.
CALLED: Mapping[str, str] = MappingProxyType({
    "torus": "torus", "rounded": "disk with a semicircular edge", "rim": "disk with a rim",
    "arc": "body with an arc for its edge", "ball": "ball", "spheroid": "spheroid",
})  # fmt: skip

_MOMENTS = ("axial_moment", "transverse_moment")


#: The lengths of bodies in radii, which may also be given in metres.
_LENGTH_NAMES: Mapping[str, str] = MappingProxyType({
    "tube": "radius of the tube of a torus", "thickness": "thickness of a disk",
    "fillet": "radius of the edges of a rim or an arc",
    "offset": "distance along the axis of the centre of mass from the centre of an arc, a ball or a spheroid",
})  # fmt: skip


def _length(name: str, symbol: str, rule: str, allows: Callable[[Array], Truths]) -> Input:
    return Input(
        name, symbol, "1", f"{_LENGTH_NAMES[name]}, over the outer radius", GRID,
        "given with a unit of length, it is divided by the radius",
        default=NONE, rule=rule, allows=allows, words=(NONE,), meaning="the body has no such length",
        constants={NONE: 0.0},
    )  # fmt: skip


def _moment(name: str, symbol: str, long_name: str) -> Input:
    return Input(
        name, symbol, "1", f"{long_name}, over mass times radius squared", GRID,
        default=OF_THE_BODY, rule=f"{name} > 0", allows=positive, words=(OF_THE_BODY,),
        meaning="what follows from the shape of a homogeneous body", constants={OF_THE_BODY: 0.0},
    )  # fmt: skip


def _in_metres(name: str) -> Substitute:
    """Return the substitute of a length over the radius: the length in metres, under the same name."""
    return Substitute(
        name, PARAMETERS[name].symbol, "m", _LENGTH_NAMES[name], GRID,
        parameter=name, needs=("radius",), scale=lambda body: body["radius"],
    )  # fmt: skip


# fmt: off
PARAMETERS: Mapping[str, Input] = table(
    replace(disk.PARAMETERS["tilt"], long_name="initial tilt of the body: of its axis from the horizontal"),
    disk.PARAMETERS["tilt_rate"],
    replace(disk.PARAMETERS["precession_rate"], words=(disk.WOBBLE,),
            meaning="with roll_rate=wobble, the rate that keeps the tilt constant while the centre of mass rests"),
    replace(disk.PARAMETERS["roll_rate"],
            long_name="initial rate of roll about the axis of the body, in the precessing frame",
            description="times the distance of the contact point from the axis, it is the speed of that point along "
                        "its path; positive: forwards"),
    _length("tube", r"\rho", "0 <= tube < 1", lambda tube: (tube >= 0.0) & (tube < 1.0)),
    _length("thickness", "d", "0 <= thickness <= 10",
            lambda thickness: (thickness >= 0.0) & (thickness <= 10.0)),
    _length("fillet", "r", "0 <= fillet <= 1", lambda fillet: (fillet >= 0.0) & (fillet <= 1.0)),
    _length("offset", "e", "-3 < offset < 3", lambda offset: np.abs(offset) < 3.0),
    Input("flattening", "f", "1", "flattening of a spheroid, 1 minus the polar radius over the equatorial radius",
          GRID, "negative: prolate", default=NONE, rule="-2 <= flattening <= 0.8",
          allows=lambda flattening: (flattening >= -2.0) & (flattening <= 0.8), words=(NONE,),
          meaning="the body is not a spheroid", constants={NONE: 0.0}),
    _moment("axial_moment", "I", "moment of inertia about the axis of the body"),
    _moment("transverse_moment", "A", "moment of inertia about a line across the axis through the centre of mass"),
    replace(disk.PARAMETERS["radius"], long_name="outer radius of the body"),
    disk.PARAMETERS["gravity"],
)

SUBSTITUTES: Mapping[str, Substitute] = table(
    *(disk.SUBSTITUTES[name] for name in ("scaled_tilt_rate", "scaled_precession_rate", "scaled_roll_rate",
                                          "inclination", "diameter")),
    *map(_in_metres, _LENGTH_NAMES),
)

SETTINGS: Mapping[str, Input] = MappingProxyType({
    **disk.SETTINGS,
    "fall_tilt": replace(disk.SETTINGS["fall_tilt"], long_name="tilt at which the body counts as fallen"),
})

OPTIONS: Mapping[str, Word] = table(
    # the default is the body that needs no length
    Word("body", "what rolls", "ball", shapes.NAMES,
         remark="leave body out for the thin disk"),
    PATH,
    disk.OPTIONS["contact"],
    Word("filling", "whether a torus is solid, or has all its mass in its surface", "solid", ("solid", "hollow")),
)

ENDINGS = Endings(
    *disk.ENDINGS,
    Ending(code.EDGE_CHANGE, "edge_change", "the tilt reached 0: a disk with a rim stands on both of its edges", OPEN,
           "the tilt reached 0, where the other edge hits the plane: this model does not include that impact"),
    lost_time=disk.ENDINGS.lost_time,
)

AMPLIFICATION_SCALE = (
    "scale = sqrt((tilt - steady tilt)^2 + tilt_rate^2 (1 + transverse moment) radius / gravity)"
)

#: The variables of the disk, with the moment of the body in the scale of the perturbation.
VARIABLES: Mapping[str, Quantity] = MappingProxyType({
    **disk.VARIABLES,
    "ending": ENDINGS.quantity,
    "amplification": replace(
        disk.VARIABLES["amplification"],
        description=f"{AMPLIFICATION_SCALE}; missing where ending is steady, not_computed, unresolved or invalid",
    ),
})
# fmt: on

#: Additional variables with ``contact=yes``.
CONTACT_VARIABLES: Mapping[str, Quantity] = MappingProxyType({
    **disk.CONTACT_VARIABLES,
    "least_normal_force": replace(
        disk.CONTACT_VARIABLES["least_normal_force"],
        description="the body would lift off where it is not positive",
    ),
})  # fmt: skip

#: Words of a request that choose this model.
CHOOSING = ("body", "filling", *(name for names in LENGTHS.values() for name in names), *_MOMENTS)
