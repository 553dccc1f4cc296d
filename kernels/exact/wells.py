"""The potential of the reduced motion, of one motion at a time (scaled as in `kernels.disk`).

(1+alpha/2)/2 w^2 + V = h with V = (1+alpha)/2 s^2 + (alpha/4) o^2 + cos(tilt), and s, o functions of the tilt alone
(`kernels.exact.legendre`). `y` is the stretched tilt atanh(sin(tilt)); (c1, c2) are the values of (s, o) at upright,
the two constants of a motion; "excess" is V - h, negative where the motion can be.

Sources: Borisov, Mamaev, Kilin, Regul. Chaotic Dyn. 8 (2003) 201; O'Reilly, Nonlinear Dynamics 10 (1996) 287.
"""

from kernels.exact.legendre import (
    COS1,
    DO1,
    DO2,
    DP1,
    DP2,
    DS1,
    DS2,
    NODES,
    ONE,
    PANEL,
    PANELS,
    PP,
    REACH,
    SP,
    SS,
)  # fmt: skip
from kernels.parts import lane_part, part

#: Distance [panel centre, y] up to which the expansion about a start on the panel holds.
NEAR = 0.75 * PANEL
#: Distance of two nodes.
NODE = 0.5 * PANEL


@lane_part
def rise_at(nodes, node):
    """What `rise` has to know of a node: to be read before a loop over lanes."""
    return nodes[node, DS1], nodes[node, DS2], nodes[node, DO1], nodes[node, DO2], nodes[node, COS1]


@lane_part
def rise(alpha, there, c1, c2):
    """V at a node minus V at upright, as a sum of differences: near upright far smaller than the potentials."""
    ds1, ds2, do1, do2, cos1 = there
    ds, do = ds1 * c1 + ds2 * c2, do1 * c1 + do2 * c2
    rolling = 0.5 * (1.0 + alpha) * ds * (2.0 * c1 + ds)
    return rolling + 0.25 * alpha * do * (2.0 * c2 + do) + cos1


@part
def expand_excess(alpha, table, panels, nodes, k, c1, c2, base, out):
    """Excess on panel k as a polynomial in the distance from its centre; `base` is h minus V at upright."""
    panel, node = table * PANELS + REACH + k, table * NODES + 2 * (REACH + k)
    s = c1 + (nodes[node, DS1] * c1 + nodes[node, DS2] * c2)
    p = c2 + (nodes[node, DP1] * c1 + nodes[node, DP2] * c2)
    ss, sp, pp = s * s, s * p, p * p
    # a length unknown to the compiler makes a vector loop; 16 known terms it writes out one by one
    for n in range(out.size):
        out[n] = (
            ss * panels[panel, SS, n]
            + sp * panels[panel, SP, n]
            + pp * panels[panel, PP, n]
            + panels[panel, ONE, n]
        )
    out[0] = rise(alpha, rise_at(nodes, node), c1, c2) - base
