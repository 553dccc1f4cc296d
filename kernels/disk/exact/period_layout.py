"""The rows of a block of motions whose periods are sought: LANES motions side by side.

The block takes the memory of one of `kernels.disk.exact.layout`. All its motions share their table and the wide panel
(`kernels.disk.exact.wide_panels`) in whose w their places are given. Distances are in w from the start: they keep all
their digits however small the swing is.
"""

from kernels.disk.exact.wide_panels import CENTRES, WIDE_TERMS
from kernels.lanes.layout import offsets

#: Fewer than in `kernels.disk.exact.layout`: motions on many panels would leave more lanes empty (64 take 30 % longer
#: for random starts, 32 take 3 % longer where all are alike).
LANES = 32

# The start: its place, the force, the kinetic energy and the sizes of the terms of the excess there
W_0, FORCE, KINETIC, PULL, CURVATURE, LEVEL = offsets(0, 6, LANES)

# The motion: its rates at upright, h minus V at upright
C_1, C_2, BASE = offsets(6, 9, LANES)

# The turning points: distances, and slopes of V in y there. FIRST is where the angle of the quadrature is zero.
FIRST, SECOND, FIRST_SLOPE, SECOND_SLOPE = offsets(9, 13, LANES)

# The saddle: the middle of the two roots of the excess next to it (its distance), half their distance; 1 if passed
AWAY, WIDTH, PASSES = offsets(13, 16, LANES)

# The substitution: distance = ANCHOR + WIDTH sinh(MIDDLE + HALF cos(angle)), see `kernels.disk.exact.period`
ANCHOR, MIDDLE, HALF = offsets(16, 19, LANES)

# A place on the way: its distance, and the derivative by the angle; on a wide panel, the place and the distance that
# the excess is expanded in
DISTANCE, STRETCH, PLACE, AWAY_THERE = offsets(19, 23, LANES)

# A wide panel: how far the first one reaches, from where to where in w the present one counts, the rates at its centre
EDGE, LOW, HIGH, S_HERE, P_HERE = offsets(23, 28, LANES)

# The excess on it, A_0 + D (A_1 + D Q(w)): D is the distance from the start if that lies on it (ABOUT), else from the
# centre; the place of the start, or zero; a coefficient of V divided by D once, and twice
ABOUT, ROOT, A_0, A_1, ONCE, TWICE = offsets(28, 34, LANES)

# The sums: ends of the interval, every fourth place, the places between these, those between all these; of the errors
# by rounding; what is added
ENDS, SUM_4, SUM_2, SUM_1, ERROR, PART = offsets(34, 40, LANES)

# Cosines of the angles of a motion where a wide panel begins to count and where it ends
COS_LOW, COS_HIGH = offsets(40, 42, LANES)

# The saddle as seen from upright: its place, the square of the distance of those roots from it were it a parabola,
# and Taylor coefficients of V about it
PLACE_OF_SADDLE, SQUARE = offsets(42, 44, LANES)
V_0, V_1, V_2, V_3, V_4, V_5 = offsets(44, 50, LANES)
V_TERMS = 6

#: Classes of motions, by the intervals of their first sums (`kernels.disk.exact.period_pass`).
CLASSES = 8

#: Coefficients of Q; they are used in groups of so many, the shorter a swing is the fewer.
Q_TERMS = WIDE_TERMS - 2
GROUP = 8
GROUPS = Q_TERMS // GROUP
Q = 50 * LANES
#: Keys of a table: a block has one class, one number of groups and one wide panel.
PERIOD_KEYS = CLASSES * (GROUPS + 1) * CENTRES
#: Numbers of a block.
PERIOD_SIZE = Q + Q_TERMS * LANES
