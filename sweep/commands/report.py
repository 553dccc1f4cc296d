"""Text reports about an atlas: its description and the table of its boundary."""

import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sweep.atlas import row_edges, share
from sweep.atlas.boundary_rows import Row, boundary_rows, curve_rows
from sweep.atlas.cf_metadata import edge_names
from sweep.atlas.dataset import edge_status, found_edges, require, spec_of
from sweep.atlas.report_units import ReportedAs, reported_as
from sweep.errors import counted, plain_text
from sweep.model.bodies.tables import CALLED
from sweep.model.quantity import ERROR_GAUGE, UNKNOWN_ERROR, Input, Quantity, spell_size, with_unit
from sweep.motion.sampling import end_of, is_of_body, kind_of, losses_of, peaks_of, request_of
from sweep.motion.tables import TIME
from sweep.request.spec import SweepSpec

if TYPE_CHECKING:
    import xarray as xr


#: Largest number of characters in a line, and of lines, that are shown of an attribute.
_MOST_SHOWN, _MOST_LINES = 300, 30

#: Attributes about the origin of an atlas, and about its terms of use. Other programs may have removed some.
_MAKERS = ("title", "history", "source", "sweep_fingerprint")
_TERMS = ("license", "citation")


def describe(dataset: "xr.Dataset") -> str:
    """Describe an atlas: its grid, how it was made, how its cells ended, and where the boundary lies."""
    spec = spec_of(dataset)
    model = spec.model
    require(dataset, (model.peak, model.error_name))
    errors = list(_errors(dataset, spec))
    reported = reported_as(spec)
    known = {name: _cut(plain_text(dataset.attrs.get(name, "unknown"))) for name in _MAKERS}
    lines = [
        known["title"],
        "",
        f"{'starts' if spec.is_list else 'grid':<11} {_grid(spec)}",
        *_axis_lines(spec, reported),
        f"fixed       {_fixed(dataset, spec, reported)}",
        f"criterion   unstable if {spec.criterion.unstable_if(spec.model)}",
        f"method      {spec.method}, {_settings(spec)}",
        *_untimed(spec),
        "",
        *_counts(dataset, spec, "ending"),
        *_counts(dataset, spec, "stability"),
        *(_counts(dataset, spec, "label") if "label" in dataset else ()),
        *([f"unstable    {share.in_words(share.unstable_share(dataset))}"] if spec.is_list else []),
        "",
        f"{model.peak.replace('_', ' '):<11} {_range(dataset[model.peak], model.variables[model.peak])}",
        f"errors      {', '.join(errors)} ({'both ' * (len(errors) == 2)}estimated in every cell)",
        *_added_lines(dataset, spec),
        *_boundary_lines(dataset, spec, reported),
        "",
        "made        " + known["history"].replace("\n", "\n            "),
        f"by          {known['source']}; fingerprint {known['sweep_fingerprint'][:16]}",
        *(f"{name:<11} {_cut(str(dataset.attrs[name]))}" for name in _TERMS if name in dataset.attrs),
    ]
    return "\n".join(lines)


def _cut(text: str) -> str:
    """Shorten a text from a file to its first lines, and each line to its first characters."""
    lines = [line if len(line) <= _MOST_SHOWN else f"{line[:_MOST_SHOWN]} ..." for line in text.split("\n")]
    return "\n".join(lines if len(lines) <= _MOST_LINES else [*lines[:_MOST_LINES], "..."])


def boundary_table(dataset: "xr.Dataset", asked: Iterable[str] = ()) -> str:
    """Return the measured boundary next to the theoretical lines, one row per value of the other axes.

    If no axis is a control parameter, there are no such rows: the table has the points of the curves, if the boundary
    was refined. Values are reported in the words that made the atlas, or in the words `asked` for.
    """
    spec = spec_of(dataset)
    reported = reported_as(spec, asked)
    if spec.is_list:
        return "This atlas has no boundary: it is a list of starts, not a grid with rows. See eulerdisk info."
    groups = groupby(boundary_rows(dataset), lambda row: (row["along"], row["edge"]))
    if tables := ["\n".join(_edge_lines(spec, reported, *edge, rows)) for edge, rows in groups]:
        return "\n\n".join(tables)
    if "curve_point_count" in dataset:
        return "\n".join(_curve_lines(spec, reported, curve_rows(dataset)))
    if spec.boundary_width is None and len(spec.axes) > 1:
        return f"This atlas has no boundary in rows: {_no_control(spec)}. --refine WIDTH finds it as curves."
    return f"This atlas has no boundary: {_no_control(spec)}."


def _no_control(spec: SweepSpec) -> str:
    controls = spec.model.controls(spec.model.parameters)
    if len(controls) == 1:
        return f"{controls[0]} is not an axis"
    return f"neither {' nor '.join(controls)} is an axis"


def _head(quantity: Quantity) -> str:
    return f"{quantity.name} [{quantity.shown_units}]".removesuffix(" []")


def _edge_lines(
    spec: SweepSpec, reported: Mapping[str, ReportedAs], along: str, edge: str, rows: Iterable[Row]
) -> Iterator[str]:
    shown = reported[along]
    names, others = edge_names(shown.quantity.name, edge), [axis for axis in spec.axes if axis != along]
    heads = [_head(reported[name].quantity) for name in others]
    head = f"{names[0]} [{shown.quantity.units}]".removesuffix(" [1]")
    yield "  ".join([*heads, head, "+-", names[2], names[3], "row"])
    for row in rows:
        at = [
            f"{reported[name].value(row[name]) * reported[name].quantity.plot_scale:<{len(head)}.6g}"
            for name, head in zip(others, heads, strict=True)
        ]
        half = None if row["halfwidth"] is None else shown.width(row["halfwidth"])
        measured, *lines = (
            _number(None if row[name] is None else shown.value(row[name]), half)
            for name in ("measured", "predicted", "critical")
        )
        yield "  ".join([*at, measured, _number(half, half), *lines, row["status"].replace("_", " ")])


def _curve_lines(spec: SweepSpec, reported: Mapping[str, ReportedAs], rows: Iterable[Row]) -> Iterator[str]:
    heads = [(_head(reported[name].quantity), "+-") for name in spec.axes]
    yield "  ".join(["curve", *(word for pair in heads for word in pair)])
    for row in rows:
        words = [f"{row['curve']} {'closed' if row['closed'] else 'open'}"]
        for name in spec.axes:
            shown, scale = reported[name], reported[name].quantity.plot_scale
            half = shown.width(row[f"{name}_halfwidth"] or 0.0) * scale
            # a point on the grid is exact
            place = None if row[name] is None else shown.value(row[name]) * scale
            words.append(_number(place, half or 1e-12))
            words.append(f"{half:.1e}" if half else "0")
        yield "  ".join(words)


def _number(value: float | None, halfwidth: float | None) -> str:
    if value is None:
        return "-"
    if value == halfwidth:
        return f"{value:.6f}" if value >= 1e-4 else f"{value:.1e}"
    # as many digits as the bracket of the row allows
    digits = min(15, 2 - math.floor(math.log10(halfwidth))) if halfwidth and halfwidth < 1e-4 else 6
    return f"{value:.{digits}f}"


def _grid(spec: SweepSpec) -> str:
    if spec.starts:
        return f"{spec.size} of a table, SHA-256 {spec.starts.sha256[:16]}"
    if spec.is_list:
        part = f" of {spec.samples}" if spec.size < spec.samples else ""
        return f"{counted(spec.size, 'random start')}{part}, seed {spec.seed}"
    if len(spec.axes) < 2:
        return counted(spec.size, "cell") if spec.axes else "one cell"
    return f"{' x '.join(map(str, spec.shape))} = {counted(spec.size, 'cell')}"


def _axis_lines(spec: SweepSpec, reported: Mapping[str, ReportedAs]) -> Iterator[str]:
    for name in spec.listed:
        yield f"  {name:<17} {getattr(spec, name).in_words(spec.model.parameters[name])}"
    for name in () if spec.is_list else spec.axes:
        quantity, axis = spec.model.parameters[name], getattr(spec, name)
        shown = reported[name].quantity
        spacing = getattr(axis, "spacing", "listed")
        ends = _ends(shown, sorted(map(reported[name].value, axis.ends())))
        held = "" if shown is quantity else f"; {name} {_ends(quantity, axis.ends())}"
        yield f"  {shown.name:<17} {ends}, {counted(len(axis), 'value')}, {spacing}{held}"


def _ends(quantity: Quantity, ends: Iterable[float]) -> str:
    low, high = (f"{each * quantity.plot_scale:.6g}" for each in ends)
    return f"{low} to {high} {quantity.shown_units}".strip()


def _fixed(dataset: "xr.Dataset", spec: SweepSpec, reported: Mapping[str, ReportedAs]) -> str:
    parameters = spec.model.parameters
    fixed = [
        f"{reported[name].quantity.name} {reported[name].spell(float(dataset[name].values), 6)}"
        for name in spec.fixed
        if name in dataset and not _not_there(getattr(spec, name), parameters[name])
    ]
    return ", ".join(
        [*fixed, *(f"{name} {getattr(spec, name)} (computed per cell)" for name in spec.computed)]
    )


def _not_there(value: float | str, quantity: Input) -> bool:
    """Return whether a fixed value switches an effect off: a coefficient left at 0, a limit left at none."""
    has_sign = quantity.allows(np.array([-1.0]))[0]
    nothing = quantity.default in quantity.words or (quantity.default == 0.0 and not has_sign)
    return bool(nothing) and value == quantity.default


def _untimed(spec: SweepSpec) -> Iterator[str]:
    if spec.model.exact is not None and (unknown := spec.model.exact.untimed(spec)):
        yield f"            integrates nothing in time: it gives {unknown}, and no cell ends because time ran out"


def _settings(spec: SweepSpec) -> str:
    words = []
    for name, quantity in spec.model.settings.items():
        value = getattr(spec, name)
        if name == "tolerance":
            # too small to read in degrees
            value = with_unit(f"{value:g}", quantity.units)
        words.append(f"{name} {value if isinstance(value, str) else quantity.spell(value, 6)}")
    words += [
        f"{name} {getattr(spec, name)}"
        for name, word in spec.model.options.items()
        if word.decides and getattr(spec, name) != word.default
    ]
    return ", ".join(words)


def _counts(dataset: "xr.Dataset", spec: SweepSpec, name: str) -> Iterator[str]:
    yield f"{name:<12}{_flag_counts(dataset[name], spec.model.variables[name])}"


def _flag_counts(values: "xr.DataArray | xr.Variable", quantity: Quantity) -> str:
    found = [(int((values.values == code).sum()), word) for code, word in (quantity.flags or {}).items()]
    return ", ".join(f"{count} {word.replace('_', ' ')}" for count, word in found if count)


def _range(values: "xr.DataArray | xr.Variable", quantity: Quantity) -> str:
    known = values.values[np.isfinite(values.values)] * quantity.plot_scale
    return (
        f"{known.min():.6g} to {known.max():.6g} {quantity.shown_units}" if known.size else "no cell has one"
    )


def _errors(dataset: "xr.Dataset", spec: SweepSpec) -> Iterator[str]:
    error = spec.model.variables[spec.model.error_name]
    coordinate = spec.model.coordinate.replace("_", " ")
    what = f"extreme {coordinate}s" if coordinate else spec.model.peak.replace("_", " ")
    yield f"{what} within {_most(dataset[error.name], error)}"
    for name, quantity in spec.model.variables.items():
        if quantity.tolerance == ERROR_GAUGE and name != error.name and name in dataset:
            yield f"{name.replace('_', ' ')} at most {_most(dataset[name], quantity)}"


def _added_lines(dataset: "xr.Dataset", spec: SweepSpec) -> Iterator[str]:
    """Yield a line for each variable that an option has added to the cells, as contact=yes does."""
    for name, quantity in spec.model.cell_variables(spec).items():
        if name not in spec.model.variables and name in dataset:
            extent = (_flag_counts if quantity.flags else _range)(dataset[name], quantity).strip()
            yield f"added       {quantity.long_name}: {extent}"


def _most(values: "xr.DataArray | xr.Variable", quantity: Quantity) -> str:
    stated = values.values[np.isfinite(values.values)]
    known = stated[stated < UNKNOWN_ERROR]
    most = "-" if not known.size else spell_size(float(known.max()), quantity.units) if known.any() else "0"
    undecided = stated.size - known.size
    return f"{most} ({counted(undecided, 'cell')} undecided)" if undecided else most


def _boundary_lines(
    dataset: "xr.Dataset", spec: SweepSpec, reported: Mapping[str, ReportedAs]
) -> Iterator[str]:
    for axis, edge in found_edges(dataset, spec):
        measured, halfwidth_name, _, _ = edge_names(axis, edge)
        found = dataset[measured].values
        count = int(np.isfinite(found).sum())
        side = "below" if edge == "lower" else "above"
        shown, name = reported[axis], reported[axis].quantity.name
        lines = row_edges.in_words(edge_status(dataset, axis, edge), name)
        if count:
            low, high = (shown.value(float(each(found))) for each in (np.nanmin, np.nanmax))
            half = shown.width(float(np.nanmax(dataset[halfwidth_name].values)))
            lines.insert(
                0,
                f"stable {side} {name} {with_unit(f'{low:.6g} to {high:.6g}', shown.quantity.units)}, "
                f"+- {half:.2g} at most, in {counted(count, 'row', found.size)} along {name}",
            )
        else:
            lines[0] += f", along {name} (stable {side})"
        first, *others = lines
        yield f"boundary    {first}"
        yield from (f"            {line}" for line in others)
    if "curve_point_count" in dataset:
        counts, closed = dataset["curve_point_count"].values, int(dataset["curve_closed"].values.sum())
        points = counted(int(counts.sum()), "point")
        yield (
            f"curves      {counts.size} of the boundary through {points}, {closed} closed, in planes of "
            f"{' and '.join(spec.axes[-2:])}; bisected to {spec.boundary_width:g} in SI"
        )


def describe_motion(path: Path) -> str:
    """Describe the file of a motion: title, start, disk or system, length and peaks.

    Raises
    ------
    RequestError
        If a variable is missing.
    """
    from sweep.files.reading import opened_motion

    with opened_motion(path) as file:
        kind = kind_of(file)
        start_names = tuple(name for name in kind.inputs if name in kind.variables)
        require(file, (*start_names, *kind.fixed, TIME.name, kind.ending_time, "ending"), str(path))
        made = {name: _cut(plain_text(file.attrs.get(name, "unknown"))) for name in _MAKERS}
        start = [
            f"{name} {kind.variables[name].spell(float(file[name].values[0]), 6)}" for name in start_names
        ]
        values = {name: float(file[name].values) for name in kind.fixed}
        # an absent loss, and friction without a limit, are not worth a word
        present = {name: value for name, value in values.items() if value != 0.0 and np.isfinite(value)}
        disk = [f"{name} {kind.inputs[name].spell(value, 6)}" for name, value in present.items()]
        if is_of_body(file):
            disk.insert(0, CALLED[request_of(file).body])
        times, ending, lost = file[TIME.name].values, end_of(file), losses_of(file)
        peaks = [f"{name:<11} {value}" for name, value in peaks_of(file)]
    ending = f", {ending}" if ending else ""
    losses = [f"losses      {lost}"] if lost else []
    lines = [
        "This file contains one motion in time, written by eulerdisk simulate; it is not a stability atlas.",
        "",
        made["title"],
        f"start       {', '.join(start)}",
        *([f"{kind.called:<11} {', '.join(disk)}"] if disk else []),
        f"time        {counted(times.size, 'sample')} from {times[0]:g} to {kind.time.spell(times[-1], 6)}{ending}",
        *peaks,
        *losses,
        f"made        {made['history']}",
        f"by          {made['source']}",
    ]
    return "\n".join(lines)
