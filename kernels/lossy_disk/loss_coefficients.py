"""The coefficients of the laws of friction and drag: from the start of a cell, and in its lane."""

import math
from typing import NamedTuple

from kernels.jit import kernel, simd
from kernels.lanes.layout import LANES
from kernels.lossy_disk import arrays as loss_row
from kernels.lossy_disk.arrays import BILDSTEN, MOFFATT, NONE


class Losses(NamedTuple):
    """Coefficients of the laws in scaled form.

    Attributes
    ----------
    contour, rolling, pivoting : float
        Lever arms of dry friction over the radius.
    damping : float
        Viscous contour friction: torque over m g R per unit of the scaled roll rate.
    film : float
        Moffatt's drag: torque over m g R per unit of the roll rate over the cosine of the tilt.
    layer : float
        Bildsten's drag: torque over m g R per unit of the roll rate to the power 3/2.
    """

    contour: float
    damping: float
    rolling: float
    pivoting: float
    film: float
    layer: float


#: Names of the rows of a lane with the coefficients (`kernels.lossy_disk.layout`).
ROWS = " ".join(Losses._fields).upper()

#: No loss at all.
NOTHING_LOST = Losses(*(0.0 for _ in Losses._fields))

# For other bodies, `loss_row` is replaced by `kernels.lossy_bodies.arrays`.


@kernel
def _not_negative(x):
    return 0.0 <= x < math.inf


@kernel
def are_possible(cell, starts, law):
    """Return whether the coefficients of a start are possible; `law` is the law of the drag of air."""
    radius, mass = starts[loss_row.RADIUS, cell], starts[loss_row.MASS, cell]
    arms = (
        0.0 <= starts[loss_row.ROLLING_FRICTION, cell] < radius
        and 0.0 <= starts[loss_row.PIVOTING_FRICTION, cell] < radius
        and 0.0 <= starts[loss_row.CONTOUR_FRICTION, cell] < radius
    )
    damping = starts[loss_row.CONTOUR_DAMPING, cell]
    air = _not_negative(starts[loss_row.AIR_VISCOSITY, cell]) and _not_negative(
        starts[loss_row.AIR_DENSITY, cell]
    )
    # laws with forces that are not proportional to the weight need the mass
    heavy = (damping == 0.0 and law == NONE) or 0.0 < mass < math.inf
    allowed = _not_negative(damping) and starts[loss_row.FRICTION, cell] >= 0.0
    return arms and heavy and allowed and (law == NONE or air)


@kernel
def scaled_losses(cell, starts, law, face):
    """Return the `Losses` of a cell.

    Parameters
    ----------
    cell : int
    starts : float64[parameters, n]
    law : float
        Law of the drag of air (`kernels.lossy_disk.arrays`).
    face : float
        Radius of the flat face above the air, over R.

    Notes
    -----
    On the steady wobble of a uniform disk, whose roll rate at the inclination a is f^2 = 4/a, the drag has the power
    of Moffatt, Nature 404 (2000) 833: pi mu g R^2 / a^2, or of Bildsten, Phys. Rev. E 66 (2002) 056309:
    4 sqrt(mu rho) g^(5/4) R^(11/4) a^(-5/4). Drag depends on the motion of the disk, not on its mass distribution.
    """
    mass, radius = starts[loss_row.MASS, cell], starts[loss_row.RADIUS, cell]
    viscosity, density = starts[loss_row.AIR_VISCOSITY, cell], starts[loss_row.AIR_DENSITY, cell]
    unit, cubed = math.sqrt(radius / starts[loss_row.GRAVITY, cell]), face * face * face
    film = 0.25 * math.pi * viscosity * radius * unit / mass if law == MOFFATT else 0.0
    layer = math.sqrt(0.5 * viscosity * density * unit) * radius * radius / mass if law == BILDSTEN else 0.0
    damping = starts[loss_row.CONTOUR_DAMPING, cell]
    return Losses(
        contour=starts[loss_row.CONTOUR_FRICTION, cell] / radius,
        # without viscous friction the mass may be unknown
        damping=damping * unit / (mass * radius * radius) if damping > 0.0 else 0.0,
        rolling=starts[loss_row.ROLLING_FRICTION, cell] / radius,
        pivoting=starts[loss_row.PIVOTING_FRICTION, cell] / radius,
        film=cubed * film,
        layer=cubed * face * layer,
    )


@simd
def load_losses(lane, first, lanes):
    """Return the `Losses` of a lane, whose rows begin at the offset `first`."""
    return Losses(
        lanes[first + lane], lanes[first + LANES + lane], lanes[first + 2 * LANES + lane],
        lanes[first + 3 * LANES + lane], lanes[first + 4 * LANES + lane], lanes[first + 5 * LANES + lane],
    )  # fmt: skip


@simd
def store_losses(lane, first, losses, lanes):
    """Store the `Losses` of a lane, whose rows begin at the offset `first`."""
    for number in range(len(losses)):
        lanes[first + number * LANES + lane] = losses[number]


@simd
def weighted(losses, weight):
    """Return the coefficients of the laws times `weight`, except for rolling friction, which acts on the tilt too."""
    return Losses(
        weight * losses.contour, weight * losses.damping, losses.rolling,
        weight * losses.pivoting, weight * losses.film, weight * losses.layer,
    )  # fmt: skip


@simd
def losses_at(a, losses):
    """Return the coefficients of the laws if the contact point is at the distance a from the axis of the body."""
    return Losses(
        a * losses.contour, a * a * losses.damping, losses.rolling, losses.pivoting, losses.film, losses.layer
    )
