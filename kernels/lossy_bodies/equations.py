"""Equations of motion of a body of revolution with losses, in the forms of `kernels.lossy_disk`.

Geometry, inertia and letters are the same as in `kernels.bodies.equations`: a, b, l, r, A, I, B, D. Losses are
generalised forces F_f and F_v on the rates that they oppose, as for the disk: the roll rate f = s - o T, the turning
rate about the vertical v = o C + s S, and the tilt rate w. About the contact point, a force on f and v changes

    s' by [(A + b^2) M - a b M_d]/D,  o' by [(I + a^2) M_d - a b M]/D,  with M = F_f + S F_v, M_d = C F_v - T F_f,

and a torque on the tilt changes w' by the torque over B. The normal force over m g is 1 + (r - h) w^2 - l w', with
the height h of the centre of mass. Contour friction acts along the circle of the contact point on the body, whose
radius is a: its lever arm is a times the lever arm for the disk, and the distance along that circle is its path.
"""

import math
from typing import NamedTuple

from kernels.bodies.equations import (
    curvature_radius,
    evolute,
    excess,
    height,
    levers,
    per_inertia,
    whole_energy,
)
from kernels.jit import kernel, simd
from kernels.lossy_disk.contact import _forces
from kernels.lossy_disk.contact_motion import spin_state
from kernels.lossy_disk.loss_coefficients import losses_at
from kernels.lossy_disk.loss_laws import Load


class Rolling(NamedTuple):
    """The constants of a body.

    Attributes
    ----------
    core, shift, edge, square, axial, transverse, ratio : float
        As in `kernels.bodies.shapes.Body`.
    inverse_spin : float
        Reciprocal of the transverse moment.
    side : float
        Sign of the tilts on the edge that it rolls on; 0 if it has no other edge.
    i_tilt, i_roll, i_inverse : float
        Equal to 1: for a body, the tilt acceleration replaces the torque on the tilt, and s replaces p = i_roll s.
    """

    core: float
    shift: float
    edge: float
    square: float
    axial: float
    transverse: float
    ratio: float
    inverse_spin: float
    side: float
    i_tilt: float
    i_roll: float
    i_inverse: float


class Place(NamedTuple):
    """Quantities that depend only on the tilt.

    Attributes
    ----------
    a, b, lever, radius, inner : float
        a, b, l, r and a - r C of `kernels.bodies.equations`.
    per : float
        1/B.
    s_roll, o_roll, s_turn, o_turn : float
        Change of s' and o' by a force on f, and by a force on v.
    per_determinant : float
        1/D.
    """

    a: float
    b: float
    lever: float
    radius: float
    inner: float
    per: float
    s_roll: float
    o_roll: float
    s_turn: float
    o_turn: float
    per_determinant: float


@simd
def place_at(S, C, T, body):
    """Return the `Place` of a tilt."""
    a, b, lever = levers(S, C, body)
    A, I, aa, bb, ab = body.transverse, body.axial, a * a, b * b, a * b
    B, D = A + aa + bb, I * (A + bb) + A * aa
    inverse = 1.0 / (B * D)
    per_D = B * inverse
    of_s, of_o = (A + bb) * per_D, (I + aa) * per_D
    both = ab * per_D
    return Place(
        a, b, lever, curvature_radius(S, C, body), evolute(S, C, body), D * inverse,
        of_s + both * T, -(of_o * T + both), of_s * S - both * C, of_o * C - both * S, per_D,
    )  # fmt: skip


@simd
def losses_here(S, C, body, losses):
    """See `kernels.lossy_disk.contact_motion.losses_here`."""
    a, _, _ = levers(S, C, body)
    return losses_at(a, losses)


@simd
def lever(S, C, body):
    """See `kernels.lossy_disk.contact_motion.lever`."""
    _, _, arm = levers(S, C, body)
    return arm


@kernel
def turning_inertia(S, C, body):
    """See `kernels.lossy_disk.contact_motion.turning_inertia`."""
    _, _, arm = levers(S, C, body)
    return body.transverse * C * C + body.axial * S * S + arm * arm


@kernel
def compliance(S, C, body):
    """See `kernels.lossy_disk.contact_motion.compliance`."""
    T = S / C
    here = place_at(S, C, T, body)
    return (
        here.s_roll - T * here.o_roll,
        S * here.s_roll + C * here.o_roll,
        S * here.s_turn + C * here.o_turn,
    )


@kernel
def pull_at_rest(S, C, turning, body):
    """See `kernels.lossy_disk.contact_motion.pull_at_rest`: l + v^2 [(I - A) S C + h l]."""
    _, _, arm = levers(S, C, body)
    return arm + turning * turning * ((body.axial - body.transverse) * S * C + height(S, C, body) * arm)


@simd
def _free_torque(state, here, body):
    """Return the torque, over m g R, that tilts a body without losses, from S, C, w, o, s, o T, T."""
    S, C, w, o, s, oT, T = state
    speed = here.a * s + here.b * o
    gyroscopic = body.axial * s - body.transverse * oT + (here.a - here.b * T) * speed
    return here.lever * (1.0 + here.radius * w * w) + o * gyroscopic


@simd
def _twist(w, o, s, S, here, body):
    """Return w P/D, with P = (a - r C) o - (r S + b I/A) s, which couples s and o to the tilt."""
    return w * (here.inner * o - (here.radius * S + body.ratio * here.b) * s) * here.per_determinant


@simd
def _load_of(S, C, w, here, body):
    return Load(1.0 - w * w * excess(S, C, body), here.lever, here.per)


@simd
def circle(S, C, body):
    """See `kernels.lossy_disk.contact_motion.circle`."""
    a, _, _ = levers(S, C, body)
    return a


@kernel
def unforced(state, body):
    """See `kernels.lossy_disk.contact_motion.unforced`."""
    S, C, w, f, v = state
    T, heading = S / C, v - f * S
    o, s = C * heading, f * C * C + v * S
    here = place_at(S, C, T, body)
    free = _free_torque((S, C, w, o, s, S * heading, T), here, body)
    return free, _load_of(S, C, w, here, body), *_free_rates((S, C, T, w, o, s, f), here, body)


@simd
def _free_rates(state, here, body):
    """Return f' and v' of a body without losses."""
    S, C, T, w, o, s, f = state
    A, I, twist = body.transverse, body.axial, _twist(w, o, s, S, here, body)
    oT = o * T
    roll = twist * (I * here.b * T - A * here.a) - w * (o + (2.0 - body.ratio) * oT * T - body.ratio * f * T)
    turn = w * C * s * (1.0 - body.ratio) - twist * (I * here.b * C + A * here.a * S)
    return roll, turn


@kernel
def beginning_roll(state, body):
    """See `kernels.lossy_disk.dry_friction.beginning_roll`; uses f' over w at f = 0."""
    S, C, w, _, v = state
    tilting, T = w if w != 0.0 else pull_at_rest(S, C, v, body), S / C
    roll, _ = _free_rates((S, C, T, tilting, C * v, S * v, 0.0), place_at(S, C, T, body), body)
    return -1.0 if roll < 0.0 else 1.0


@kernel
def time_scale(state, body):
    """See `kernels.lossy_disk.contact_motion.time_scale`."""
    S, C, w, f, v = state
    s, o = f * C * C + v * S, C * (v - f * S)
    return C / math.sqrt(C * C * own_rate_squared(S, C, s, body) + o * o + w * w)


@simd
def own_rate_squared(S, C, s, body):
    """Return the square of the fastest rate of the linearised motion, except for the precession."""
    a, _, _ = levers(S, C, body)
    return per_inertia(S, C, body) * (1.0 + 2.0 * (body.axial + a * a) * s * s)


@kernel
def contact_forces(state, senses, body, losses):
    """See `kernels.lossy_disk.contact.contact_forces`.

    Notes
    -----
    The centre of mass moves with the velocity (h w, a s + b o) across and along, in the frame that turns with the
    heading. Newton's law for it holds for any law of friction.
    """
    S, C, w, f, v = state
    T, heading = S / C, v - f * S
    o, s = C * heading, f * C * C + v * S
    here = place_at(S, C, T, body)
    tilting, forces = _forces(state, senses, body, losses)
    twist = _twist(w, o, s, S, here, body)
    ds = here.s_roll * forces.roll + here.s_turn * forces.turn - body.transverse * here.a * twist
    do = here.o_roll * forces.roll + here.o_turn * forces.turn - body.axial * here.b * twist
    do += w * (o * T - body.ratio * s)
    return *_pushes((S, C, w, o, s), (tilting, do, ds), heading, here, body), forces


@simd
def _pushes(state, changes, heading, here, body):
    """Return the horizontal forces across and along the track, over m g."""
    S, C, w, o, s = state
    tilting, do, ds = changes
    across = height(S, C, body) * tilting - here.lever * (w * w) - heading * (here.a * s + here.b * o)
    along = here.a * ds + here.b * do + w * (heading * height(S, C, body) - here.radius * (S * s + C * o))
    return across, along


@kernel
def energy_of(state, body):
    """Return the energy (of m g R) of a state (S, C, w, f, v)."""
    return whole_energy(spin_state(state, body), body, body.axial)
