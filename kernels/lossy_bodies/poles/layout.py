"""The rows of a cell in the flat array of LANES cells (`kernels.lanes.layout`); no lane steps."""

from kernels.lanes.layout import LANES, offsets

(STEPS,) = offsets(0, 1)
STEPPING = RETURNED = LANES

#: The start: tilt, and its rates in SI units; sqrt(R/g), the radius;
TILT_0, TILT_RATE_0, PRECESSION_RATE_0, ROLL_RATE_0, UNIT, RADIUS = offsets(1, 7)
#: of `kernels.bodies.shapes.Body`; of `kernels.lossy_disk.loss_laws.Losses`; the friction coefficient;
SHIFT, SQUARE, AXIAL, TRANSVERSE = offsets(7, 11)
CONTOUR, DAMPING, ROLLING, PIVOTING, FRICTION = offsets(11, 16)
#: tilt from which the criterion measures, distance that breaks it [rad].
REFERENCE, REACH = offsets(16, 18)

SIZE = 18 * LANES
