"""Draw the boundary of stable circling for the whole family of disks, from a point mass at the centre to the hoop."""

from typing import TYPE_CHECKING, Any

import numpy as np
from figure_cli import figure_parser, run_script
from matplotlib import colormaps
from matplotlib.figure import Figure
from steady_motions import marginal_curve

import sweep
from sweep.figures import plots
from sweep.figures.sheet import sheet
from sweep.files.paths import check_format

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: Mass distributions: 0.01 is nearly all mass at the centre, 1/2 the uniform disk, 1 the hoop.
SPEC = {
    "alpha": "0.01,0.25,0.5,0.75,1",
    "tilt": "0.25deg:21.25deg:43",
    "precession_rate": "0.03:5:80",
    "roll_rate": "steady",
    "tilt_rate": "1e-6rad/s",
    "criterion": "amplification:20",
    "boundary": "refined",
    "title": "Circling: disks from a point mass at the centre to the hoop",
}
_NAMES = {0.01: "0.01", 0.5: "1/2, disk", 1.0: "1, hoop"}
_MARKERS = "os^Dv"
_MOST_POINTS = 26


def curves(atlas: "xr.Dataset") -> "list[tuple[float, dict[str, Any]]]":
    """Return alpha and the coordinates of every measured curve: tilt [rad], squared rates in units of g/R."""
    found = []
    ends = np.cumsum(atlas.curve_point_count.values)
    unit_squared = float(atlas.radius / atlas.gravity)
    for end, count in zip(ends, atlas.curve_point_count.values, strict=True):
        part = slice(end - count, end)
        alpha = float(atlas.curve_alpha.values[part][0])
        tilt, p = atlas.curve_tilt.values[part], atlas.curve_precession_rate.values[part]
        # the term that keeps the tilt constant, from the balance of the tilt equation
        push = np.tan(tilt) / unit_squared + (1.0 + 0.5 * alpha) * p**2 * np.sin(tilt)
        roll = push / ((1.0 + alpha) * p)
        found.append(
            (
                alpha,
                {"tilt": tilt, "precession_rate": p**2 * unit_squared, "roll_rate": roll**2 * unit_squared},
            )
        )
    return found


def figure(atlas: "xr.Dataset") -> Figure:
    """Draw the nested boundaries by precession rate and by roll rate."""
    radius, gravity = float(atlas.radius), float(atlas.gravity)
    with sheet(7.2, 3.6) as drawn:
        panels = drawn.subplots(1, 2)
        colours = colormaps["viridis"](np.linspace(0.0, 0.85, atlas.sizes["alpha"]))
        for axes, rate in zip(panels, ("precession_rate", "roll_rate"), strict=True):
            for colour, marker, alpha in zip(colours, _MARKERS, atlas.alpha.values, strict=False):
                theory = marginal_curve(float(alpha), radius, gravity)
                line = theory[rate] ** 2 * radius / gravity
                axes.plot(np.degrees(theory["tilt"]), line, color=colour, linewidth=1.2)
                _draw_points(
                    axes, [each for a, each in curves(atlas) if a == alpha], rate, colour, marker, alpha
                )
            axes.set(xlim=(0, 21), xlabel=r"tilt $\theta$ (deg)")
        panels[0].set(
            ylim=(0, 1.12), ylabel=r"precession rate$^2$ $\dot\psi^{\,2} R/g$", title="By precession rate"
        )
        panels[1].set(ylim=(0, 0.56), ylabel=r"roll rate$^2$ $\dot\phi^{\,2} R/g$", title="By roll rate")
        panels[0].annotate(r"ends: $2/(2+\alpha)$", (0.3, 1.03), ha="left", va="bottom")
        panels[1].annotate(r"ends: $1/2(1+\alpha)$", (20.6, 0.52), ha="right", va="bottom")
        handles, labels = panels[0].get_legend_handles_labels()
        drawn.legend(
            handles, labels, loc="outside lower center", ncols=5, frameon=False,
            title=r"mass distribution $\alpha$ (points: RK4, bracket 1e-9; lines: theory, $k = 0$; unstable inside)",
        )  # fmt: skip
    return drawn


def _draw_points(
    axes: "Axes", found: "list[dict[str, Any]]", rate: str, colour: Any, marker: str, alpha: float
) -> None:
    for i, each in enumerate(found):
        some = (
            np.linspace(0, each["tilt"].size - 1, min(each["tilt"].size, _MOST_POINTS // len(found)))
            .round()
            .astype(int)
        )
        axes.plot(
            np.degrees(each["tilt"][some]), each[rate][some], linestyle="", marker=marker, markersize=3.6,
            markerfacecolor="white", color=colour, label=None if i else _NAMES.get(alpha, f"{alpha:g}"),
        )  # fmt: skip


def main() -> None:
    """Compute the atlas, print the largest unstable tilt of each disk, write the figure."""
    output = figure_parser(__doc__, "alphas.png").parse_args().output
    check_format(output)
    atlas = sweep.run(sweep.SweepSpec(**SPEC))
    print("alpha   largest unstable tilt, measured   theory (k = 0)")
    for alpha in atlas.alpha.values:
        most = max(np.degrees(each["tilt"]).max() for a, each in curves(atlas) if a == alpha)
        theory = marginal_curve(float(alpha), float(atlas.radius), float(atlas.gravity))
        print(f"{alpha:<7g} {most:.3f} deg                        {np.degrees(theory['tilt']).max():.3f} deg")
    plots.save(figure(atlas), output)


if __name__ == "__main__":
    run_script(main)
