"""An atlas or a motion at a glance: a few lines on a terminal, or a table and a small map in a notebook."""

import html
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.cf_metadata import EDGES, edge_names
from sweep.atlas.dataset import spec_named
from sweep.atlas.selection import check_numbers, is_atlas
from sweep.errors import RequestError, counted, plain_text, printable, shown
from sweep.model.quantity import STABLE, UNSTABLE, with_unit
from sweep.motion.sampling import check_motion, end_of, is_motion, kind_of, losses_of, peaks_of
from sweep.request.start_list import START

if TYPE_CHECKING:
    import xarray as xr

#: A line of a summary: its label, empty if it continues the line before, and its text.
Row = tuple[str, str]

#: Styles of the lines on the small map: measured and analytic.
_MEASURED = 'stroke="black" stroke-width="1.5"'
_ANALYTIC = 'stroke="black" stroke-width="1.5" stroke-dasharray="5 3"'

_STYLE = "text-align:left;vertical-align:top"

#: Size of the map, and the space for text on its left and below it, in pixels.
_WIDTH, _HEIGHT, _LEFT, _BELOW = 240, 150, 18, 18

#: Largest number of cells shown along each axis; of more, only some are shown.
_MOST_CELLS = 120

#: Colours of verdicts that everybody can distinguish; other cells are undecided.
COLOURS = {STABLE: "#9ecae1", UNSTABLE: "#e6844a"}
UNDECIDED_COLOUR = "#bdbdbd"

Array = npt.NDArray[np.float64]

#: A line on the map: its values along the upward axis [SI], one for each place across, and its style in SVG.
Line = tuple[Array, str]


def as_text(dataset: "xr.Dataset") -> str:
    """Return the lines of a summary as text."""
    return "\n".join(f"{label:<10} {text}" for label, text in _rows(dataset))


def as_html(dataset: "xr.Dataset") -> str:
    """Return the summary as a table, and next to it a map if the atlas has a plane of cells."""
    rows = "".join(
        f"<tr><th style='{_STYLE}'>{html.escape(label)}</th><td style='{_STYLE}'>{html.escape(text)}</td></tr>"
        for label, text in _rows(dataset)
    )
    found = _map(dataset) if is_atlas(dataset) and not _lacks(dataset) else ""
    return f"<div style='display:flex;flex-wrap:wrap;gap:1em;align-items:start'><table>{rows}</table>{found}</div>"


def _rows(dataset: "xr.Dataset") -> Iterator[Row]:
    if is_motion(dataset):
        yield from _motion(dataset)
    elif is_atlas(dataset):
        yield "eulerdisk", _text(dataset.attrs["title"])
        if lacks := _lacks(dataset):
            yield "", lacks
            return
        yield from _label_rows("grid", _axes(dataset))
        yield from _label_rows("fixed", _fixed(dataset))
        yield from _verdicts(dataset)
        yield from _boundaries(dataset)
    else:
        yield "eulerdisk", "not a stability atlas"


def _lacks(dataset: "xr.Dataset") -> str:
    """Return why an atlas has no numbers to summarize; empty if it has."""
    if not dataset["ending"].size:
        return "no cells"
    try:
        check_numbers(dataset)
    except RequestError as problem:
        return problem.message
    return ""


def _text(attribute: object) -> str:
    return shown(printable(plain_text(attribute)))


def _label_rows(label: str, texts: Iterator[str]) -> Iterator[Row]:
    for number, text in enumerate(texts):
        yield "" if number else label, text


def _axes(dataset: "xr.Dataset") -> Iterator[str]:
    """Yield each axis with its values, then the product of the sizes if there is more than one axis."""
    sizes = {str(name): count for name, count in dataset["ending"].sizes.items()}
    if len(sizes) > 1:
        yield " x ".join(map(str, sizes.values())) + f" = {counted(dataset['ending'].size, 'cell')}"
    for name, count in sizes.items():
        # the numbers of the starts carry no information
        yield counted(count, "start") if name == START.name else f"{name} {count}{_extent(dataset, name)}"
    if not sizes:
        yield "one cell"


def _extent(dataset: "xr.Dataset", name: str) -> str:
    if name not in dataset.coords:
        return ""
    values, scale, units = _values(dataset, name)
    spaced = ", logarithmic" if _is_logarithmic(values) else ""
    return f": {values[0] * scale:.6g} to {values[-1] * scale:.6g} {units}".rstrip() + spaced


def _values(dataset: "xr.Dataset", name: str) -> tuple[Any, float, str]:
    """Return the values of a coordinate, the factor to show them, and their unit; angles are shown in degrees."""
    units = str(dataset[name].attrs.get("units", ""))
    scale, shown_units = (np.degrees(1.0), "deg") if units == "rad" else (1.0, units)
    values = np.asarray(dataset[name].values, np.float64)
    return values, float(scale), "" if shown_units == "1" else _text(shown_units)


def _is_logarithmic(values: Any) -> bool:
    if len(values) < 3 or not (values > 0.0).all():
        return False
    steps = np.diff(np.log(values))
    return bool(
        np.allclose(steps, steps[0], rtol=1e-6) and not np.allclose(np.diff(values), values[1] - values[0])
    )


def _fixed(dataset: "xr.Dataset") -> Iterator[str]:
    """Yield the parameters that are the same in every cell and not zero."""
    names = [str(name) for name, each in dataset.coords.items() if each.ndim == 0]
    given = [(name, *_values(dataset, name)) for name in names]
    texts = [f"{name} {value * scale:.6g} {units}".rstrip() for name, value, scale, units in given if value]
    if texts:
        yield ", ".join(texts)


def _verdicts(dataset: "xr.Dataset") -> Iterator[Row]:
    yield "criterion", _text(dataset.attrs["criterion"])
    counts = _counts(dataset)
    size = max(1, dataset["ending"].size)
    yield "cells", ", ".join(f"{n} {word} ({100 * n / size:.3g} %)" for word, n in counts.items() if n)
    if dataset["ending"].sizes.keys() == {START.name}:
        from sweep.atlas.share import in_words, unstable_share

        yield "unstable", in_words(unstable_share(dataset))


def _counts(dataset: "xr.Dataset") -> dict[str, int]:
    verdicts = dataset["stability"].values
    counts = {
        "stable": int(np.count_nonzero(verdicts == STABLE)),
        "unstable": int(np.count_nonzero(verdicts == UNSTABLE)),
    }
    return counts | {"undecided": verdicts.size - sum(counts.values())}


def _boundaries(dataset: "xr.Dataset") -> Iterator[Row]:
    """Yield where each edge was measured, in how many rows, and how far it is from theory."""
    for name in map(str, dataset.data_vars):
        if not name.startswith("boundary_") or name.endswith(("_halfwidth", "_status")):
            continue
        measured = np.asarray(dataset[name].values, np.float64)
        there = np.isfinite(measured)
        if not there.any():
            continue
        units = _text(dataset[name].attrs.get("units", ""))
        along = name.removeprefix("boundary_").removeprefix("lower_")
        rows = (
            f" in {counted(int(np.count_nonzero(there)), 'row', there.size)} along {along}"
            if there.size > 1
            else ""
        )
        yield "boundary", f"{name}: {with_unit(_range(measured[there]), units)}{rows}"
        # only a boundary of departure can be compared with the limit of vanishing perturbation
        has_theory = False
        for kind in ("predicted", "critical"):
            other = name.replace("boundary", kind, 1)
            if other in dataset and dataset[other].shape == measured.shape:
                theory = np.asarray(dataset[other].values, np.float64)[there]
                has_theory |= bool(np.isfinite(theory).any()) and kind == "predicted"
                yield from _compare_with_theory(kind, theory, measured[there], has_theory)


def _compare_with_theory(kind: str, theory: Any, measured: Any, comparable: bool) -> Iterator[Row]:
    both = np.isfinite(theory) & (theory != 0.0)
    if both.any():
        words = {"predicted": "predicted for this criterion", "critical": "analytic limit"}[kind]
        largest = 100.0 * np.max(np.abs(measured[both] / theory[both] - 1.0))
        yield "", f"{words} {_range(theory[both])}" + f": measured within {largest:.2g} %" * comparable


def _range(values: Any) -> str:
    low, high = f"{values.min():.5g}", f"{values.max():.5g}"
    return low if low == high else f"{low} to {high}"


def _map(dataset: "xr.Dataset") -> str:
    """Return the small map of an atlas and its key; empty if the atlas has no plane of cells, or a damaged one."""
    ending = dataset["ending"]
    dims = [str(name) for name, count in ending.sizes.items() if count > 1 and name in dataset.coords]
    if len(dims) < 2 or dataset["stability"].sizes != ending.sizes:
        return ""
    try:
        controls = spec_named(dataset).model.controls(dims)
    except RequestError:
        return ""
    up = controls[0] if controls else dims[-1]
    across = next(name for name in dims if name != up)
    middle = {name: count // 2 for name, count in ending.sizes.items() if name not in (up, across)}
    plane = dataset["stability"].isel(middle).transpose(up, across).values
    others = "".join(
        f"; {name} = {_spell_at(dataset, str(name), place)}" for name, place in middle.items() if name in dims
    )
    drawn = thumbnail(
        plane,
        np.asarray(dataset[up].values, np.float64),
        list(_lines(dataset, up, across, middle)),
        (across, up),
    )
    return f"<div>{drawn}<br>{_key(others)}</div>"


def _spell_at(dataset: "xr.Dataset", name: str, place: int) -> str:
    values, scale, units = _values(dataset, name)
    return f"{values[place] * scale:.4g} {units}".rstrip()


def _lines(dataset: "xr.Dataset", up: str, across: str, middle: dict[Any, int]) -> Iterator[Line]:
    for edge in EDGES:
        measured, _, _, critical = edge_names(up, edge)
        for name, style in ((critical, _ANALYTIC), (measured, _MEASURED)):
            if name in dataset and across in dataset[name].dims:
                row = dataset[name].isel(middle, missing_dims="ignore")
                if row.dims == (across,):
                    yield np.asarray(row.values, np.float64), style


def _key(others: str) -> str:
    colours = {"stable": COLOURS[STABLE], "unstable": COLOURS[UNSTABLE], "undecided": UNDECIDED_COLOUR}
    squares = " ".join(
        f"<span style='color:{colour}'>&#9632;</span>&nbsp;{word}" for word, colour in colours.items()
    )
    return f"<small>{squares}<br>&#9473;&nbsp;measured &#9476;&nbsp;analytic{html.escape(others)}</small>"


def _motion(dataset: "xr.Dataset") -> Iterator[Row]:
    """Yield the lines of a motion: what it is, which disk and start, its duration, and whether rolling is possible."""
    from sweep.figures.disk.captions import caption
    from sweep.motion.contact import rolling_limit

    try:
        check_motion(dataset)
    except RequestError as problem:
        yield "motion", problem.message
        return
    kind, times = kind_of(dataset), dataset["elapsed_time"].values
    yield "motion", _text(dataset.attrs.get("title", ""))
    if kind.largest_tilt:
        yield kind.called, caption(dataset)
    samples = (
        f"{counted(times.size, 'sample')} from {times[0]:g} to {times[-1]:g} {kind.time.shown_units}".rstrip()
    )
    yield "time", ", ".join(filter(None, (samples, end_of(dataset))))
    if lost := losses_of(dataset):
        yield "losses", lost
    if not kind.largest_tilt:
        yield from peaks_of(dataset)
        return
    limit = rolling_limit(dataset)
    friction = float(dataset["friction"])
    coefficient = f" with friction {friction:g}" if friction < float("inf") else ""
    rolls = f"rolls all the time{coefficient}; it needs {limit.needed:.4g}"
    yield "contact", limit.words(float(times[0]), friction) or rolls


def thumbnail(
    verdicts: npt.NDArray[np.int8],
    up: Array,
    lines: Sequence[Line],
    labels: tuple[str, str],
) -> str:
    """Return an SVG of a plane of verdicts, with all cells the same size for any spacing of the axes.

    Parameters
    ----------
    verdicts : array of int8, shape (len(up), n)
        STABLE, UNSTABLE or another code.
    up : array of float, shape (m,)
        The values of the upward axis, increasing or decreasing [SI].
    lines : sequence of (array of float, shape (n,), str)
        Values along the upward axis, NaN where the line has none, and the style of the line in SVG.
    labels : (str, str)
        Labels below and to the left of the map.
    """
    rows, columns = verdicts.shape
    cells = verdicts[np.ix_(_some(rows), _some(columns))][::-1]
    parts = [f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="{UNDECIDED_COLOUR}"/>']
    parts += [f'<path fill="{colour}" d="{_runs(cells == code)}"/>' for code, colour in COLOURS.items()]
    parts += [
        f'<polyline fill="none" {style} points="{points}"/>'
        for values, style in lines
        for points in _points(values, up)
    ]
    across, upward = (html.escape(label) for label in labels)
    words = 'font-size="11" fill="currentColor" text-anchor="middle" font-family="sans-serif"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH + _LEFT}" height="{_HEIGHT + _BELOW}" role="img" '
        f'aria-label="map of verdicts"><g transform="translate({_LEFT} 0)">{"".join(parts)}</g>'
        f'<text x="{_LEFT + _WIDTH / 2:g}" y="{_HEIGHT + 13}" {words}>{across}</text>'
        f'<text transform="translate(12 {_HEIGHT / 2:g}) rotate(-90)" {words}>{upward}</text></svg>'
    )


def _some(count: int) -> npt.NDArray[np.intp]:
    """Return at most as many evenly spread indices as a map shows."""
    return np.unique(np.linspace(0, count - 1, min(count, _MOST_CELLS)).round().astype(np.intp))


def _runs(where: npt.NDArray[np.bool_]) -> str:
    """Return the path of the selected cells: one rectangle for each run of them in a row, first row on top."""
    rows, columns = where.shape
    high, wide = _HEIGHT / rows, _WIDTH / columns
    path = []
    for row, line in enumerate(where):
        ends = np.flatnonzero(np.diff(np.concatenate(([False], line, [False])).astype(np.int8)))
        for start, stop in ends.reshape(-1, 2):
            # slightly higher than the row, so that no gaps show between rows
            path.append(
                f"M{start * wide:.4g} {row * high:.4g}h{(stop - start) * wide:.4g}v{high + 0.3:.4g}H{start * wide:.4g}z"
            )
    return "".join(path)


def _points(values: Array, up: Array) -> Iterator[str]:
    """Yield the points of each piece of a line, which is broken where a value is missing or outside the map."""
    count, order = len(values), np.argsort(up)
    place = np.interp(values, up[order], order.astype(float), left=np.nan, right=np.nan)
    x = (np.arange(count) + 0.5) * (_WIDTH / count)
    y = _HEIGHT - (place + 0.5) * (_HEIGHT / len(up))
    there = np.isfinite(y)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], there, [False])).astype(np.int8)))
    for start, stop in edges.reshape(-1, 2):
        if stop - start == 1:
            # a single point would be invisible
            half = 0.5 * _WIDTH / count
            yield f"{x[start] - half:.4g},{y[start]:.4g} {x[start] + half:.4g},{y[start]:.4g}"
        else:
            step = max(1, (stop - start) // _WIDTH)
            chosen = np.unique(np.append(np.arange(start, stop, step), stop - 1))
            yield " ".join(f"{x[i]:.4g},{y[i]:.4g}" for i in chosen)
