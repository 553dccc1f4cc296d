"""An atlas in words and tables, for a person to read."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from sweep.atlas.dataset import require, spec_of
from sweep.checks.audit import Findings
from sweep.request.spec import SweepSpec
from sweep.schema import PARAMETERS, SETTINGS, VARIABLES

if TYPE_CHECKING:
    import xarray as xr


#: Attributes of an atlas that other programs may have taken away.
_MAKERS = ("title", "history", "source", "sweep_fingerprint")


def describe(dataset: "xr.Dataset") -> str:
    """Return what is in an atlas: its grid, how it was made, how the cells ended, and where the boundary lies."""
    spec = spec_of(dataset)
    require(dataset, ("peak_tilt", "tilt_error", "energy_drift"))
    known = {name: str(dataset.attrs.get(name, "unknown")) for name in _MAKERS}
    lines = [
        known["title"],
        "",
        f"grid        {_grid(spec)}",
        *_axis_lines(spec),
        f"fixed       {_fixed(dataset, spec)}",
        f"criterion   unstable if the tilt leaves its steady value by {_criterion(spec)}, or the disk falls",
        f"method      {spec.method}, {_settings(spec)}",
        "",
        *_counts(dataset, "ending"),
        *_counts(dataset, "stability"),
        "",
        f"peak tilt   {_range(dataset['peak_tilt'], 'deg')}",
        f"errors      extreme tilts within {_most(dataset['tilt_error'])} rad, "
        f"energy drift at most {_most(dataset['energy_drift'])} (both estimated in every cell)",
        *_boundary_lines(dataset, spec),
        "",
        "made        " + known["history"].replace("\n", "\n            "),
        f"by          {known['source']}; fingerprint {known['sweep_fingerprint'][:16]}",
    ]
    return "\n".join(lines)


def boundary_table(dataset: "xr.Dataset") -> str:
    """Return the measured boundary beside the lines of theory, one row per value of the other axes.

    Without a rate among the axes there are no such rows: then the points of its curves, if it was refined.
    """
    spec = spec_of(dataset)
    tables = [
        "\n".join(_edge_rows(dataset, spec, lower + axis)) for axis, lower in _found_edges(dataset, spec)
    ]
    if tables:
        return "\n\n".join(tables)
    if "curve_point_count" in dataset:
        return "\n".join(_curve_rows(dataset, spec))
    if spec.boundary_width is None and len(spec.axes) > 1:
        return "This atlas has no boundary of rates: no rate is among its axes. --refine WIDTH finds it as curves."
    return "This atlas has no boundary: no rate is among its axes."


def critical_table(datasets: Sequence["xr.Dataset"]) -> str:
    """Return rate^2 R/g at the boundary, at the smallest tilt that has one: measured, predicted, and the limit.

    The limit is that of vanishing perturbation and vanishing tilt: 1/[2(1+alpha)] for the roll rate, 2/(2+alpha) for
    the precession rate.
    """
    rows = [["atlas", "at tilt", "rate^2 R/g of", "measured", "predicted by", "", "analytic limit"]]
    for dataset in datasets:
        spec = spec_of(dataset)
        for axis, lower in _found_edges(dataset, spec):
            if not lower:
                rows += _critical_rows(dataset, spec, axis)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def audit_text(found: Findings) -> str:
    """Return what an audit found: counts, the distribution of the difference, and the cells to look at."""
    counted = ", ".join(f"{count} {word.replace('_', ' ')}" for word, count in found.counts.items() if count)
    lines = [
        f"cells        {counted}",
        f"tilts        the extremes differ from the exact ones by {_spread(found.tilt)} rad",
        f"periods      differ from the exact ones by {_spread(found.period)} of them; "
        f"largest {found.period_share:.2g} of what the tolerance allows",
        f"tolerance    {found.tolerance:.1e} rad",
    ]
    head = "wrong" if found.disagreeing else "worst cell"
    lines += [f"{head:<12} {_cell(place)}, {flag.replace('_', ' ')}" for flag, place in found.named]
    if found.disagreeing > len(found.named):
        lines.append(f"             and {found.disagreeing - len(found.named)} more")
    if found.method == "exact":
        lines.append(
            "note         made by the reduction itself: only the file has been checked, not the method"
        )
    return "\n".join([*lines, audit_line(found)])


def audit_line(found: Findings) -> str:
    """Return the outcome of an audit in one line."""
    if found.passed:
        return (
            f"verified: {found.agreeing} of {found.cells} cells within {found.tolerance:g} rad, "
            f"largest difference {found.tilt[2]:.1e} rad"
        )
    return (
        f"NOT verified: {found.disagreeing} of {found.cells} cells disagree, {found.missing} are not computed"
    )


def _critical_rows(dataset: "xr.Dataset", spec: SweepSpec, axis: str) -> Iterator[list[str]]:
    measured = dataset[f"boundary_{axis}"]
    if "tilt" not in measured.dims or measured.ndim != 1:
        return
    known = np.flatnonzero(np.isfinite(measured.values))
    if not known.size:
        return
    row = {"tilt": int(known[0])}
    names = (f"boundary_{axis}", f"boundary_{axis}_halfwidth", f"predicted_{axis}")
    rate, halfwidth, predicted = (float(dataset[name][row]) for name in names)
    unit_squared = float(dataset["radius"]) / float(dataset["gravity"])
    alpha = float(dataset["alpha"])
    limit = 1.0 / (2.0 * (1.0 + alpha)) if axis == "roll_rate" else 2.0 / (2.0 + alpha)
    yield [
        dataset.attrs["title"].split(":")[0],
        f"{np.degrees(float(dataset['tilt'][row])):.3g} deg",
        axis,
        f"{rate**2 * unit_squared:.5f} +- {2.0 * rate * halfwidth * unit_squared:.5f}",
        str(spec.criterion),
        f"{predicted**2 * unit_squared:.5f}",
        f"{limit:.5f}",
    ]


def _edge_rows(dataset: "xr.Dataset", spec: SweepSpec, edge: str) -> Iterator[str]:
    names = [f"boundary_{edge}", f"boundary_{edge}_halfwidth", f"predicted_{edge}", f"critical_{edge}"]
    others = dataset[names[0]].dims
    units = dataset[names[0]].attrs["units"]
    heads = [f"{name} [{_shown_units(PARAMETERS[str(name)])}]".removesuffix(" []") for name in others]
    yield "  ".join([*heads, f"{names[0]} [{units}]", "+-", names[2], names[3]])
    stacked = [dataset[name].values.reshape(-1) for name in names]
    places = np.indices(dataset[names[0]].shape).reshape(len(others), dataset[names[0]].size).T
    for place, *values in zip(places, *stacked, strict=True):
        at = [
            f"{dataset[name].values[i] * PARAMETERS[str(name)].plot_scale:<{len(head)}.6g}"
            for name, i, head in zip(others, place, heads, strict=True)
        ]
        yield "  ".join([*at, *(_number(value, values[1]) for value in values)])


def _curve_rows(dataset: "xr.Dataset", spec: SweepSpec) -> Iterator[str]:
    heads = [f"{name} [{_shown_units(PARAMETERS[name])}]".removesuffix(" []") for name in spec.axes]
    yield "  ".join(["curve", *(word for head in heads for word in (head, "+-"))])
    closed = dataset["curve_closed"].values
    columns = []
    for name in spec.axes:
        scale = PARAMETERS[name].plot_scale
        columns += [dataset[f"curve_{name}{end}"].values * scale for end in ("", "_halfwidth")]
    numbers = np.repeat(np.arange(closed.size), dataset["curve_point_count"].values)
    for number, *values in zip(numbers.tolist(), *(column.tolist() for column in columns), strict=True):
        words = [
            word
            for value, half in zip(values[::2], values[1::2], strict=True)
            # on the grid a place is known to the last bit
            for word in (_number(value, half or 1e-12), f"{half:.1e}" if half else "0")
        ]
        yield "  ".join([f"{number + 1} {'closed' if closed[number] else 'open'}", *words])


def _number(value: float, halfwidth: float) -> str:
    if not np.isfinite(value):
        return "-"
    if value == halfwidth:
        return f"{value:.6f}" if value >= 1e-4 else f"{value:.1e}"
    # as many digits as the bracket of the row allows
    digits = 6 if not 0.0 < halfwidth < 1e-4 else min(15, 2 - math.floor(math.log10(halfwidth)))
    return f"{value:.{digits}f}"


def _found_edges(dataset: "xr.Dataset", spec: SweepSpec) -> Iterator[tuple[str, str]]:
    for axis in spec.axes:
        for lower in ("", "lower_"):
            if f"boundary_{lower}{axis}" in dataset:
                yield axis, lower


def _grid(spec: SweepSpec) -> str:
    if len(spec.axes) < 2:
        return f"{spec.size} cells" if spec.axes else "one cell"
    return f"{' x '.join(map(str, spec.shape))} = {spec.size} cells"


def _axis_lines(spec: SweepSpec) -> Iterator[str]:
    for name in spec.axes:
        quantity, axis = PARAMETERS[name], getattr(spec, name)
        low, high = axis.ends() * quantity.plot_scale
        spacing = getattr(axis, "spacing", "listed")
        ends = f"{low:.6g} to {high:.6g} {_shown_units(quantity)}".strip()
        yield f"  {name:<17} {ends}, {len(axis)} values, {spacing}"


def _fixed(dataset: "xr.Dataset", spec: SweepSpec) -> str:
    parts = []
    for name, quantity in PARAMETERS.items():
        if name not in spec.axes and name in dataset.coords:
            parts.append(
                f"{name} {float(dataset[name]) * quantity.plot_scale:.6g} {_shown_units(quantity)}".strip()
            )
    return ", ".join(parts) + (f", {spec.computed_rate} steady (computed per cell)" if spec.circling else "")


def _criterion(spec: SweepSpec) -> str:
    if spec.criterion.kind == "departure":
        return f"more than {np.degrees(spec.criterion.limit):.6g} deg"
    return f"more than {spec.criterion.limit:.6g} times the perturbation"


def _settings(spec: SweepSpec) -> str:
    parts = []
    for name, quantity in SETTINGS.items():
        value = getattr(spec, name)
        if isinstance(value, str):
            text = value
        else:
            # a tolerance is too small to be read in degrees
            text = f"{value:g} {quantity.units}" if name == "tolerance" else quantity.spell(value, 6)
        parts.append(f"{name} {text}")
    return ", ".join(parts)


def _counts(dataset: "xr.Dataset", name: str) -> Iterator[str]:
    codes = dataset[name].values
    flags = VARIABLES[name].flags or {}
    found = [(int((codes == code).sum()), word) for code, word in flags.items()]
    yield f"{name:<12}" + ", ".join(f"{count} {word.replace('_', ' ')}" for count, word in found if count)


def _range(values: "xr.DataArray", units: str) -> str:
    known = values.values[np.isfinite(values.values)]
    if not known.size:
        return "no cell has one"
    low, high = np.degrees([known.min(), known.max()])
    return f"{low:.6g} to {high:.6g} {units}"


def _most(values: "xr.DataArray") -> str:
    known = values.values[np.isfinite(values.values)]
    return f"{known.max():.1e}" if known.size else "-"


def _boundary_lines(dataset: "xr.Dataset", spec: SweepSpec) -> Iterator[str]:
    for axis, lower in _found_edges(dataset, spec):
        rate = dataset[f"boundary_{lower}{axis}"].values
        halfwidth: Any = dataset[f"boundary_{lower}{axis}_halfwidth"].values
        count = int(np.isfinite(rate).sum())
        side = "below" if lower else "above"
        if count:
            yield (
                f"boundary    stable {side} {axis} {np.nanmin(rate):.6g} to {np.nanmax(rate):.6g} rad s-1, "
                f"+- {np.nanmax(halfwidth):.2g} at most, in {count} of {rate.size} rows"
            )
        else:
            yield f"boundary    no change of verdict along {axis} ({side})"
    if "curve_point_count" in dataset:
        counts, closed = dataset["curve_point_count"].values, int(dataset["curve_closed"].values.sum())
        yield (
            f"curves      {counts.size} of the boundary through {counts.sum()} points, {closed} closed, in planes of "
            f"{' and '.join(spec.axes[-2:])}; bisected to {spec.boundary_width:g} in SI"
        )


def _spread(distribution: tuple[float, float, float]) -> str:
    median, high, most = distribution
    return f"{median:.1e} (median), {high:.1e} (99 %), {most:.1e} (largest)"


def _cell(place: Mapping[str, float]) -> str:
    shown = (
        f"{name} {value * PARAMETERS[name].plot_scale:.10g} {_shown_units(PARAMETERS[name])}".strip()
        for name, value in place.items()
    )
    return ", ".join(shown) or "the one cell"


def _shown_units(quantity: Any) -> str:
    return "deg" if quantity.units == "rad" else "" if quantity.units == "1" else str(quantity.units)
