"""For cells of random starts and disks, the page has the program's numbers."""

import base64
from pathlib import Path

import numpy as np
import pytest

from kernels.bodies.arrays import CONTACT
from kernels.system.endings import DIFFERENT, FIRST_EVENT, RUNS_ON
from sweep.engine.compute import compute
from sweep.explorer.about import sides
from sweep.explorer.plan import plan
from sweep.explorer.view import View
from sweep.model.disk.model import DISK
from sweep.model.disk.path import PATH_VARIABLES
from sweep.request.spec import SweepSpec

#: Ask workers for cells; their columns are returned as bytes of doubles, in base64.
CELLS = """async ([plan, given, names, count]) => {
    const { Computation } = await import("eulerdisk/compute/computation");
    const answer = await fetch("./page/kernels.wasm");
    window.computation ??= new Computation(answer.arrayBuffer());
    const unpacked = ([name, text]) => {
        const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
        return [name, new Float64Array(bytes.buffer)];
    };
    const cells = Object.fromEntries(Object.entries(given).map(unpacked));
    const columns = await window.computation.ask("cells", { plan, given: cells, count });
    const packed = (name) => {
        const bytes = new Uint8Array(Float64Array.from(columns[name]).buffer);
        let text = "";
        for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
        return btoa(text);
    };
    return names.map(packed);
}"""

#: Cells per question.
PIECE = 20_000


def columns_of_page(page, how, starts, names):
    """Return columns that the page computes piece by piece from a plan, shape (names, cells)."""
    count = next(iter(starts.values())).size
    found = []
    for first in range(0, count, PIECE):
        part = {name: values[first : first + PIECE] for name, values in starts.items()}
        given = {name: base64.b64encode(values.tobytes()).decode() for name, values in part.items()}
        size = min(PIECE, count - first)
        packed = page.evaluate(CELLS, [how, given, names, size])
        found.append(np.stack([np.frombuffer(base64.b64decode(each)) for each in packed]))
    return dict(zip(names, np.concatenate(found, axis=1), strict=True))


def any_view(base, words):
    """Return a view of a preset with these words; its window does not matter."""
    sides = {"x": ("tilt", 0.1, 0.05), "y": ("alpha", 0.5, 0.4)}
    raw = {
        which: {"name": name, "centre": centre, "half": half, "scale": "linear"}
        for which, (name, centre, half) in sides.items()
    }
    return View.read({"base": base, "words": words, **raw}, SweepSpec.preset("rolling"))


#: Some disks of all sizes, and unusual criteria.
WORDS = [
    ("rolling", {}),
    ("circling", {"precession_rate": 2.0}),
    ("spinning", {}),
    ("rolling", {"criterion": "amplification:10", "fall_tilt": "60deg"}),
    ("rolling", {"criterion": "not (peak_tilt > 10deg or 1deg < tilt_max <= 5deg) and nutation_period < 3s"}),
]


@pytest.mark.slow_lane
def test_cells_without_losses(opened, rng, count):
    """For random starts of all presets and unusual disks, endings and wells are equal, and numbers agree to 1e-12.

    Periods agree to 1e-9, and verdicts may differ only within the stated error of the tilts.
    """
    page = opened()
    for base, words in WORDS:
        view = any_view(base, words)
        n = count(6_000, 200_000)
        starts = {
            "tilt": rng.choice([-1.0, 1.0], n) * 10.0 ** rng.uniform(-8, np.log10(1.5), n),
            "tilt_rate": rng.choice([0.0, 1.0], n) * rng.normal(0.0, 1.0, n) * 10.0 ** rng.uniform(-6, 1, n),
            "precession_rate": rng.choice([0.0, 1.0], n) * rng.normal(0.0, 5.0, n),
            "roll_rate": rng.normal(0.0, 5.0, n),
            # few values, because cells of one body share its panels
            "alpha": rng.choice([0.5, 1.0, 0.031, 0.77], n),
            "radius": 10.0 ** rng.uniform(-4, 3, n),
            "gravity": 10.0 ** rng.uniform(-3, 3, n),
        }
        # some outside the domain of a parameter
        starts["alpha"][:50], starts["radius"][50:90] = 1.5, -1.0
        if view.live.computed:
            # without a kick, rounding decides if a motion is exactly steady
            starts["tilt_rate"] = 10.0 ** rng.uniform(-6, 0, n)
        starts = {name: values for name, values in starts.items() if name not in view.live.computed}
        full = view.spec.model.complete(
            view.live, {**starts, **{name: np.zeros(n) for name in view.live.computed}}
        )
        expected = compute(view.live, {name: full[name] for name in DISK.parameters})
        names = [
            "ending",
            "wells",
            "tilt_min",
            "tilt_max",
            "separatrix",
            "nutation_period",
            "stability",
            "peak_tilt",
        ]
        found = columns_of_page(page, plan(view)["cells"], starts, [*names, "tilt_error"])
        for name in ("ending", "wells"):
            assert np.array_equal(found[name], expected[name]), (base, name)
        error = np.nan_to_num(expected["tilt_error"].astype(float))
        for name in ("tilt_min", "tilt_max", "peak_tilt"):
            apart = np.abs(found[name] - expected[name])
            assert np.array_equal(np.isnan(found[name]), np.isnan(expected[name])), (base, name)
            # rounding differs for a steady rate and for the motion it starts
            assert np.nanmax(apart - (0.1 * error if view.live.computed else 0.0)) < 1e-12, (base, name)
        assert np.nanmax(np.abs(found["separatrix"] - expected["separatrix"])) < 1e-11 * 25.0, base
        both = np.isfinite(found["nutation_period"]) & np.isfinite(expected["nutation_period"])
        # near a separatrix, rounding decides if a period is known
        assert (both | np.isnan(expected["nutation_period"])).mean() > 0.999, base
        period = expected["nutation_period"][both]
        assert np.max(np.abs(found["nutation_period"][both] - period) / period) < 1e-9, base
        assert (found["stability"] != expected["stability"]).sum() <= 1e-5 * n, base
        assert {0, 1, 2} == set(expected["stability"]), base


@pytest.mark.slow_lane
def test_cells_with_losses(opened, rng, count):
    """Endings equal the program's, and numbers agree within a tenth of their errors."""
    page = opened()
    for words in [{}, {"rolling_friction": "10um", "pivoting_friction": "20um", "air_law": "moffatt"}]:
        spec = SweepSpec.preset("toy", duration="20s", criterion="aloft:5s", **words)
        view = View.read(
            {
                "base": "",
                "words": {"duration": 20.0},
                "x": {"name": "tilt", "centre": 0.5, "half": 0.1, "scale": "linear"},
                "y": {"name": "precession_rate", "centre": 20.0, "half": 1.0, "scale": "linear"},
            },
            spec,
        )
        how = plan(view)["lossy"]
        n = count(60, 2000)
        starts = {"tilt": rng.uniform(-1.4, 1.4, n), "precession_rate": rng.uniform(-40.0, 40.0, n)}
        starts["precession_rate"][:5] = 0.0
        full = view.starts(starts["tilt"], starts["precession_rate"])
        duration = how["kernel_settings"][0]
        expected = compute(view.spec.replace(duration=duration), full)
        errors = {
            "tilt_min": "tilt_error", "tilt_max": "tilt_error", "end_time": "time_error",
            "heading_turned": "heading_error", "path_length": "path_error",
        }  # fmt: skip
        found = columns_of_page(page, how, starts, ["ending", "stability", "largest_loss", *errors])
        for name in ("ending", "stability", "largest_loss"):
            assert np.array_equal(found[name], expected[name]), (words, name)
        for name, error in errors.items():
            allowed = 0.1 * expected[error].astype(float) + 1e-12 * np.abs(expected[name])
            assert np.nanmax(np.abs(found[name] - expected[name]) / (allowed + 1e-300)) < 1.0, (words, name)
        assert len(set(expected["ending"])) > 1, words


#: Every function, and every kind of measure, ending and label.
ANY = """
from sweep.systems import atan, cos, exp, log, sin, sqrt, system, tan, tanh


@system(duration=4, ends={"out": "abs(x) > 2 or y - x/4 > 1.5"}, conserved=["x*y/2 - z**2", "exp(x) - z"],
        measures={"lowest": "min x + y/2", "peak": "max abs(y - z/4)", "final": "last exp(-x)*tanh(y) - log(1 + x**2)",
                  "angle": "last sqrt(x**2 + 1)/3 + tan(y/4)*cos(t) + atan2(y, x + 3)",
                  "often": "count abs(x) > 0.3", "began": "time of first x*y > 0.05", "when": "time of max sin(x) - y",
                  "then": "value of y + t at last x < 0.2 and y < 0.5", "average": "mean cos(t)*y",
                  "whole": "integral x**2"},
        label={"right": "x > 0.1 and y > 0", "left": "x < -0.1", "middle": True}, stable="peak < 1.3 and lowest > -1.5")
def any(x=0.3, y=0.2, z=0.0, *, k=1.0, q=0.1):
    return y, -k*sin(x) + q*cos(3*z), 0.5 + 0.1*atan(y)
"""

#: Systems with an ending and a theory, with several endings and a conserved energy, and with labels.
SYSTEMS = {
    "kapitza": {"duration": 2.0},
    "henon_heiles": {"duration": 30.0, "criterion": "ending == left or conserved_change > 1e-13"},
    "magnets": {"duration": 20.0},
    "any.py": {},
}


@pytest.mark.parametrize(
    "name",
    [*(pytest.param(each, marks=pytest.mark.release) for each in SYSTEMS if each != "any.py"), "any.py"],
)
@pytest.mark.slow_lane
def test_cells_of_a_system(served_with, opened, rng, count, name, tmp_path, monkeypatch):
    """Endings, labels and verdicts of a user's system equal the program's, and numbers agree as stated."""
    monkeypatch.chdir(tmp_path)
    Path("any.py").write_text(ANY, encoding="utf-8")
    # this file has no ranges
    given = SweepSpec.read(name, **({"x": "-2.2:2.2:3", "y": "-2:2:3"} if name == "any.py" else {}))
    view = View.read({**sides(given), "base": "", "words": SYSTEMS[name]}, given)
    page = opened(served_with(name).url)
    axes, n = (view.x.name, view.y.name), count(60, 2000)
    starts = {side.name: rng.uniform(*side.ends(), n) for side in (view.x, view.y)}
    expected = compute(view.spec, view.starts(*(starts[each] for each in axes)))
    coded = [each for each in ("ending", "label", "stability") if each in expected]
    values = {each: f"{each}_error" for each in expected if f"{each}_error" in expected}
    names = [*coded, *values, *values.values(), *(each for each in ["conserved_change"] if each in expected)]
    how = plan(view)["cells"]
    found = columns_of_page(page, how, starts, names)
    # with zero tolerance, passes that end in the same place at other times count as different
    strict = {**how, "system": {**how["system"], "same_time": 0.0, "same_place": 1e9}}
    (apart,) = columns_of_page(page, strict, starts, ["ending"]).values()
    ended = found["ending"] >= FIRST_EVENT
    assert (apart[ended] == DIFFERENT).any() == ended.any()
    assert np.array_equal(apart[found["ending"] == RUNS_ON], found["ending"][found["ending"] == RUNS_ON])
    # the last bits of a motion decide if it is called sensitive
    same = np.all([found[each] == expected[each] for each in coded], axis=0)
    assert same.sum() >= n - max(1, 0.01 * n)
    kinds = [len(set(expected[each][same])) for each in coded]
    assert (min if name == "any.py" else max)(kinds) > 1
    for each, error in values.items():
        apart, allowed = np.abs(found[each] - expected[each])[same], expected[error][same].astype(float)
        assert np.array_equal(np.isnan(found[each]), np.isnan(expected[each])), each
        assert np.mean((apart <= allowed + 1e-15) | np.isnan(apart)) > 0.99, each
        # both errors are differences of passes, which rounding changes if they are small
        off = np.abs(found[error][same] - expected[error][same])
        assert np.mean((off <= 1e-3 * allowed) | np.isnan(allowed)) > 0.9, error
    if "conserved_change" in expected:
        change = expected["conserved_change"][same]
        assert np.allclose(found["conserved_change"][same], change, rtol=1e-6, atol=1e-13, equal_nan=True)


#: Bodies by their words, and disks with paths: computed and given moments, steady rates, contact forces, all
#: kinds of criteria, upright, circling and on an end.
BODIES = {
    "disk": ["rolling", "path=yes", "contact=yes", "precession_rate=2",
             "criterion=path_drift > 2 or path_class == closed"],
    "torus": ["body=torus", "tube=0.05:0.6:3", "precession_rate=2:4:3", "roll_rate=steady", "tilt=20deg",
              "tilt_rate=0.3", "criterion=departure:15deg", "filling=hollow", "contact=yes", "path=yes"],
    "rounded": ["body=rounded", "thickness=0.05:0.9:3", "tilt=5deg:40deg:3", "roll_rate=3", "path=yes",
                "criterion=departure:30deg"],
    "rim": ["true_edge"],
    "arc": ["body=arc", "fillet=0:0.9:3", "offset=-0.1", "tilt=5deg:60deg:3", "precession_rate=4", "roll_rate=wobble",
            "tilt_rate=0.3", "criterion=departure:20deg", "axial_moment=0.4", "transverse_moment=0.3"],
    "ball": ["egg", "criterion=amplification:10"],
    "spheroid": ["body=spheroid", "flattening=-0.6:0.6:3", "tilt=1deg:85deg:3", "tilt_rate=0.5", "roll_rate=2",
                 "criterion=departure:40deg", "path=yes"],
}  # fmt: skip


@pytest.mark.slow_lane
@pytest.mark.parametrize(
    "name",
    [
        *["disk", "ball"],
        *(pytest.param(each, marks=pytest.mark.release) for each in BODIES if each not in ("disk", "ball")),
    ],
)
def test_cells_of_a_body(served_with, opened, rng, count, name):
    """Endings and verdicts of other bodies equal the program's, and numbers agree to 1e-10.

    The reduction's series are summed differently, over about ten panels. Near a separatrix, rounding decides
    if there is a
    period and how a cell ends.
    """
    words = BODIES[name]
    given = SweepSpec.from_words(*((words[0], words[1:]) if "=" not in words[0] else ("rolling", words)))
    view = View.read({**sides(given), "base": "", "words": {}}, given)
    page = opened(served_with(*words).url)
    axes, n = (view.x.name, view.y.name), count(500, 20_000)
    starts = {side.name: rng.uniform(*side.ends(), n) for side in (view.x, view.y)}
    expected = compute(view.live, view.starts(*(starts[each] for each in axes)))
    names = ["ending", "stability", "tilt_min", "tilt_max", "peak_tilt", "amplification", "nutation_period"]
    whole = ["contact_state"] if "contact=yes" in words else []
    whole += ["path_class", "closing_nutations", "closing_turns"] if "path=yes" in words else []
    more = [name for name in (*CONTACT, *PATH_VARIABLES) if name in expected and name not in whole]
    found = columns_of_page(page, plan(view)["cells"], starts, [*names, *whole, *more])
    for each in ("ending", "stability", *whole):
        assert np.mean(found[each] == expected[each]) > 0.999, each
    assert len(set(expected["stability"])) > 1
    same = found["ending"] == expected["ending"]
    for each in (*names[2:], *more):
        both = same & np.isfinite(found[each]) & np.isfinite(expected[each])
        assert np.mean(both | np.isnan(expected[each])) > 0.999, each
        # if the heading gains almost whole turns, the center is far away and as sensitive to rounding
        near = (
            np.abs(2.0 * np.sin(0.5 * expected["heading_per_nutation"])) if each.startswith("ring") else 1.0
        )
        off = (np.abs(found[each] - expected[each]) * np.minimum(near, 1.0))[both]
        assert np.max(off / (1.0 + np.abs(expected[each][both]))) < 1e-9, each


@pytest.mark.parametrize("name", ["tilt_max", "stability"])
def test_a_fault_is_seen(opened, name):
    """A different plan gives different results, so the comparison can fail."""
    page, view = opened(), any_view("rolling", {})
    starts = {"tilt": np.full(3, 0.02), "roll_rate": np.full(3, 2.3), "alpha": np.full(3, 0.5)}
    how = plan(view)["cells"]
    right = columns_of_page(page, how, starts, [name])[name]
    other = {**how, "held": {**how["held"], "gravity": 3.0}}
    assert not np.array_equal(columns_of_page(page, other, starts, [name])[name], right)
