"""Draw how many steady motions share a motion's two constants, their energies, and how far the contact point drifts."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from figure_cli import figure_parser, run_script
from matplotlib.figure import Figure
from steady_motions import marginal_curve

import sweep
from kernels.bodies import motion_arrays, shapes
from kernels.disk.endings import HORIZON
from sweep.figures import plots
from sweep.figures.sheet import sheet
from sweep.files.paths import check_format
from sweep.model.disk.model import DISK
from sweep.model.disk.path import rows_of_disk
from sweep.model.disk.theory import carried_rates
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Truths

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ALPHA = 0.5
#: R and g are 1, so rates are in units of sqrt(g/R). An upright disk with these rates has them as its constants.
PLANE = {
    "precession_rate": "-1.1:1.1:180",
    "roll_rate": "-0.8:0.8:180",
    "tilt_rate": 1e-3,
    "radius": 1.0,
    "gravity": 1.0,
    "method": "exact",
    "fall_tilt": "89deg",
}
#: Sections of the plane, and families of motions with these constants.
SECTIONS = (0.05, 0.3, 0.6)
FAMILIES = ((0.45, 0.0), (0.45, 0.03))

_BLUE, _RED, _GREY = "#0b5a8a", "#c8380a", "0.35"
_BOX = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85}


_TRAJECTORY = Kernel("kernels.bodies.trajectory", "trajectory", seconds=3.0)

#: Number of steps per nutation period, each of two RK4 steps.
_STEPS = 2000

#: Largest tilt [rad], to either side, at which steady motions are sought, and the number of tilts.
_MOST_TILT, _TILTS = 1.2, 4001

#: Tilt [rad] that no motion reaches, so that no motion ends in a fall.
_FLAT = 0.5 * np.pi


@dataclass(frozen=True)
class Branch:
    """Steady motions with one value of c2: tilt [rad], c1, energy in units of m g R, and whether stable; shape (n,)."""

    tilt: Array
    c1: Array
    energy: Array
    stable: Truths


def fold(alpha: float) -> tuple[Array, Array]:
    """Return c1 and c2 of the steady motions with k = 0 (positive tilt and precession), from rolling to spinning.

    Along this line, two of the steady motions that share the constants merge; at its two ends, the cusps, all three do.
    """
    curve = marginal_curve(alpha, 1.0, 1.0)
    tilt, p = curve["tilt"], curve["precession_rate"]
    s, o = curve["roll_rate"] + p * np.sin(tilt), p * np.cos(tilt)
    return carried_rates(tilt, np.zeros_like(tilt), s, o, np.full_like(tilt, alpha))


def branches(alpha: float, c2: float) -> list[Branch]:
    """Return the steady motions with a given c2 as curves over their tilt.

    Parameters
    ----------
    alpha : float
    c2 : float
        A value other than 0, for which the curves cross at upright, where every c1 is steady.

    Returns
    -------
    list of Branch
        The smaller and the larger of the two values of c1 at each tilt.

    Notes
    -----
    s and o are linear in c1 and c2, so the tilt equation at rest, S + o ((1+alpha) s - (alpha/2) o T) = 0, is quadratic
    in c1. Steady motions are stable where V'' > 0.
    """
    tilt = np.linspace(-_MOST_TILT, _MOST_TILT, _TILTS)
    zero, ones, alphas = np.zeros_like(tilt), np.ones_like(tilt), np.full_like(tilt, alpha)
    s1, o1 = carried_rates(zero, tilt, ones, zero, alphas)
    s2, o2 = (c2 * each for each in carried_rates(zero, tilt, zero, ones, alphas))
    tangent = np.tan(tilt)
    q1, q2 = ((1.0 + alpha) * s - 0.5 * alpha * o * tangent for s, o in ((s1, o1), (s2, o2)))
    a, b, c = o1 * q1, o1 * q2 + o2 * q1, np.sin(tilt) + o2 * q2
    found = []
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - 4.0 * a * c)
        large = -0.5 * (b + np.copysign(root, b))
        for c1 in (c / large, large / a):
            s, o = c1 * s1 + s2, c1 * o1 + o2
            energy = 0.5 * (1.0 + alpha) * s * s + 0.25 * alpha * o * o + np.cos(tilt)
            # V' = -(S + o q), q = (1+alpha) s - (alpha/2) o T, o' = oT - 2s
            o_slope = o * tangent - 2.0 * s
            q = (1.0 + alpha) * s - 0.5 * alpha * o * tangent
            q_slope = -o - 0.5 * alpha * (o_slope * tangent + o * (1.0 + tangent**2))
            stable = -(np.cos(tilt) + o_slope * q + o * q_slope) > 0.0
            there = np.isfinite(c1)
            found.append(Branch(tilt[there], c1[there], energy[there], stable[there]))
    return found


@dataclass(frozen=True)
class Drift:
    """The change of heading and contact point in one nutation period, shape (n,).

    `turn` [rad] is the change of the heading, `advance` [R] the distance between the contact points at the two ends.
    Repeated over all periods, this is a rotation about a fixed centre: the contact point stays in a ring. Its middle
    circle, through the ends of the periods, has the radius `radius` [R]; this is infinite, and the drift unbounded,
    only if the heading returns to its initial value.
    """

    turn: Array
    advance: Array
    radius: Array


def drift(tilt: Array, s: Array, o: Array, alpha: float, period: Array) -> Drift:
    """Integrate motions from a turning point, where the tilt is at rest, through one nutation period.

    Parameters
    ----------
    tilt : array, shape (n,)
        Turning point [rad].
    s, o : array, shape (n,)
        Scaled rates at the turning point.
    alpha : float
    period : array, shape (n,)
        Nutation period in units of sqrt(R/g).

    Returns
    -------
    Drift
        NaN where the period is not finite, or the motion could not be integrated.
    """
    precession_rate = o / np.cos(tilt)
    roll_rate = s - precession_rate * np.sin(tilt)
    ends = np.full((len(motion_arrays.SAMPLES), tilt.size), np.nan)
    starts = rows_of_disk(
        {
            "tilt": tilt,
            "precession_rate": precession_rate,
            "roll_rate": roll_rate,
            "alpha": np.full_like(tilt, alpha),
            "radius": np.ones_like(tilt),
            "gravity": np.ones_like(tilt),
        }
    )
    for i in np.flatnonzero(np.isfinite(period)):
        start = starts[:, i : i + 1].copy()
        samples = np.empty((len(motion_arrays.SAMPLES), 2))
        settings = np.array([period[i] / _STEPS, 0.0, _FLAT, shapes.TORUS])
        ending, *_ = _TRAJECTORY.load()(start, settings, np.array([0.0, period[i]]), samples)
        if ending == HORIZON:
            ends[:, i] = samples[:, 1]
    turn = ends[motion_arrays.HEADING]
    advance = np.hypot(ends[motion_arrays.CONTACT_X], ends[motion_arrays.CONTACT_Y])
    with np.errstate(divide="ignore"):
        return Drift(turn, advance, advance / (2.0 * np.abs(np.sin(0.5 * turn))))


def family(c1: float, c2: float, tilt: Any) -> tuple[Any, Drift]:
    """Return which motions released at rest at some tilts are trapped in one well, and their drift."""
    full = np.full_like(tilt, 1.0)
    s, o = carried_rates(0.0 * tilt, tilt, c1 * full, c2 * full, _ALPHA * full)
    p = o / np.cos(tilt)
    given = {
        "tilt": tilt,
        "tilt_rate": 0.0 * tilt,
        "precession_rate": p,
        "roll_rate": s - p * np.sin(tilt),
        "alpha": _ALPHA * full,
        "radius": full,
        "gravity": full,
    }
    found = DISK.exact.measures(sweep.SweepSpec(fall_tilt="89deg"), given)
    # a motion that passes a maximum has it among its numbers; one far below has none
    return ~(found["separatrix"] < 0.0), drift(tilt, s, o, _ALPHA, found["nutation_period"])


def figure() -> Figure:
    """Draw the plane of constants, the energies along sections of it, and the drift of the contact point."""
    with sheet(10.6, 3.6) as drawn:
        left, middle, right = drawn.subplots(1, 3)
        _draw_plane(left)
        _draw_energies(middle)
        _draw_drift(right)
    return drawn


def _draw_plane(axes: "Axes") -> None:
    atlas = sweep.run(sweep.SweepSpec(alpha=_ALPHA, **PLANE))
    three = (atlas.wells == 2).transpose("precession_rate", "roll_rate")
    axes.contourf(
        atlas.roll_rate, atlas.precession_rate, three, levels=[0.5, 1.5], colors=["#f3d9b1"], hatches=["////"]
    )
    c1, c2 = fold(_ALPHA)
    for x in (1.0, -1.0):
        for y in (1.0, -1.0):
            axes.plot(x * c1, y * c2, color="black", linewidth=1.3)
    for x, y in ((c1[0], c2[0]), (c1[-1], c2[-1])):
        axes.plot([x, -x], [y, -y], linestyle="", marker="D", color="black", markersize=5)
    axes.annotate("cusp: rolling\n$c_1^2 = 1/3$", (-c1[0], 0.0), (-2, 62), textcoords="offset points", ha="center",
                  arrowprops={"arrowstyle": "-", "linewidth": 0.6})  # fmt: skip
    axes.annotate("cusp: spinning\n$c_2^2 = 4/5$", (0.0, c2[-1]), (-52, -22), textcoords="offset points", ha="center",
                  arrowprops={"arrowstyle": "-", "linewidth": 0.6})  # fmt: skip
    axes.text(0.0, 0.0, "3 steady motions\n2 stable, 1 not", ha="center", va="center", bbox=_BOX)
    axes.text(0.0, -1.02, "1 steady motion, stable", ha="center", va="center")
    for c in SECTIONS:
        axes.axhline(c, color=_GREY, linewidth=0.7, linestyle=":")
    axes.set(xlim=(-0.8, 0.8), ylim=(-1.1, 1.1), title="Constants of the motion")
    axes.set(xlabel=r"$c_1$: roll rate at upright ($\sqrt{g/R}$)")
    axes.set_ylabel(r"$c_2$: precession rate at upright ($\sqrt{g/R}$)")


def _draw_energies(axes: "Axes") -> None:
    for c2, colour in zip(SECTIONS, (_BLUE, "#7a4fa3", _RED), strict=True):
        for branch in branches(_ALPHA, c2):
            for stable in (True, False):
                # minus the energy of the upright disk, because the swallow's tail is thin
                above = branch.energy - 1.0 - 0.75 * branch.c1**2 - 0.125 * c2**2
                shown = np.where((branch.stable == stable) & (np.abs(branch.c1) < 0.8), above, np.nan)
                axes.plot(
                    branch.c1, 100.0 * shown, color=colour, linewidth=1.4 if stable else 1.0,
                    linestyle="-" if stable else (0, (3, 1.5)),
                )  # fmt: skip
        axes.plot([], [], color=colour, label=f"$c_2 = {c2:g}$")
    axes.plot([], [], color="black", linestyle=(0, (3, 1.5)), label="unstable")
    axes.set(
        xlim=(-0.75, 0.75), ylim=(-13, 6.5), xlabel=r"$c_1$ ($\sqrt{g/R}$)", title="Steady motions: energy"
    )
    axes.set_ylabel("energy above upright ($10^{-2}$ $mgR$)")
    axes.legend(frameon=False, loc="upper center", ncols=2)


def _draw_drift(axes: "Axes") -> None:
    tilt = np.radians(np.linspace(33.0, 60.0, 271))
    for (c1, c2), colour, width in zip(FAMILIES, (_BLUE, _RED), (1.3, 1.3), strict=True):
        trapped, found = family(c1, c2, tilt)
        returns = np.abs(np.sin(0.5 * found.turn)) < 1e-6
        radius = np.where(returns, np.nan, found.radius)
        axes.plot(
            np.degrees(tilt), radius, color=colour, linewidth=width, label=f"$c_1 = {c1:g}$, $c_2 = {c2:g}$"
        )
        edge = np.degrees(tilt[trapped].max())
        axes.axvline(edge, color=colour, linewidth=0.8, linestyle=":")
        if returns.any():
            axes.axvspan(edge, 60.0, facecolor="0.9", linewidth=0.0, zorder=0)
    axes.set(yscale="log", xlim=(33, 60), ylim=(0.1, 300.0), title="Drift of the contact point")
    axes.set(xlabel="tilt at which the disk is released (deg)", ylabel="radius of the ring of drift ($R$)")
    axes.text(34, 0.14, "left of the dots: trapped on one side", bbox=_BOX)
    axes.text(59.5, 16.0, "grey: for $c_2 = 0$\nunbounded, as the\nheading returns", ha="right", va="top")
    axes.legend(loc="upper left", framealpha=0.9, edgecolor="none")


def main() -> None:
    """Write the figure."""
    output = figure_parser(__doc__, "bifurcation.png").parse_args().output
    check_format(output)
    plots.save(figure(), output)


if __name__ == "__main__":
    run_script(main)
