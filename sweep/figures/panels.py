"""What a panel of a figure shows: an atlas turned into the arrays, labels and words that are drawn."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sweep.atlas import theory
from sweep.atlas.curves import without_curves
from sweep.errors import RequestError
from sweep.figures.scales import Scale, scale
from sweep.request.axes import Values
from sweep.request.spec import SweepSpec
from sweep.schema import CONTACT_VARIABLES, PARAMETERS, STABLE, UNDECIDED, UNSTABLE, VARIABLES, Array, Truths

if TYPE_CHECKING:
    import xarray as xr

#: Points on a line of theory: enough that a curve looks smooth whatever the grid.
_FINE = 400

#: Where circling's lines start: they end at zero tilt, where no disk circles.
_UPRIGHT = 1e-6

#: Endings that leave nothing to draw.
_NO_RESULT = ("not_computed", "unresolved", "invalid")

#: Fixed parameters in a line of the caption: more would be wider than the panel.
_MOST_IN_LINE = 4

_CODES = {name: code for code, name in (VARIABLES["ending"].flags or {}).items()}


@dataclass(frozen=True)
class Edge:
    """One edge of the unstable band: as measured, with its bracket, and the two lines of theory.

    `x`, `measured` and `error`, shape (2, n), have a value for every column that has an edge; `fine_x`, `critical` and
    `predicted` one for every point of a smooth line, or a single one where the rate is the only axis. The ratios are
    squares of rates over squares of the analytic critical ones.
    """

    name: str
    x: Array
    measured: Array
    error: Array
    ratio: Array
    ratio_error: Array
    fine_x: Array
    critical: Array
    predicted: Array
    predicted_ratio: Array


@dataclass(frozen=True)
class Panel:
    """All that is drawn of one atlas.

    `peak` [deg], `stability` and `no_result` have the shape (rows of y, columns of x), or (columns of x) where `y` is
    None. `line` and `upright` (spinning, rolling) are the analytic lines as formulas in mathtext, `lost` names the
    endings behind `no_result`, `in_g_over_r` is R/g [s2] where a squared rate is drawn and has one such unit.
    `method` is how the cells were computed.
    `slips` are the cells that need more than the friction coefficient, or lift off; `slipping` says so.
    """

    title: str
    caption: str
    criterion: str
    line: str
    x: Scale
    y: Scale | None
    peak: Array
    stability: npt.NDArray[np.integer]
    no_result: Truths
    lost: str
    edges: tuple[Edge, ...]
    in_g_over_r: float | None
    circling_from_upright: bool
    upright: tuple[str, str]
    method: str
    slips: Truths
    slipping: str

    @property
    def undecided(self) -> Truths:
        """Cells that have a peak but no verdict."""
        return np.asarray((self.stability == UNDECIDED) & ~self.no_result)

    @property
    def has_ratio(self) -> bool:
        """Whether a map has a measured boundary to hold against an analytic line."""
        return self.y is not None and any(np.isfinite(edge.ratio).any() for edge in self.edges)

    def verdicts(self) -> tuple[tuple[str, Truths], ...]:
        """Return the name and the cells of the two verdicts."""
        return tuple(
            (name, (self.stability == code) & ~self.no_result)
            for name, code in (("stable", STABLE), ("unstable", UNSTABLE))
        )


def panel(dataset: "xr.Dataset", friction: float | None = None) -> Panel:
    """Return what is drawn of an atlas.

    Parameters
    ----------
    dataset : xarray.Dataset
        An atlas, or a selection from one; axes of a single value are left out.
    friction : float, optional
        Friction coefficient of disk and plane: cells that need more are marked.

    Returns
    -------
    Panel

    Raises
    ------
    RequestError
        If the atlas has no axis or more than two, or no contact forces to hold `friction` against.
    """
    dataset = without_curves(dataset).squeeze()
    spec = drawn_spec(dataset)
    rate = next((name for name in theory.spun_rates(spec) if f"boundary_{name}" in dataset), None)
    x_name, y_name = _names(dataset, rate)
    x = scale(
        x_name, dataset[x_name].values, squares=x_name == rate, from_zero=spec.circling and x_name == "tilt"
    )
    y = scale(y_name, dataset[y_name].values, squares=y_name == rate) if y_name else None
    cells = dataset[["peak_tilt", "stability", "ending"]].transpose(*filter(None, (y_name, x_name))).load()
    peak, ending = cells["peak_tilt"].values * VARIABLES["peak_tilt"].plot_scale, cells["ending"].values
    lost = [name for name in _NO_RESULT if np.any(ending == _CODES[name])]
    up, across = (y, x) if y else (x, None)
    square = f"{up.quantity.symbol}^2 = ".replace("_0", "")
    return Panel(
        title=spec.headline.partition(":")[0],
        caption=_caption(spec),
        criterion=_criterion(spec),
        line="$k = 0$" if spec.circling else f"${'' if up.squared else square}{_formula(rate, spec)}$",
        x=x,
        y=y,
        peak=peak,
        stability=cells["stability"].values,
        no_result=np.isin(ending, [_CODES[name] for name in lost]) | ~np.isfinite(peak),
        lost=", ".join(lost).replace("_", " ") or "no peak",
        edges=tuple(_edges(dataset, spec, rate, up, across)) if rate else (),
        in_g_over_r=_unit_squared(spec) if up.squared else None,
        circling_from_upright=spec.circling and x_name == "tilt" and x.ends[0] == 0.0 and up.squared,
        upright=(
            rf"spinning: $\dot\psi^2 = {_formula('precession_rate', spec)}$",
            rf"rolling: $\dot\phi^2 = {_formula('roll_rate', spec)}$",
        ),
        method={"rk4": "RK4"}.get(spec.method, spec.method),
        slips=_slips(dataset, cells["ending"], friction),
        slipping="" if friction is None else f"slips or lifts off at friction {friction:g}",
    )


def _slips(dataset: "xr.Dataset", like: "xr.DataArray", friction: float | None) -> Truths:
    """Cells that would need more than a friction coefficient, in the shape of the drawn ones."""
    if friction is None:
        return np.zeros(like.shape, dtype=bool)
    missing = [name for name in CONTACT_VARIABLES if name not in dataset]
    if missing:
        raise RequestError(
            "this atlas holds no contact forces",
            "friction is held against an atlas that was made with contact=yes",
            f"friction={friction:g}, without {' and '.join(missing)}",
            "make it again with eulerdisk run SPEC contact=yes",
            str(dataset.attrs["title"]),
        )
    lifts, needed = (dataset[name].transpose(*like.dims).values for name in CONTACT_VARIABLES)
    return np.asarray((lifts <= 0.0) | (needed > friction))


def drawn_spec(dataset: "xr.Dataset") -> SweepSpec:
    """Return the spec of what is left of an atlas, and refuse what is not a line or a map."""
    dims = [str(name) for name in dataset["ending"].dims]
    if len(dims) > 2:
        raise RequestError(
            "too many axes for a figure",
            "a figure shows an atlas of one axis or two",
            f"{len(dims)} axes: {', '.join(dims)}",
            f"select one value of {' and of '.join(dims[2:])}, e.g. atlas.isel({dims[-1]}=0) in Python",
        )
    if not dims:
        raise RequestError(
            "nothing to draw",
            "a figure shows an atlas of one axis or two",
            "a single cell",
            "give a parameter a range, e.g. roll_rate=2:4:100",
        )
    spec = SweepSpec.from_canonical(dataset.attrs["sweep_spec"])
    return spec.replace(**{name: float(dataset[name]) for name in spec.axes if name not in dims})


def _names(dataset: "xr.Dataset", rate: str | None) -> tuple[str, str | None]:
    """(x, y): the rate that has a boundary goes up, else the atlas's first axis does."""
    dims = [str(name) for name in dataset["ending"].dims]
    if len(dims) == 1:
        return dims[0], None
    y = rate or dims[0]
    return next(name for name in dims if name != y), y


def _edges(dataset: "xr.Dataset", spec: SweepSpec, rate: str, up: Scale, across: Scale | None) -> list[Edge]:
    """Return the edges of the unstable band along a rate, which is the scale `up`."""
    fine = _fine(dataset, across) if across else np.zeros(1)
    smooth = spec.replace(**{across.quantity.name: Values(tuple(fine))}) if across else spec
    lines = theory.edges(smooth, rate)
    nothing = np.full(fine.shape, np.nan)
    edges = []
    for name, lower in (("upper", ""), ("lower", "lower_")):
        if f"boundary_{lower}{rate}" not in dataset:
            continue
        measured, half, analytic = (
            np.atleast_1d(dataset[each].values)
            for each in (
                f"boundary_{lower}{rate}",
                f"boundary_{lower}{rate}_halfwidth",
                f"critical_{lower}{rate}",
            )
        )
        has = np.isfinite(measured)
        middle, low, high = measured[has], (measured - half)[has], (measured + half)[has]
        critical, predicted = (np.atleast_1d(line) for line in lines.get(name, (nothing, nothing)))
        # where the analytic rate is zero (circling upright) there is nothing to compare with
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = [(each / analytic[has]) ** 2 for each in (low, middle, high)]
            predicted_ratio = (predicted / critical) ** 2
        edges.append(
            Edge(
                name,
                across.values[has] if across else np.zeros(middle.shape),
                up.shown(middle),
                _spread(*map(up.shown, (low, middle, high))),
                ratios[1],
                _spread(*ratios),
                across.shown(fine) if across else fine,
                up.shown(critical),
                up.shown(predicted),
                predicted_ratio,
            )
        )
    return edges


def _spread(low: Array, middle: Array, high: Array) -> Array:
    """Error bars, shape (2, n): squares turn the ends of a bracket round where rates are negative."""
    ends = np.sort([low, high], axis=0)
    return np.maximum([middle - ends[0], ends[1] - middle], 0.0)


def _fine(dataset: "xr.Dataset", across: Scale) -> Array:
    start, stop = dataset[across.quantity.name].values[[0, -1]]
    if across.log:
        return np.geomspace(start, stop, _FINE)
    return np.linspace(_UPRIGHT if across.ends[0] == 0.0 and start > 0.0 else start, stop, _FINE)


def _unit_squared(spec: SweepSpec) -> float | None:
    """R/g [s2], unless cells differ in radius or gravity."""
    if isinstance(spec.radius, float) and isinstance(spec.gravity, float):
        return spec.radius / spec.gravity
    return None


def _formula(rate: str | None, spec: SweepSpec) -> str:
    """Squared critical rate of the upright disk (see `theory`), in mathtext."""
    rolling = rate == "roll_rate"
    if spec.alpha == 0.5:
        return "g/3R" if rolling else "4g/5R"
    if spec.alpha == 1.0:
        return "g/4R" if rolling else "2g/3R"
    return r"g/[2(1{+}\alpha)R]" if rolling else r"2g/[(2{+}\alpha)R]"


def _criterion(spec: SweepSpec) -> str:
    limit = spec.criterion.limit
    if spec.criterion.kind == "departure":
        return f"departure {math.degrees(limit):.4g}°"
    return f"amplification {limit:.4g}"


def _caption(spec: SweepSpec) -> str:
    """What counts as unstable, and the parameters that are the same in every cell and not zero."""
    return f"unstable: {_criterion(spec).replace(' ', ' above ')}, or a fall\n{fixed_parameters(spec)}"


def fixed_parameters(spec: SweepSpec) -> str:
    """Return the parameters that are the same in every cell and not zero, in mathtext."""
    parts = []
    for name in ("alpha", "radius", "gravity", "tilt", "tilt_rate", "precession_rate", "roll_rate"):
        fixed, quantity = getattr(spec, name), PARAMETERS[name]
        if isinstance(fixed, float) and fixed != 0.0:
            unit = quantity.plot_label.rpartition(" (")[2].rstrip(")") if quantity.units != "1" else ""
            parts.append(f"${quantity.symbol} = {fixed * quantity.plot_scale:.4g}$ {unit}".rstrip())
    lines = [", ".join(parts[i : i + _MOST_IN_LINE]) for i in range(0, len(parts), _MOST_IN_LINE)]
    return "\n".join(lines)
