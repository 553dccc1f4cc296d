"""Figures of work against precision, and of time against size."""

from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

#: Okabe and Ito's colours, safe for the colour-blind; contenders of one kind share a colour and differ by marker and
#: line.
_LOOKS = {
    "eulerdisk": ("#D55E00", 2.2),
    "Numba": ("#000000", 1.2),
    "NumPy": ("#000000", 1.2),
    "heyoka": ("#0072B2", 1.2),
    "diffrax": ("#009E73", 1.2),
    "SciPy": ("#CC79A7", 1.2),
    "Octave": ("#777777", 1.2),
}
_MARKERS = "osD^v"
_STYLE = {"labelsize": 8, "titlesize": 9}


def _axes(width: float, height: float) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.grid(True, which="major", linewidth=0.4, color="0.85")
    axes.tick_params(labelsize=8)
    return figure, axes


def work_precision(found: dict[str, Any], path: Path) -> None:
    """Draw error against time per cell for every contender."""
    figure, axes = _axes(7.0, 4.2)
    seen: dict[str, int] = {}
    for row in found["field"]["contenders"]:
        kind = row["name"].split()[0]
        colour, width = _LOOKS[kind]
        number = seen[kind] = seen.get(kind, -1) + 1
        rungs = [rung for rung in row["ladder"] if rung["error"] > 0.0]
        if not rungs:
            cost = row["us_per_cell"]["median"]
            axes.axvline(
                cost, color=colour, linewidth=width, linestyle=":", label=f"{row['name']}\n(the reference)"
            )
            continue
        axes.plot(
            [rung["us_per_cell"] for rung in rungs],
            [rung["error"] for rung in rungs],
            color=colour, linewidth=width, marker=_MARKERS[number], markersize=4.5,
            markerfacecolor="white" if kind == "NumPy" or number % 2 else colour,
            linestyle="--" if number % 2 else "-", label=row["name"],
        )  # fmt: skip
    axes.axhline(found["field"]["target"], color="0.5", linewidth=0.8)
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel("time per cell on one thread (µs)", fontsize=8)
    axes.set_ylabel("error of the peak tilt, 99 % of cells (rad)", fontsize=8)
    axes.set_title(_title("Work and precision", found), fontsize=9, loc="left")
    figure.legend(fontsize=7.5, loc="outside right upper", frameon=False)
    figure.savefig(path, dpi=200)


def scaling(found: dict[str, Any], path: Path) -> None:
    """Draw time per cell against the number of cells, with one line for each number of threads."""
    figure, axes = _axes(4.5, 3.2)
    for number, threads in enumerate(sorted({row["threads"] for row in found["scaling"]})):
        rows = [row for row in found["scaling"] if row["threads"] == threads]
        axes.plot(
            [row["cells"] for row in rows],
            [row["us_per_cell"] for row in rows],
            color=("#0072B2", "#D55E00")[number % 2], marker=_MARKERS[number % 5], markersize=5,
            linestyle=("-", "--")[number % 2], label=f"{threads} thread" + ("s" if threads > 1 else ""),
        )  # fmt: skip
    axes.set(xscale="log", ylim=(0.0, None))
    axes.set_xlabel("cells", fontsize=8)
    axes.set_ylabel("time per cell in the kernel (µs)", fontsize=8)
    axes.set_title(_title("Scaling, rolling preset", found), fontsize=9, loc="left")
    axes.legend(fontsize=8, frameon=False)
    figure.savefig(path, dpi=200)


def _title(what: str, found: dict[str, Any]) -> str:
    held = found["machine"]
    return f"{what} ({held['processor']}, {held['day']})"
