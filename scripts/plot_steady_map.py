"""Draw all steady motions in one figure: which are stable, where that changes, and how fast kicks swing or grow."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from figure_cli import figure_parser, run_script
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from steady_motions import marginal_curve, with_coefficients

import sweep
from sweep.figures import plots
from sweep.figures.sheet import sheet
from sweep.files.paths import check_format
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

#: All kicked steady motions of the uniform disk up to these rates [rad/s], at tilts from -85 to 85 degrees.
SHARED = {
    "tilt": "-85deg:85deg:341",
    "tilt_rate": "1e-5rad/s",
    "criterion": "amplification:10",
    "fall_tilt": "89.5deg",
    "duration": "60s",
    "boundary": "refined",
}
MAPS = {
    "precession": {"precession_rate": "-6:6:240", "roll_rate": "steady"},
    "slow": {"roll_rate": "-9:9:240", "precession_rate": "steady-slow"},
    "fast": {"roll_rate": "-9:9:240", "precession_rate": "steady-fast"},
}
TITLES = {
    "precession": "Steady motions by precession rate",
    "slow": "By roll rate, slower precession",
    "fast": "By roll rate, faster precession",
}
#: Labels at the ends of the curve k = 0 at upright: their positions [rad/s], and text.
_ENDS = {
    "precession": ((3.9618, "spinning\n$\\sqrt{4g/5R}$"),),
    "slow": ((2.5573, "rolling\n$\\sqrt{g/3R}$"),),
    "fast": (),
}

_MOST_POINTS = 46

#: The uniform disk of the report: mass distribution, radius [m], gravity [m/s2]; and Omega^2 = 2g/[(2+alpha)R].
_DISK = 0.5, 0.5, 9.81
FALL_RATE_SQUARED = 2.0 * 9.81 / (2.5 * 0.5)


def compute(name: str, **changes: str) -> "xr.Dataset":
    """Return one of the maps, with the coefficients of its steady motions."""
    return with_coefficients(sweep.run(sweep.SweepSpec(**{**SHARED, **MAPS[name], **changes})))


def describe_agreement(atlas: "xr.Dataset") -> str:
    """Return how verdicts agree with the sign of k, and measured rates with its root, as text."""
    spec = sweep.SweepSpec.from_canonical(atlas.attrs["sweep_spec"])
    k, verdict = atlas.stability_coefficient.values, atlas.stability.values
    assert spec.criterion.kind == "amplification"
    offset = FALL_RATE_SQUARED / spec.criterion.limit**2
    inside, outside = k < 0.0, k > 1.01 * offset
    decided = verdict != UNDECIDED
    wrong = ((verdict != UNSTABLE) & inside & decided) | ((verdict != STABLE) & outside & decided)
    near = ((k >= 0.0) & ~outside).sum()
    text = [
        f"{np.isfinite(k).sum()} steady motions: {int((inside | outside).sum())} beyond the predicted offset of the "
        f"boundary, {int(wrong.sum())} of them contradict the sign of k; {int(near)} within it; "
        f"{int((~decided & np.isfinite(k)).sum())} undecided",
    ]
    for name, sign in (("growth_rate", -1.0), ("nutation_frequency", 1.0)):
        with np.errstate(invalid="ignore"):
            ratio = atlas[name].values / np.sqrt(sign * k)
        known = np.isfinite(ratio) & (sign * k > (offset if sign > 0.0 else 0.0))
        error = np.abs(ratio[known] - 1.0)
        if error.size:
            spread = f"at most {error.max():.1e} from theory, median {np.median(error):.1e}"
            text.append(f"{name} in {error.size} cells: {spread}")
    return "\n  ".join(text)


def figure(atlases: "dict[str, xr.Dataset]") -> Figure:
    """Draw the maps by precession rate and by roll rate, and how far measured rates are from theory.

    The map of the faster precession is omitted, because it is stable everywhere.
    """
    norm = TwoSlopeNorm(0.0, -4.0, 16.0)
    with sheet(10.8, 4.4) as drawn:
        panels = drawn.subplots(1, 3)
        for axes, name in zip(panels, ("precession", "slow"), strict=False):
            background = _draw(axes, name, atlases[name], norm)
        _draw_deviations(panels[2], atlases["precession"])
        handles, labels = panels[0].get_legend_handles_labels()
        drawn.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
        bar = drawn.colorbar(
            background, ax=panels[1], aspect=35, pad=0.02, extend="max", ticks=[-4, -3, -2, -1, 0, 5, 10, 15]
        )
        bar.set_label("growth rate (s$^{-1}$, negative)      nutation frequency (rad s$^{-1}$)")
    return drawn


def _draw(axes: "Axes", name: str, atlas: "xr.Dataset", norm: TwoSlopeNorm) -> Any:
    rate = "precession_rate" if name == "precession" else "roll_rate"
    atlas = atlas.transpose(rate, "tilt", ...)
    tilt, rates = np.degrees(atlas.tilt.values), atlas[rate].values
    measured = atlas.measured_coefficient.values
    root = np.ma.masked_invalid(np.sign(measured) * np.sqrt(np.abs(measured)))
    background = axes.pcolormesh(
        tilt, rates, root, norm=norm, cmap="PuOr", rasterized=True, shading="nearest"
    )
    axes.set_facecolor("0.85")
    unstable = np.where(atlas.stability.values == UNSTABLE, 1.0, 0.0)
    axes.contourf(tilt, rates, unstable, levels=[0.5, 1.5], colors="none", hatches=["////"])
    _draw_theory(axes, name)
    ends = np.cumsum(atlas.curve_point_count.values)
    for end, count in zip(ends, atlas.curve_point_count.values, strict=True):
        each = slice(end - count, end)
        some = np.unique(np.linspace(0, count - 1, min(count, _MOST_POINTS)).round().astype(int))
        x, y = (atlas[f"curve_{part}"].values[each][some] for part in ("tilt", rate))
        axes.plot(
            np.degrees(x), y, linestyle="", marker="o", markersize=3.2, markerfacecolor="white", color="black",
            markeredgewidth=0.8, zorder=4, label="RK4 boundary (bracket 1e-9)" if end == count else None,
        )  # fmt: skip
    for height, word in _ENDS[name]:
        for sign in (1.0, -1.0):
            axes.plot(0.0, sign * height, "D", color="black", markersize=5, zorder=5)
        axes.annotate(
            word, (0.0, height), (30, 14), textcoords="offset points", zorder=6, bbox=_BOX,
            arrowprops={"arrowstyle": "-", "linewidth": 0.7},
        )  # fmt: skip
    if name != "precession":
        axes.plot([], [], color="0.85", linewidth=6, label="no steady motion")
        axes.text(60, 0.0, "none", ha="center", va="center")
    for word, place in (
        ("unstable", (0.0, 1.6)),
        ("stable", (0.0, 5.0) if name == "precession" else (0.0, 6.5)),
    ):
        axes.text(*place, word, ha="center", va="center", weight="bold", bbox=_BOX, zorder=6)
    axes.set(title=TITLES[name], xlim=(-85, 85), ylim=(rates[0], rates[-1]))
    axes.set_xticks([-80, -40, 0, 40, 80])
    axes.set(xlabel=r"tilt $\theta$ (deg)")
    symbol = r"$\dot\psi$" if name == "precession" else r"$\dot\phi$"
    axes.set_ylabel(f"{rate.replace('_', ' ')} {symbol} (rad s$^{{-1}}$)")
    return background


def _draw_deviations(axes: "Axes", atlas: "xr.Dataset") -> None:
    k = atlas.stability_coefficient.values
    for name, sign, colour, words in (
        ("nutation_frequency", 1.0, "#5b3a8c", r"nutation frequency against $\sqrt{k}$"),
        ("growth_rate", -1.0, "#c8680a", r"growth rate against $\sqrt{-k}$"),
    ):
        with np.errstate(invalid="ignore"):
            error = np.abs(atlas[name].values / np.sqrt(sign * k) - 1.0)
        there = np.isfinite(error) & (sign * k > 0.0)
        look: dict[str, Any] = {
            "marker": "o" if sign > 0.0 else "s",
            "markerfacecolor": colour if sign < 0.0 else "white",
        }
        some = np.flatnonzero(there)[:: max(1, int(there.sum()) // 700)]
        axes.plot(
            np.abs(k.flat[some]), np.maximum(error.flat[some], 1e-12), linestyle="", markersize=2.6,
            color=colour, markeredgewidth=0.6, label=words, **look,
        )  # fmt: skip
    axes.axhline(1e-4, color="black", linewidth=1.0, linestyle=(0, (4, 2)))
    axes.annotate(
        "promised: 1e-4", (0.98, 1e-4), (0, 3), ("axes fraction", "data"), "offset points", ha="right"
    )
    axes.set(xscale="log", yscale="log", xlabel=r"$|k|$ of theory (s$^{-2}$)", title="Measured rates")
    axes.set_ylabel("relative deviation from theory")
    axes.legend(frameon=False, loc="lower left", fontsize=7.0, handletextpad=0.2)


_BOX = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.9}


def _draw_theory(axes: "Axes", name: str) -> None:
    """Draw k = 0 and the points where the criterion is met in all four quadrants, which are equivalent by symmetry."""
    lines: tuple[tuple[str, float, dict[str, Any]], ...] = (
        ("theory: $k = 0$", 0.0, {"color": "black", "linewidth": 1.2}),
        (
            "predicted for the criterion",
            FALL_RATE_SQUARED / 100.0,
            {"color": "#c8380a", "linewidth": 1.2, "linestyle": (0, (4, 2))},
        ),
    )
    for label, coefficient, look in lines:
        curve = marginal_curve(*_DISK, coefficient)
        rate = curve["precession_rate" if name == "precession" else "roll_rate"]
        belongs = np.ones(rate.shape, bool) if name == "precession" else curve["faster"] == (name == "fast")
        for across in (1.0, -1.0):
            for up in (1.0, -1.0):
                y = np.where(belongs, up * rate, np.nan)
                axes.plot(across * np.degrees(curve["tilt"]), y, zorder=3, label=label, **look)
                label = ""


def main() -> None:
    """Compute the maps, print how they agree with theory, and write the figure and, on request, the atlases."""
    parser = figure_parser(__doc__, "steady.png")
    parser.add_argument("--atlases", type=Path, help="folder for the atlases, one netCDF file per map")
    request = parser.parse_args()
    check_format(request.output)
    atlases = {name: compute(name) for name in MAPS}
    for name, atlas in atlases.items():
        print(f"{TITLES[name]}:\n  {describe_agreement(atlas)}")
        if request.atlases:
            sweep.save(atlas, request.atlases / f"steady-{name}.nc", overwrite=True)
    plots.save(figure(atlases), request.output)


if __name__ == "__main__":
    run_script(main)
