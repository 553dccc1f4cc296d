"""The potential drawn by the page and the shapes of bodies, compared with the program's motions and meridians."""

import math

import numpy as np
import pytest
from cases import case

import sweep
from sweep.explorer.about import sides
from sweep.explorer.view import View
from sweep.model.bodies.shape import body_of
from sweep.request.spec import SweepSpec

DISK = {"alpha": 0.5, "radius": 0.5, "gravity": 9.81}

POTENTIAL = """async ([start, fallTilt, tilts]) => {
    const { potentialOf } = await import("eulerdisk/motion/potential");
    const { potentialAt } = await import("eulerdisk/motion/figures");
    const { tilt, excess, wells, barriers } = potentialOf(start, fallTilt);
    const at = tilts.map((each) => potentialAt({ potential: { tilt, excess } }, each));
    return { tilt: Array.from(tilt), excess: Array.from(excess), wells, barriers, at };
}"""

SHAPE = """async ([name, cell]) => {
    const { bodyOf } = await import("eulerdisk/compute/shapes");
    const { core, shift, edge, square, axial, transverse } = bodyOf({ name, called: "" }, cell);
    return [core, shift, edge, square, axial, transverse];
}"""

#: One well, two wells, near the barrier, a kick, a spin, a hoop with all of these, and a steep circling.
STARTS = [
    {"tilt": 0.02, "roll_rate": 3.0},
    {"tilt": 0.02, "roll_rate": 2.3},
    {"tilt": 0.1, "roll_rate": 0.5},
    {"tilt_rate": 0.05, "roll_rate": 2.8},
    {"tilt": 0.02, "precession_rate": 4.5},
    {"tilt": -0.4, "tilt_rate": 0.3, "roll_rate": 1.5, "precession_rate": 2.0, "alpha": 1.0, "radius": 0.1},
    {"tilt": 0.8, "precession_rate": 6.0, "roll_rate": -2.0, "tilt_rate": 0.2},
]


def start_of(given):
    """Return a complete start."""
    return {"tilt": 0.0, "tilt_rate": 0.0, "precession_rate": 0.0, "roll_rate": 0.0, **DISK, **given}


def cell_of(start):
    """Return the cell of a start by the exact reduction."""
    axes = {name: [start[name]] for name in ("tilt", "roll_rate")}
    return sweep.run("rolling", method="exact", **start | axes)


def test_the_potential_is_below_the_energy_by_the_kinetic_energy_of_the_tilt(node):
    """Along a motion, the curve is minus (1 + alpha/2) w^2/2, with the rate w over sqrt(g/R)."""
    for given in STARTS:
        with case(given):
            start = start_of(given)
            motion = sweep.simulate(**start, duration=3.0, interval=0.02)
            tilts = motion["tilt"].values
            found = node.evaluate(POTENTIAL, [start, math.radians(89.0), tilts.tolist()])
            rates = motion["tilt_rate"].values * math.sqrt(start["radius"] / start["gravity"])
            expected = -0.5 * (1.0 + 0.5 * start["alpha"]) * rates**2
            # the curve is straight between its 241 points, which matters where it is steep
            near = np.abs(tilts) < 1.25
            assert near.sum() > 10
            off = np.abs(np.array(found["at"])[near] - expected[near]).max()
            assert off < 2e-3 * max(1e-3, np.ptp(found["excess"]))


def test_wells_are_those_of_the_reduction_and_barriers_lie_between_them(node):
    """Each well of a cell is at a minimum of the curve, with a barrier between neighboring wells."""
    for given in STARTS:
        with case(given):
            start = start_of(given)
            cell = cell_of(start)
            found = node.evaluate(POTENTIAL, [start, math.radians(89.0), [0.0]])
            wells, barriers = (sorted(tilt for tilt, _ in found[name]) for name in ("wells", "barriers"))
            assert len(wells) <= int(cell["wells"].item())
            assert len(wells) >= 1
            if len(wells) == 2:
                assert any(wells[0] < each < wells[1] for each in barriers)
            # the slope of the drawn curve changes its sign here
            for tilt, height in found["wells"]:
                beside = np.interp([tilt - 0.02, tilt + 0.02], found["tilt"], found["excess"])
                assert height <= beside.min() + 1e-9
            for tilt, height in found["barriers"]:
                beside = np.interp([tilt - 0.02, tilt + 0.02], found["tilt"], found["excess"])
                assert height >= beside.max() - 1e-9


def test_the_curve_shows_the_whole_swing(node):
    """Both turning points are on the curve, with zero excess within its point spacing."""
    for given in STARTS:
        with case(given):
            start = start_of(given)
            cell = cell_of(start)
            if int(cell["ending"].item()) != 1:
                continue
            turns = [float(cell[name].item()) for name in ("tilt_min", "tilt_max")]
            found = node.evaluate(POTENTIAL, [start, math.radians(89.0), turns])
            assert found["tilt"][0] < turns[0] <= turns[1] < found["tilt"][-1]
            assert np.allclose(found["at"], 0.0, atol=1e-2 * np.ptp(found["excess"]))
            assert found["excess"][0] > 0.0
            assert found["excess"][-1] > 0.0


#: Bodies by their words, each with its own lengths.
BODIES = [
    {"body": "torus", "tube": 0.3},
    {"body": "rounded", "thickness": 0.4},
    {"body": "rim", "thickness": 0.5, "fillet": 0.1, "tilt": 0.2},
    {"body": "rim", "thickness": 0.5, "fillet": 0.1, "tilt": -0.2},
    {"body": "arc", "fillet": 0.3, "offset": -0.1},
    {"body": "ball", "offset": 0.2},
    {"body": "spheroid", "flattening": 0.4},
    {"body": "spheroid", "flattening": -0.4},
]


@pytest.mark.parametrize("words", BODIES, ids=lambda words: words["body"])
def test_shapes_are_those_of_the_program(node, words):
    """The arc of a body and its moments equal those of the program."""
    moments = {"axial_moment": 0.4, "transverse_moment": 0.3}
    spec = SweepSpec.preset("rolling", **{"tilt": 0.1, "roll_rate": 2.0} | moments | words)
    view = View.read({**sides(spec), "base": "", "words": {}}, spec)
    cell = view.starts(*(np.array([getattr(spec, each.name)]) for each in (view.x, view.y)))
    expected = [float(np.ravel(each)[0]) for each in body_of(spec, cell)][:6]
    numbers = {name: float(values[0]) for name, values in cell.items()}
    found = node.evaluate(SHAPE, [words["body"], numbers])
    assert found == pytest.approx(expected, rel=1e-14, abs=1e-15)
