"""The potential of the reduced motion (scaled as in `kernels.disk.equations`), at the nodes of its tables.

(1+alpha/2)/2 w^2 + V = h with V = (1+alpha)/2 s^2 + (alpha/4) o^2 + cos(tilt), and s, o functions of the tilt alone
(`kernels.disk.exact.legendre`). `y` is the stretched tilt atanh(sin(tilt)); (c1, c2) are the values of (s, o) at
upright, the two constants of a motion; "excess" is V - h, negative where the motion can be.

Sources: Borisov, Mamaev, Kilin, Regul. Chaotic Dyn. 8 (2003) 201; O'Reilly, Nonlinear Dynamics 10 (1996) 287.
"""

from kernels.disk.exact.legendre import (
    COS1,
    DO1,
    DO2,
    DS1,
    DS2,
    PANEL,
)  # fmt: skip
from kernels.jit import simd

#: Distance [panel centre, y] up to which the expansion about a start on the panel holds.
NEAR = 0.75 * PANEL
#: Distance of two nodes.
NODE = 0.5 * PANEL


@simd
def rise_at(nodes, node):
    """The numbers of a node that `rise` takes; to be read before a loop over lanes."""
    return nodes[node, DS1], nodes[node, DS2], nodes[node, DO1], nodes[node, DO2], nodes[node, COS1]


@simd
def rise(alpha, there, c1, c2):
    """V at a node minus V at upright, as a sum of differences: near upright far smaller than the potentials."""
    ds1, ds2, do1, do2, cos1 = there
    ds, do = ds1 * c1 + ds2 * c2, do1 * c1 + do2 * c2
    rolling = 0.5 * (1.0 + alpha) * ds * (2.0 * c1 + ds)
    return rolling + 0.25 * alpha * do * (2.0 * c2 + do) + cos1
