"""The rows of a block of motions of the exact reduction: LANES motions side by side (as in `kernels.lanes.layout`).

All motions of a block start on the same panel of the same table (`kernels.disk.exact.legendre`): a coefficient is then
read once for all of them.
"""

from kernels.disk.exact.legendre import TERMS
from kernels.lanes.layout import offsets

#: Enough for the work per block, the fetching of instructions included, to cost little: 32 lanes take 10 % longer, 16
#: take 50 % longer; with 128 more lanes are empty where motions start on many panels.
LANES = 64

# The cell: tilt, radius, gravity, sqrt(R/g); sine, cosine and tan(tilt/2) at the centre of the nearest panel
TILT_0, RADIUS, GRAVITY, UNIT, SIN_THERE, COS_THERE, HALF_THERE = offsets(0, 7, LANES)

# The start (scaled): stretched tilt, its distance from the panel's centre, the rates s and o, the tilt rate, the tilt
Y_0, X_0, S_0, O_0, W_0, SIN, COS = offsets(7, 14, LANES)

# The motion: its rates (s, p) at the panel's centre and (s, o) at upright, h minus V at upright, the force -dV/dy at
# the start, the side to which the disk sets off; where V has its saddle (NaN: one well) and how far that is above h
S_HERE, P_HERE, C_1, C_2, BASE, FORCE, AHEAD, TOP, HEIGHT = offsets(14, 23, LANES)

#: The sizes of the terms of the excess, see `kernels.disk.exact.near_turning_points.rounding_error`.
KINETIC, PULL, CURVATURE, LEVEL = offsets(23, 27, LANES)

# A search to one side: whether the lane takes part, the side, c_2 as seen from there, the excess where the search is,
# where the saddle is, seen from there, if the motion cannot pass it (else infinite); the panel of a start, of a saddle,
# or on which the search ends
WANTED, SIDE, Q, EXCESS, BARRIER, PANEL = offsets(27, 33, LANES)

# A root in its bracket (`kernels.disk.exact.root`): whether it is sought, root, bracket, last step, slope
ACTIVE, ROOT, INNER, OUTER, LAST, SLOPE = offsets(33, 39, LANES)

# What was found: distance from the panel's centre and from the start, tilt, error of the tilt
X, DISTANCE, TILT, ERROR = offsets(39, 43, LANES)

#: Which kind of motion it is (`kernels.disk.exact.motion`), and before it is one how its cell ends.
KIND, ENDING = offsets(43, 45, LANES)

# Intermediate: whether the lane takes part, the node where V' is least, values of V' or the places between them
HERE, NODE, BEFORE, LEAST = offsets(45, 49, LANES)

#: Second derivative of V in y at the saddle.
(BEND,) = offsets(49, 50, LANES)

#: The excess at the panel's centre.
(CENTRE,) = offsets(50, 51, LANES)

#: Coefficients of the excess about the start, and of another polynomial.
NEAR, WORK = 51 * LANES, (51 + TERMS) * LANES

SIZE = (51 + 2 * TERMS) * LANES
