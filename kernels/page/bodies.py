"""The entry points of the page module for a body of revolution."""

import math

from kernels.bodies import arrays as row
from kernels.bodies import shapes, trajectory
from kernels.bodies.poles import trajectory as poles
from kernels.bodies.shapes import BALL, FIRST_WITH_POLES, NAMES, ROUNDED, SPHEROID, TORUS
from kernels.bodies.starts import body_of
from kernels.jit import kernel
from kernels.lossy_bodies import trajectory as lossy
from kernels.native.entry import entry
from kernels.page.sizes import sizes_of
from kernels.page.starts import GIVEN, WOBBLE
from kernels.reduction import contact_extremes
from kernels.reduction.cells import reduce
from kernels.reduction.panels import meridian
from kernels.reduction.path import paths

_torus, _solid, _spheroid = (
    kernel(each) for each in (shapes.torus_moments, shapes.solid_moments, shapes.spheroid_moments)
)


@kernel
def _moments(kind, hollow, starts, i):
    """Return axial and transverse moment of a homogeneous body."""
    if kind == TORUS:
        return _torus(starts[row.TUBE, i], hollow != 0)
    if kind == BALL:
        return 0.4, 0.4
    if kind == SPHEROID:
        return _spheroid(starts[row.FLATTENING, i])
    thickness = starts[row.THICKNESS, i]
    return _solid(thickness, 0.5 * thickness if kind == ROUNDED else starts[row.FILLET, i])


@kernel
def _spin(o, S, C, body):
    """Return the spin, as from `kernels.bodies.steady.steady_spin`."""
    a, b, _, lever = meridian(S, C, body)
    tall = (a * C - b * S) / C
    return -(lever + o * o * (tall * b - body.transverse * S / C)) / (o * (body.axial + a * tall))


@kernel
def _wobble(S, C, body):
    """Return the root of `kernels.bodies.steady.wobble_square`."""
    a, b, _, lever = meridian(S, C, body)
    return math.sqrt(lever / (C * C * (body.transverse * S / C + body.axial * b / a)))


@kernel
def _centred(o, S, C, body):
    """Return the spin, as from `kernels.bodies.steady.centred_spin`."""
    a, b, _, _ = meridian(S, C, body)
    return -b * o / a


@entry(
    kind="float64",
    hollow="int64",
    axial="int64",
    transverse="int64",
    precession="int64",
    roll="int64",
    starts="float64[:, ::1], written",
)
def complete(kind, hollow, axial, transverse, precession, roll, starts):
    """Fill the moments of cells, and the rates that keep their tilts constant.

    Parameters
    ----------
    kind : float
        Number of the body (`kernels.bodies.shapes`).
    hollow : int
        1 if all mass of a torus is in its surface, otherwise 0.
    axial, transverse : int
        Whether the moment is GIVEN; otherwise it is computed for a homogeneous body.
    precession, roll : int
        GIVEN, STEADY (of the roll rate) or WOBBLE, as in `kernels.page.starts`.
    starts : float64[len(PARAMETERS), n], written
        Rows as in `kernels.bodies.arrays`. A rate that does not exist is not finite.
    """
    for i in range(starts.shape[1]):
        if axial != GIVEN or transverse != GIVEN:
            about, across = _moments(kind, hollow, starts, i)
            starts[row.AXIAL_MOMENT, i] = starts[row.AXIAL_MOMENT, i] if axial == GIVEN else about
            starts[row.TRANSVERSE_MOMENT, i] = (
                starts[row.TRANSVERSE_MOMENT, i] if transverse == GIVEN else across
            )
        if precession == GIVEN and roll == GIVEN:
            continue
        body, tilt = body_of(starts, i, kind), starts[row.TILT, i]
        S, C = math.sin(tilt), math.cos(tilt)
        unit = math.sqrt(starts[row.RADIUS, i] / starts[row.GRAVITY, i])
        if precession != GIVEN:
            starts[row.PRECESSION_RATE, i] = _wobble(S, C, body) / unit
        if roll != GIVEN:
            turn = unit * starts[row.PRECESSION_RATE, i]
            o = turn * C
            spin = _centred(o, S, C, body) if roll == WOBBLE else _spin(o, S, C, body)
            starts[row.ROLL_RATE, i] = (spin - turn * S) / unit


def entries_and_sizes(body, contact, goes):
    """Return the entry points for `kernels.native.wasm.module`, and the sizes that a page needs.

    Parameters
    ----------
    body : str
        One of `kernels.bodies.shapes.NAMES`.
    contact : bool
        Whether contact forces are needed.
    goes : bool
        Whether the path of the contact point is needed.
    """
    is_ellipse, has_poles = body == "spheroid", NAMES.index(body) >= FIRST_WITH_POLES
    entries = {
        "complete": complete,
        "reduce": reduce,
        "trajectory": (poles if has_poles else trajectory).trajectory,
    }
    if not has_poles:
        entries["body_lossy_trajectory"] = lossy.trajectory
    if contact:
        entries["contact"] = contact_extremes.contact_ellipses if is_ellipse else contact_extremes.contact
    if goes:
        entries["paths"] = paths
    return entries, sizes_of(entries)
