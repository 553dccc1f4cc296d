"""Figures of single motions: tilt, path, momentum and forces with linear theory, and a picture of the disk."""

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties

from sweep.figures.disk.disk_3d import Camera, Pose, draw_disk, draw_floor, draw_trace, frame_picture
from sweep.figures.drawing import sheet
from sweep.figures.texts import fitted
from sweep.model.disk.tables import PARAMETERS
from sweep.model.quantity import Array
from sweep.motion.request import TIME, TRAJECTORY
from sweep.motion.small_oscillations import LinearMotion, linear_motion

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

_MOTION: dict[str, Any] = {"color": "black", "linewidth": 1.1}
_THEORY: dict[str, Any] = {"color": "#c8380a", "linewidth": 1.3, "linestyle": (0, (4, 2))}
_OTHER: dict[str, Any] = {"color": "#2b6ca3", "linewidth": 1.1, "linestyle": (0, (1, 1))}

#: Linear theory is drawn until its tilt is this many times the largest tilt of the motion.
_SEEN = 1.15

#: A path that is this many times longer than wide is drawn with different scales on its axes.
_THIN = 8.0

#: Positions of the disk in a picture: their largest number, their least distance in radii, and the number of moments
#: from which they are chosen.
_SNAPSHOTS, _APART, _MOMENTS = 7, 1.7, 120

_FINE = 4000


def figure(dataset: "xr.Dataset") -> Figure:
    """Draw one motion: the disk in perspective, tilt, path and contact in time."""
    with sheet(7.2, 5.4) as drawn:
        grid = drawn.add_gridspec(2, 3, height_ratios=(1.25, 1.0))
        draw_picture(drawn.add_subplot(grid[0, :]), dataset)
        draw_tilt(drawn.add_subplot(grid[1, 0]), dataset)
        draw_path(drawn.add_subplot(grid[1, 1]), dataset)
        draw_contact(drawn.add_subplot(grid[1, 2]), dataset)
        title = fitted(dataset.attrs["title"], 10.0, 7.0)
        drawn.suptitle(title, fontsize=10.0, fontweight="bold", x=0.01, ha="left", parse_math=False)
    return drawn


def side_by_side(datasets: "Sequence[xr.Dataset]", draw: "Callable[[Axes, xr.Dataset], None]") -> Figure:
    """Draw motions by `draw_tilt`, `draw_path` or `draw_momentum`, one panel each under its title."""
    with sheet(3.5 * len(datasets), 3.0) as drawn:
        for axes, dataset in zip(drawn.subplots(1, len(datasets), squeeze=False).flat, datasets, strict=True):
            draw(axes, dataset)
            legend = axes.get_legend()
            assert legend is not None
            title = fitted(dataset.attrs["title"], 8.5, 3.2)
            legend.set_title(title, FontProperties(size=8.5, weight="bold"))
            legend.get_title().set_parse_math(False)
    return drawn


def draw_tilt(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the tilt in time, and the oscillation or growth of linear theory."""
    scale = TRAJECTORY["tilt"].plot_scale
    linear, times = _linear(dataset)
    axes.plot(dataset[TIME.name].values, dataset["tilt"].values * scale, label="motion", **_MOTION)
    axes.plot(times, linear.tilt * scale, label=f"linear theory, {_frequency(linear)}", **_THEORY)
    _label(axes, TIME.plot_label, TRAJECTORY["tilt"].plot_label)


def draw_path(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the path of the contact point from above, equal scales, and that of linear theory."""
    x, y = dataset["contact_x"].values, dataset["contact_y"].values
    axes.plot(x, y, label="contact point", **_MOTION)
    axes.plot(x[0], y[0], "o", color="black", markersize=3.5)
    linear, _ = _linear(dataset)
    axes.plot(linear.x, linear.y, label=f"linear theory{_circle(dataset)}", **_THEORY)
    (cx, cy), reach = _middle(x, y)
    spread = np.array([np.ptp(x), np.ptp(y)])
    if spread.max() < _THIN * spread.min():
        axes.set_xlim(cx - reach, cx + reach)
        axes.set_ylim(cy - reach, cy + reach)
        axes.set_aspect("equal")
    else:
        axes.text(
            0.97, 0.03, "scales differ", transform=axes.transAxes, ha="right", fontsize=7.0, style="italic"
        )
    _label(axes, TRAJECTORY["contact_x"].plot_label, TRAJECTORY["contact_y"].plot_label)


def draw_momentum(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the vertical momentum about the contact point, and its start plus the integral of the balance law."""
    times, momentum = dataset[TIME.name].values, dataset["vertical_momentum"].values
    integral = momentum - dataset["vertical_momentum_residual"].values
    axes.plot(times, momentum, label=r"$H\cdot e_3$: not constant", **_MOTION)
    law = rf"start $+\int {TRAJECTORY['vertical_momentum_rate'].symbol}\,dt$"
    axes.plot(times, integral, label=law, **_THEORY)
    tilt = dataset["tilt"].values
    roll_rate = float(dataset["roll_rate"][0])
    if roll_rate != 0.0:
        gain = float(dataset["mass"] * dataset["radius"] ** 2) * roll_rate
        label = r"to first order $m R^2\dot\phi_0\,(\theta-\theta_0)$"
        axes.plot(times, momentum[0] + gain * (tilt - tilt[0]), label=label, **_OTHER)
    _label(axes, TIME.plot_label, TRAJECTORY["vertical_momentum"].plot_label)


def draw_contact(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the normal force over the weight, the friction coefficient that is needed, and that of the contact."""
    times, weight = dataset[TIME.name].values, float(dataset["mass"] * dataset["gravity"])
    needed, friction = dataset["friction_needed"].values, float(dataset["friction"])
    axes.plot(times, dataset["normal_force"].values / weight, label="normal force / weight", **_MOTION)
    axes.plot(times, needed, label="friction needed", color="#2b6ca3", linewidth=1.1)
    axes.axhline(friction, label=f"friction {friction:g}", **_THEORY)
    lowest, highest = float(dataset["normal_force"].min()), float(dataset["normal_force"].max())
    axes.set_ylim(min(0.0, 1.1 * lowest / weight), 1.15 * min(max(1.0, highest / weight, friction), 3.0))
    _label(axes, TIME.plot_label, "contact (1)")


def draw_picture(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the disk in perspective at moments evenly spaced in time, with the trace of the contact point."""
    x, y = dataset["contact_x"].values, dataset["contact_y"].values
    radius = float(dataset["radius"])
    poses = _snapshots(dataset)
    (cx, cy), reach = _middle(x, y)
    centre = np.array([cx, cy, 0.4 * radius])
    camera = Camera.on(centre, reach + radius, _azimuth(x, y))
    draw_floor(axes, camera, centre, 1.6 * (reach + radius), 2.0 * radius)
    draw_trace(axes, camera, x, y)
    for i, pose in enumerate(poses):
        draw_disk(axes, camera, pose, 0.35 + 0.65 * (i + 1) / len(poses))
    ground = np.stack([x, y, np.zeros_like(x)], axis=-1)
    seen = camera.project(np.concatenate([ground, *(pose.rim() for pose in poses)]))
    margin = 0.04 * (seen.max(axis=0) - seen.min(axis=0)).max()
    frame_picture(axes, seen.min(axis=0) - margin, seen.max(axis=0) + margin)


def poses_at(dataset: "xr.Dataset", moments: Array) -> list[Pose]:
    """Return the positions of the disk at given times [s], shape (n,)."""
    times, radius = dataset[TIME.name].values, float(dataset["radius"])
    names = ("tilt", "heading", "roll_angle", "contact_x", "contact_y")
    columns = [np.interp(moments, times, dataset[name].values) for name in names]
    rows = np.stack(columns, axis=-1).tolist()
    return [Pose(tilt, heading, roll_angle, x, y, radius) for tilt, heading, roll_angle, x, y in rows]


def _azimuth(x: Array, y: Array) -> float:
    """Return the azimuth [deg] from which a long path runs across the picture and a little into it."""
    spread = np.cov(np.stack([x, y])) if np.ptp(x) + np.ptp(y) > 0.0 else np.eye(2)
    values, vectors = np.linalg.eigh(spread)
    if values[1] < 4.0 * max(values[0], 1e-12):
        return -55.0
    return math.degrees(math.atan2(vectors[1, 1], vectors[0, 1])) - 62.0


def _middle(x: Array, y: Array) -> tuple[tuple[float, float], float]:
    """Return the middle of a path, and half the side of the square around it with a margin."""
    reach = 0.55 * max(np.ptp(x), np.ptp(y), 1e-9)
    return (0.5 * float(x.min() + x.max()), 0.5 * float(y.min() + y.max())), float(reach)


def _linear(dataset: "xr.Dataset") -> tuple[LinearMotion, Array]:
    """Return the motion of linear theory while its tilt is near that of the motion (`_SEEN`), and its times."""
    times = np.linspace(0.0, float(dataset[TIME.name][-1]), _FINE)
    start = [dataset[name].values.flat[0] for name in PARAMETERS]
    linear = linear_motion(np.array(start), times)
    far = np.abs(linear.tilt) > _SEEN * np.abs(dataset["tilt"].values).max()
    upto = int(np.argmax(far)) if far.any() else _FINE
    shown = LinearMotion(linear.coefficient, linear.tilt[:upto], linear.x[:upto], linear.y[:upto])
    return shown, times[:upto]


def _circle(dataset: "xr.Dataset") -> str:
    """Return the radius of the circle of a steady motion, as part of a label; empty for any other motion."""
    precession_rate, roll_rate = (float(dataset[name][0]) for name in ("precession_rate", "roll_rate"))
    if precession_rate * roll_rate == 0.0 or np.ptp(dataset["tilt"].values) > 1e-6:
        return ""
    radius = float(f"{abs(float(dataset['radius']) * roll_rate / precession_rate):.5g}")
    return rf", $R|\dot\phi_0/\dot\psi_0| = ${TRAJECTORY['contact_x'].spell(radius)}"


def _snapshots(dataset: "xr.Dataset") -> list[Pose]:
    """Return positions of the disk that do not cover each other, in the order of time, with the final one."""
    kept: list[Pose] = []
    for pose in reversed(poses_at(dataset, np.linspace(0.0, float(dataset[TIME.name][-1]), _MOMENTS))):
        if all(math.hypot(pose.x - each.x, pose.y - each.y) >= _APART * pose.radius for each in kept):
            kept.append(pose)
    some = np.linspace(0, len(kept) - 1, min(len(kept), _SNAPSHOTS)).round().astype(int)
    return [kept[i] for i in some[::-1]]


def _frequency(linear: LinearMotion) -> str:
    root = math.sqrt(abs(linear.coefficient))
    return rf"$\sqrt{{{'-' if linear.coefficient < 0.0 else ''}k}} = {root:.3g}$ s$^{{-1}}$"


def _label(axes: "Axes", xlabel: str, ylabel: str) -> None:
    """Name the axes, and put the legend above them, where it covers nothing."""
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.legend(
        loc="lower left", alignment="left", bbox_to_anchor=(0.0, 1.0), frameon=False,
        borderaxespad=0.1, handlelength=1.8, labelspacing=0.15, fontsize=7.0,
    )  # fmt: skip
