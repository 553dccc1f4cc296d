"""Measure the critical rates of rolling and spinning only by integration, extrapolate, and compare with theory."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from figure_cli import figure_parser, run_script
from matplotlib.figure import Figure

from sweep.figures import plots
from sweep.figures.sheet import sheet
from sweep.files.paths import check_format
from sweep.model.quantity import Array
from sweep.request.spec import SweepSpec
from sweep.runs.in_memory import run

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The hoop, the uniform disk, and five more.
ALPHAS = (0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 1.0)
LIMITS: Mapping[str, Sequence[float]] = {
    "departure": (0.05, 0.08, 0.12, 0.16, 0.2),
    "amplification": (3.0, 4.0, 6.0, 8.0),
}
MOTIONS = {"roll_rate": "rolling", "precession_rate": "spinning"}

_LOOKS: dict[str, dict[str, Any]] = {
    "roll_rate": {"color": "#0b5a8a", "marker": "o"},
    "precession_rate": {"color": "#c8380a", "marker": "s"},
}
_ROUNDING = 1e-13

#: Ends and number of the rates among which the boundary is sought, in units of sqrt(g/R).
_SEARCHED = (0.3, 1.5, 13)

#: Kicks in units of sqrt(g/R) times the cube of the angle, or of 1/amplification: small compared with the limit.
_KICKS = (0.04, 0.08, 0.16)

_RADIUS, _GRAVITY = 0.5, 9.81

#: Width to which the rate is bisected [rad/s], and tolerance of the extreme tilts [rad].
_WIDTH, _TOLERANCE = 1e-12, 1e-12


@dataclass(frozen=True)
class Convergence:
    """Squared critical rates in units of g/R.

    `small`, shape (limits,), contains angle^2 [rad^2] or 1/amplification^2. `measured` has the shape (kicks, alphas,
    limits). `kickless`, shape (alphas, limits), is extrapolated to zero kick. `value` and `slope`, shape (alphas,), are
    extrapolated to the limit of the criterion: the value there, and d(value)/d(small).
    """

    small: Array
    measured: Array
    kickless: Array
    value: Array
    slope: Array


def convergence(axis: str, kind: str, limits: Sequence[float], alphas: Sequence[float]) -> Convergence:
    """Measure and extrapolate the critical rate of an upright disk.

    Parameters
    ----------
    axis : {"roll_rate", "precession_rate"}
        Rolling or spinning.
    kind : {"departure", "amplification"}
    limits : sequence of float
        Limits of the criterion: angles [rad] or amplifications.
    alphas : sequence of float
        Mass distributions, increasing.

    Returns
    -------
    Convergence
    """
    strict = 1.0 / np.array(limits) if kind == "amplification" else np.array(limits)
    unit_squared = _RADIUS / _GRAVITY
    low, high, count = _SEARCHED
    rows = []
    for limit, angle in zip(limits, strict, strict=True):
        kicks = [kick * angle**3 / unit_squared**0.5 for kick in _KICKS]
        atlas = run(
            SweepSpec(
                **{axis: f"{low / unit_squared**0.5}:{high / unit_squared**0.5}:{count}"},
                tilt_rate=kicks,
                alpha=list(alphas),
                radius=_RADIUS,
                gravity=_GRAVITY,
                criterion=f"{kind}:{limit!r}",
                tolerance=_TOLERANCE,
                boundary=f"refined:{_WIDTH!r}",
                axes=(axis, "tilt_rate", "alpha"),
            )
        )
        rows.append(atlas[f"boundary_{axis}"].values ** 2 * unit_squared)
    measured = np.stack(rows, axis=-1)
    squares = np.square(_KICKS)
    kickless = extrapolated(squares, measured)[0]
    value, slope = extrapolated(strict**2, np.moveaxis(kickless, -1, 0))
    return Convergence(strict**2, measured, kickless, value, slope)


def extrapolated(x: Array, values: Array) -> tuple[Array, Array]:
    """Return the value and the slope at x = 0 of the polynomial through points (Richardson, Neville).

    Parameters
    ----------
    x : array, shape (n,)
    values : array, shape (n, ...)

    Returns
    -------
    (value, slope) : arrays, shape (...)
    """
    weights = np.zeros((2, len(x)))
    for i, each in enumerate(x):
        others = np.delete(x, i)
        # Lagrange polynomials at 0, and their derivatives by the logarithmic derivative
        weights[0, i] = np.prod(others / (others - each))
        weights[1, i] = -weights[0, i] * np.sum(1.0 / others)
    found = np.tensordot(weights, values, axes=(1, 0))
    return found[0], found[1]


Found = Mapping[tuple[str, str], Convergence]


def analytic(axis: str, alpha: Any) -> Any:
    """Return the squared critical rate in units of g/R: 1/[2(1+alpha)] rolling, 2/(2+alpha) spinning."""
    return 1.0 / (2.0 * (1.0 + alpha)) if axis == "roll_rate" else 2.0 / (2.0 + alpha)


def slope(axis: str, kind: str, alpha: Any) -> Any:
    """Return the slope of boundary^2 / limit against angle^2 (departure) or 1/amplification^2."""
    if kind == "amplification":
        return 1.0 + 0.0 * alpha
    return -((11.0 if axis == "roll_rate" else 13.0) + 9.0 * alpha) / (12.0 * (1.0 + alpha))


def table(found: Found) -> str:
    """Return the extrapolated values and slopes as a table, next to theory."""
    lines = ["motion    criterion      alpha  rate^2 R/g        of theory - 1  slope       of theory - 1"]
    for (axis, kind), each in found.items():
        for i, alpha in enumerate(ALPHAS):
            limit, bend = analytic(axis, alpha), slope(axis, kind, alpha)
            value, measured = each.value[i], each.slope[i] / limit
            lines.append(
                f"{MOTIONS[axis]:<9} {kind:<14} {alpha:<6g} {value:.13f}   {value / limit - 1.0:+.1e}      "
                f"{measured:+.7f}  {measured / bend - 1.0:+.1e}"
            )
    return "\n".join(lines)


def figure(found: Found) -> Figure:
    """Draw the critical rates, the approach to them, and the difference that remains after extrapolation."""
    with sheet(10.4, 3.3) as drawn:
        left, middle, right = drawn.subplots(1, 3)
        _draw_values(left, found)
        _draw_approach(middle, found)
        _draw_errors(right, found)
    return drawn


def _draw_values(axes: "Axes", found: Found) -> None:
    fine = np.linspace(0.0, 1.0, 201)
    for axis, name in MOTIONS.items():
        formula = r"$1\,/\,2(1+\alpha)$" if axis == "roll_rate" else r"$2\,/\,(2+\alpha)$"
        axes.plot(fine, analytic(axis, fine), color="black", linewidth=1.0, zorder=1)
        measured = found[axis, "departure"].value
        axes.plot(ALPHAS, measured, linestyle="", markersize=5, label=f"{name}, integrated", **_LOOKS[axis])
        axes.annotate(formula, (0.62, analytic(axis, 0.62)), (0, 6), textcoords="offset points")
    axes.set(
        xlabel=r"mass distribution $\alpha$",
        ylabel=r"critical rate$^2$ $R/g$",
        xlim=(0, 1.04),
        ylim=(0, 1.05),
    )
    axes.set_title("Critical rates, extrapolated")
    axes.legend(frameon=False, loc="lower left")


def _draw_approach(axes: "Axes", found: Found) -> None:
    alpha, at = 0.5, ALPHAS.index(0.5)
    for (axis, kind), each in found.items():
        root = np.sqrt(each.small)
        away = np.abs(each.kickless[at] / analytic(axis, alpha) - 1.0)
        fine = np.geomspace(0.035, 0.45)
        face: dict[str, Any] = {"markerfacecolor": "none"} if kind == "amplification" else {}
        axes.plot(fine, abs(slope(axis, kind, alpha)) * fine**2, color="0.35", linewidth=0.8, zorder=1)
        # rolling and spinning coincide here: draw one marker inside the other
        size = 7 if kind == "amplification" and axis == "precession_rate" else 4.5
        label = f"{MOTIONS[axis]}, {'below, departure' if kind == 'departure' else 'above, amplification'}"
        axes.plot(
            root,
            away,
            linestyle="",
            markersize=size,
            label=label,
            **_LOOKS[axis],
            **face,
        )
    axes.set(xscale="log", yscale="log", xlabel=r"departure $\Theta$ (rad), or $1/$amplification")
    axes.set_ylabel(r"|rate$^2$ / limit $-$ 1|")
    axes.set_title("Approach to the line, disk")
    axes.set_xticks([0.05, 0.1, 0.2, 0.4], ["0.05", "0.1", "0.2", "0.4"])
    axes.minorticks_off()
    axes.annotate(
        r"theory: slopes $c\,\Theta^2$, $1/A^2$", (0.97, 0.05), xycoords="axes fraction", ha="right"
    )
    axes.legend(frameon=False, loc="upper left", handletextpad=0.2)


def _draw_errors(axes: "Axes", found: Found) -> None:
    for (axis, kind), each in found.items():
        error = np.abs(each.value / analytic(axis, np.array(ALPHAS)) - 1.0)
        face: dict[str, Any] = {"markerfacecolor": "white"} if kind == "amplification" else {}
        label = f"{MOTIONS[axis]}, {kind}"
        axes.plot(
            ALPHAS,
            np.maximum(error, _ROUNDING),
            linestyle="",
            markersize=5,
            label=label,
            **_LOOKS[axis],
            **face,
        )
    axes.axhline(1e-6, color="black", linewidth=1.0, linestyle=(0, (4, 2)))
    axes.annotate("promised: 1e-6", (0.02, 1e-6), (0, 3), textcoords="offset points")
    axes.set(yscale="log", ylim=(0.6 * _ROUNDING, 3e-5), xlim=(0, 1.04), xlabel=r"mass distribution $\alpha$")
    axes.set_ylabel("relative error of the extrapolated rate$^2$")
    axes.set_title("Remaining difference")
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(0.0, 0.78), handletextpad=0.2)


def main() -> None:
    """Measure, print the table and write the figure; exit status 1 if a value is not within 1e-6 of theory."""
    output = figure_parser(__doc__, "convergence.png").parse_args().output
    check_format(output)
    found = {
        (axis, kind): convergence(axis, kind, limits, ALPHAS)
        for axis in MOTIONS
        for kind, limits in LIMITS.items()
    }
    print(table(found))
    plots.save(figure(found), output)
    alphas = np.array(ALPHAS)
    if any(
        np.any(np.abs(each.value / analytic(axis, alphas) - 1.0) > 1e-6) for (axis, _), each in found.items()
    ):
        sys.exit("a measured critical rate is not within 1e-6 of theory")


if __name__ == "__main__":
    run_script(main)
