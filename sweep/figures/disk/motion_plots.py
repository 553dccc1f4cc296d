"""Figures of single motions: tilt, path, momentum and forces, with linear theory, and a picture of the disk.

Times at which rolling without slipping is impossible (`sweep.motion.contact`) are shaded.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from sweep.errors import plain_text
from sweep.figures.disk.body_3d import poses_of_body
from sweep.figures.disk.captions import caption, length_unit, nice_length, spell_length
from sweep.figures.disk.disk_3d import (
    Camera,
    Placed,
    Pose,
    azimuth_at_start,
    draw_floor,
    draw_trace,
    frame_picture,
)
from sweep.figures.panels_in_time import (
    MOTION,
    SHADE,
    label_axes,
    label_times,
    thin_panels,
    widened,
    write_head,
)
from sweep.figures.sheet import sheet
from sweep.figures.texts import number
from sweep.model.bodies.shape import on_end
from sweep.model.quantity import Array
from sweep.motion.contact import RollingLimit, rolling_limit
from sweep.motion.sampling import closely_sampled, is_of_body, kind_of, request_of
from sweep.motion.tables import TIME, TRAJECTORY
from sweep.motion.theory import LinearMotion, linear_motion, rolling_body

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

_THEORY: dict[str, Any] = {"color": "#c8380a", "linewidth": 1.3, "linestyle": (0, (4, 2))}
_OTHER: dict[str, Any] = {"color": "#2b6ca3", "linewidth": 1.1, "linestyle": (0, (1, 1))}

#: Linear theory is drawn until its tilt is this many times the largest tilt of the motion.
_SEEN = 1.15

#: Ratio of length to width beyond which a path is drawn with different scales on its axes.
_THIN = 8.0

#: Positions of the disk in a picture: their largest number, the least distance of their centres in radii, the same for
#: a disk that falls in place, and the number of moments from which positions are chosen.
_SNAPSHOTS, _APART, _FALLING, _MOMENTS = 7, 1.7, 0.3, 240

#: Largest span of the path of a contact point that is said to stay in place, and of a disk that falls in place [radii].
STAYS, _NEAR = 0.02, 1.0

#: Largest width [radii] of a path that counts as straight; such a path is shown on the scale of the disk across.
_STRAIGHT = 1e-6

#: Largest side of the squares of the floor, divided by half the width of the view.
_SQUARE = 0.2

#: Largest needed friction coefficient that stays in view, relative to the other numbers of its panel; the second number
#: is for one that grows without bound, where the disk lifts off.
_IN_VIEW, _UNBOUNDED = 3.0, 1.5

#: Shading of times at which rolling is impossible.
_BEYOND: dict[str, Any] = {"color": "0.55", "linewidth": 1.0, "linestyle": (0, (1, 1))}

_FINE = 4000


def figure(dataset: "xr.Dataset") -> Figure:
    """Draw one motion: the disk in perspective, and tilt, path and contact over time.

    Parameters
    ----------
    dataset : xarray.Dataset
        A motion, as `sweep.simulate` returns it, or an interval of it. If its samples are too far apart to draw, the
        motion is computed again with closer ones.

    Returns
    -------
    matplotlib.figure.Figure
        A figure on an Agg canvas, not registered with pyplot.

    Raises
    ------
    RequestError
        If the dataset is not a motion.
    """
    motion = closely_sampled(dataset)
    with sheet(7.2, 5.6) as drawn:
        grid = drawn.add_gridspec(2, 3, height_ratios=(1.25, 1.0))
        draw_picture(drawn.add_subplot(grid[0, :]), motion)
        draw_panels(drawn, [grid[1, i] for i in range(3)], (draw_tilt, draw_path, draw_contact), motion)
    return drawn


def draw_panels(
    drawn: Figure,
    places: Iterable[Any],
    draws: "Iterable[Callable[[Axes, xr.Dataset], None]]",
    motion: "xr.Dataset",
) -> None:
    """Draw the panels of a motion, each in its place of a grid, below a title and a caption."""
    panels = []
    for place, draw in zip(places, draws, strict=True):
        panels.append(drawn.add_subplot(place))
        draw(panels[-1], motion)
    write_head(drawn, plain_text(motion.attrs.get("title", "")), caption(motion))
    thin_panels(panels)


def draw_tilt(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the tilt over time, and the oscillation or growth according to linear theory."""
    scale = TRAJECTORY["tilt"].plot_scale
    linear, times = _linear(dataset)
    axes.plot(dataset[TIME.name].values, dataset["tilt"].values * scale, label="motion", **MOTION)
    if times.size:
        axes.plot(times, linear.tilt * scale, label=f"linear theory, {_frequency(linear)}", **_THEORY)
    _shade(axes, dataset)
    label_times(axes, dataset, TRAJECTORY["tilt"].plot_label)


def draw_path(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the path of the contact point from above, with equal scales, and the path of linear theory."""
    x, y = dataset["contact_x"].values, dataset["contact_y"].values
    radius = float(dataset["radius"])
    # the unit follows from the disk, so that the same disk always has the same unit
    unit, factor = length_unit(radius)
    linear, known = _linear(dataset)
    rolls = dataset[TIME.name].values <= rolling_limit(dataset).time
    axes.plot(factor * x[rolls], factor * y[rolls], label="contact point", **MOTION)
    if not rolls.all():
        axes.plot(factor * x[~rolls], factor * y[~rolls], label="where it could not roll", **_BEYOND)
    axes.plot(factor * x[0], factor * y[0], "o", color="black", markersize=3.5)
    if known.size:
        axes.plot(factor * linear.x, factor * linear.y, label=f"linear theory{_circle(dataset)}", **_THEORY)
    (cx, cy), reach = _middle(x, y)
    spread = np.array([np.ptp(x), np.ptp(y)])
    stays = spread.max() <= STAYS * radius
    if stays or spread.max() < _THIN * spread.min():
        # show a point that stays in place on the scale of the disk
        reach = max(reach, radius if stays else 0.0)
        axes.set_xlim(factor * (cx - reach), factor * (cx + reach))
        axes.set_ylim(factor * (cy - reach), factor * (cy + reach))
        axes.set_aspect("equal")
    elif spread.min() <= _STRAIGHT * radius:
        narrow, middle = (axes.set_xlim, cx) if spread[0] < spread[1] else (axes.set_ylim, cy)
        narrow(factor * (middle - radius), factor * (middle + radius))
    note = "stays in place" if stays else "" if axes.get_aspect() == 1.0 else "scales differ"
    axes.text(0.97, 0.03, note, transform=axes.transAxes, ha="right", fontsize=7.0, style="italic")
    label_axes(axes, f"contact x ({unit})", f"contact y ({unit})")


def draw_momentum(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the vertical momentum about the contact point, and its start plus the integral of the balance law."""
    times, momentum = dataset[TIME.name].values, dataset["vertical_momentum"].values
    integral = momentum - dataset["vertical_momentum_residual"].values
    axes.plot(times, momentum, label=r"$H\cdot e_3$: not constant", **MOTION)
    law = r"start $+\int m R^2\dot\phi\,\dot\theta\cos\theta\,dt$"
    axes.plot(times, integral, label=law, **_THEORY)
    tilt = dataset["tilt"].values
    roll_rate = float(dataset["roll_rate"][0])
    if roll_rate != 0.0:
        gain = float(dataset["mass"] * dataset["radius"] ** 2) * roll_rate
        label = r"to first order $m R^2\dot\phi_0\,(\theta-\theta_0)$"
        axes.plot(times, momentum[0] + gain * (tilt - tilt[0]), label=label, **_OTHER)
    _shade(axes, dataset)
    label_times(axes, dataset, TRAJECTORY["vertical_momentum"].plot_label)


def draw_contact(axes: "Axes", dataset: "xr.Dataset") -> None:
    """Draw the normal force / weight, the needed friction coefficient, and the friction coefficient of the contact."""
    times, weight = dataset[TIME.name].values, float(dataset["mass"] * dataset["gravity"])
    needed, friction = dataset["friction_needed"].values, float(dataset["friction"])
    normal = dataset["normal_force"].values / weight
    limit = rolling_limit(dataset)
    axes.plot(times, normal, label="normal force / weight", **MOTION)
    unbounded = math.isinf(limit.needed)
    most = "without bound" if unbounded else f"up to {limit.needed:.3g}"
    axes.plot(times, needed, label=f"friction needed, {most}", color="#2b6ca3", linewidth=1.1)
    axes.axhline(friction, label=f"friction {number(friction)}", **_THEORY)
    for name, moment, style in (("slips", limit.slips, "-"), ("lifts off", limit.lifts_off, ":")):
        if moment is not None:
            label = f"{name} {limit.when(moment, times[0])}"
            axes.axvline(moment, color="0.4", linewidth=0.8, linestyle=style, label=label)
    _shade(axes, dataset, limit)
    highest = _highest(normal, needed, friction, _UNBOUNDED if unbounded else _IN_VIEW)
    axes.set_ylim(min(0.0, 1.1 * float(normal.min())), 1.08 * highest)
    label_times(axes, dataset, "contact (1)")


def _highest(normal: Array, needed: Array, friction: float, times: float) -> float:
    """Return the largest number in view: the needed coefficient, limited by the other numbers and by its median."""
    others = max(1.0, min(float(normal.max()), _IN_VIEW), friction)
    known = needed[np.isfinite(needed)]
    if not known.size:
        return others
    return max(others, min(float(known.max()), times * max(others, float(np.median(known)))))


def draw_picture(axes: "Axes", dataset: "xr.Dataset", moments: Array | None = None) -> None:
    """Draw the disk in perspective, with the trace of the contact point.

    Draws it at the given moments [s], in increasing order; by default at moments evenly spaced in time whose disks do
    not cover each other.
    """
    x, y, times = (dataset[name].values for name in ("contact_x", "contact_y", TIME.name))
    limit = rolling_limit(dataset).time
    if moments is None:
        poses = _snapshots(dataset)
    else:
        poses = list(zip(moments.tolist(), poses_at(dataset, moments), strict=True))
    radius = poses[0][1].radius
    (cx, cy), reach = _middle(x, y)
    centre = np.array([cx, cy, 0.4 * radius])
    camera = Camera.on(centre, reach + radius, azimuth_at_start(dataset))
    spacing = nice_length(_SQUARE * (reach + radius))
    draw_floor(axes, camera, centre, 1.6 * (reach + radius), spacing)
    rolls = times <= limit
    draw_trace(axes, camera, x[rolls], y[rolls])
    draw_trace(axes, camera, x[~rolls], y[~rolls], **_BEYOND)
    for i, (moment, pose) in enumerate(poses):
        pose.draw(axes, camera, 0.35 + 0.65 * (i + 1) / len(poses), believed=moment <= limit)
    ground = np.stack([x, y, np.zeros_like(x)], axis=-1)
    seen = camera.project(np.concatenate([ground, *(pose.rim() for _, pose in poses)]))
    margin = 0.04 * (seen.max(axis=0) - seen.min(axis=0)).max()
    frame_picture(axes, seen.min(axis=0) - margin, seen.max(axis=0) + margin)
    axes.text(
        1.0, -0.01, f"squares of {spell_length(spacing)}",
        transform=axes.transAxes, ha="right", va="top", fontsize=7.0,
    )  # fmt: skip


def poses_at(dataset: "xr.Dataset", moments: Array) -> Sequence[Placed]:
    """Return the positions of the disk, or of the body, at given times [s], shape (n,)."""
    if is_of_body(dataset):
        return poses_of_body(dataset, moments)
    times, radius = dataset[TIME.name].values, float(dataset["radius"])
    names = ("tilt", "heading", "roll_angle", "contact_x", "contact_y")
    columns = [np.interp(moments, times, dataset[name].values) for name in names]
    rows = np.stack(columns, axis=-1).tolist()
    return [Pose(tilt, heading, roll_angle, x, y, radius) for tilt, heading, roll_angle, x, y in rows]


def _middle(x: Array, y: Array) -> tuple[tuple[float, float], float]:
    """Return the centre of a path, and half the side of the square around it including a margin."""
    reach = 0.55 * max(np.ptp(x), np.ptp(y), 1e-9)
    return (0.5 * float(x.min() + x.max()), 0.5 * float(y.min() + y.max())), float(reach)


def _linear(dataset: "xr.Dataset") -> tuple[LinearMotion, Array]:
    """Return the motion of linear theory while its tilt is near the tilt of the motion (`_SEEN`), and its times.

    Empty for a body that spins on its end: its tilt is not a small angle there.
    """
    times = np.linspace(0.0, float(dataset[TIME.name][-1]), _FINE)
    start = {name: dataset[name].values.flat[0] for name in kind_of(dataset).model.parameters}
    linear = linear_motion(start, rolling_body(request_of(dataset), start), times)
    far = np.abs(linear.tilt) > _SEEN * np.abs(dataset["tilt"].values).max()
    upto = int(np.argmax(far)) if far.any() else _FINE
    if is_of_body(dataset) and on_end(request_of(dataset), start):
        upto = 0
    shown = LinearMotion(linear.coefficient, linear.tilt[:upto], linear.x[:upto], linear.y[:upto])
    return shown, times[:upto]


def _circle(dataset: "xr.Dataset") -> str:
    """Return the radius of the circle of a steady motion, as part of a label; empty for other motions."""
    precession_rate, roll_rate = (float(dataset[name][0]) for name in ("precession_rate", "roll_rate"))
    if precession_rate * roll_rate == 0.0 or np.ptp(dataset["tilt"].values) > 1e-6:
        return ""
    if is_of_body(dataset):
        # the contact point is not at the outer radius
        x, y = dataset["contact_x"].values, dataset["contact_y"].values
        way = float(np.hypot(np.diff(x), np.diff(y)).sum())
        turned = abs(float(dataset["heading"][-1] - dataset["heading"][0]))
        return f", radius {TRAJECTORY['contact_x'].spell(float(f'{way / turned:.3g}'))}"
    radius = float(f"{abs(float(dataset['radius']) * roll_rate / precession_rate):.5g}")
    return rf", $R|\dot\phi_0/\dot\psi_0| = ${TRAJECTORY['contact_x'].spell(radius)}"


def _snapshots(dataset: "xr.Dataset") -> list[tuple[float, Placed]]:
    """Return times [s] and positions of the disk that do not cover each other, in order, including the last."""
    times = dataset[TIME.name].values
    moments = np.linspace(times[0], times[-1], _MOMENTS)
    every = list(zip(moments.tolist(), poses_at(dataset, moments), strict=True))
    path = np.array([(pose.x, pose.y) for _, pose in every])
    radius = every[0][1].radius
    # if a disk falls in place, its centre moves by less than the disk covers
    apart = (_FALLING if np.ptp(path, axis=0).max() <= _NEAR * radius else _APART) * radius
    kept: list[tuple[float, Placed]] = []
    for moment, pose in reversed(every):
        if all(np.linalg.norm(pose.centre() - each.centre()) >= apart for _, each in kept):
            kept.append((moment, pose))
    some = np.linspace(0, len(kept) - 1, min(len(kept), _SNAPSHOTS)).round().astype(int)
    return [kept[i] for i in some[::-1]]


def _shade(axes: "Axes", dataset: "xr.Dataset", limit: RollingLimit | None = None) -> None:
    """Shade the times at which rolling is impossible."""
    start = (limit or rolling_limit(dataset)).time
    times = dataset[TIME.name].values
    if start <= times[-1]:
        axes.axvspan(start, widened(times)[1], color=SHADE, linewidth=0.0, zorder=0)


def _frequency(linear: LinearMotion) -> str:
    root = math.sqrt(abs(linear.coefficient))
    return rf"$\sqrt{{{'-' if linear.coefficient < 0.0 else ''}k}} = {root:.3g}$ s$^{{-1}}$"
