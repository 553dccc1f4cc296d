"""Compare the engine and the reduction of other bodies with each other, and with a rigid body in space.

    python scripts/audit_bodies.py errors [CELLS] [SEED]   engine against reduction: endings, extremes, stated errors
    python scripts/audit_bodies.py space [COUNT] [SEED]    reduction against Newton and Euler's equations by DOP853

CELLS is the number of cells of each body, with random lengths, moments, radii, gravities, tilts and rates over decades.
Exit status 1 if a promise is broken.
"""

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import body_runner
from body_referee import Body

from kernels.bodies.arrays import PARAMETERS, REDUCED
from kernels.bodies.shapes import FIRST_WITH_POLES, NAMES, RIM, arc_of, solid_moments, torus_moments
from kernels.disk.arrays import ENDING
from kernels.disk.endings import BOUNDED
from sweep.model.bodies.exact import kernel_of

Array = npt.NDArray[np.float64]

FALL = math.radians(85.0)

#: Promised: error of extremes [rad], relative error of periods at the default tolerance, and share of cells beyond
#: twice the stated error.
TOLERANCE, PERIOD, MOST_BEYOND = 1e-8, 1e-7, 1e-3

#: Largest difference [rad, relative] between the reduction and SciPy at 1e-12.
NEAR = 1e-9


def draw_starts(body: str, n: int, rng: np.random.Generator) -> Array:
    """Return random starts of a body."""
    known = dict.fromkeys(PARAMETERS, np.zeros(n))
    if body == "torus":
        known["tube"] = rng.uniform(0.0, 0.9, n)
        hollow = rng.random(n) < 0.5
        both = [torus_moments(known["tube"], each) for each in (False, True)]
        axial, across = (np.where(hollow, second, first) for first, second in zip(*both, strict=True))
    elif body == "arc":
        known["fillet"], known["offset"] = rng.uniform(0.0, 1.0, n), rng.uniform(-0.5, 0.5, n)
        across = rng.uniform(0.1, 0.6, n)
        axial = across * rng.uniform(0.3, 1.9, n)
    elif body == "ball":
        known["offset"], across = rng.uniform(-0.9, 0.9, n), rng.uniform(0.1, 0.6, n)
        axial = across * rng.uniform(0.3, 1.9, n)
    elif body == "spheroid":
        q, across = np.exp(rng.uniform(np.log(0.2), np.log(3.0), n)), rng.uniform(0.1, 0.6, n)
        known["flattening"] = 1.0 - q
        known["offset"] = 0.9 * q * rng.uniform(-1.0, 1.0, n) * (rng.random(n) < 0.7)
        axial = across * rng.uniform(0.3, 1.9, n)
    else:
        known["thickness"] = 10.0 ** rng.uniform(-2.0, 0.0, n)
        share = 1.0 if body == "rounded" else rng.uniform(0.0, 1.0, n) * (rng.random(n) < 0.8)
        known["fillet"] = 0.5 * known["thickness"] * share
        axial, across = solid_moments(known["thickness"], known["fillet"])
    radius, gravity = 10.0 ** rng.uniform(-2.0, 1.0, n), 10.0 ** rng.uniform(-0.5, 1.5, n)
    unit = np.sqrt(radius / gravity)
    known |= {
        "axial_moment": axial, "transverse_moment": across, "radius": radius, "gravity": gravity,
        "tilt": rng.uniform(-1.4, 1.4, n) * 10.0 ** rng.uniform(-3.0, 0.0, n),
        "tilt_rate": rng.uniform(-1.5, 1.5, n) / unit * (rng.random(n) < 0.7) * 10.0 ** rng.uniform(-3.0, 0.0, n),
        "precession_rate": rng.uniform(-3.0, 3.0, n) / unit * (rng.random(n) < 0.9),
        "roll_rate": rng.uniform(-3.0, 3.0, n) / unit * (rng.random(n) < 0.9),
    }  # fmt: skip
    return np.stack([known[name] for name in PARAMETERS])


def reduce_starts(given: Array, body: str) -> tuple[dict[str, Array], npt.NDArray[np.int32]]:
    """Return the results of the reduction for starts, and their endings."""
    measures, counts = np.empty((len(REDUCED), given.shape[1])), np.empty((1, given.shape[1]), np.int32)
    kernel_of(body, "reduce").load()(given, float(NAMES.index(body)), FALL, 1, measures, counts)
    return dict(zip(REDUCED, measures, strict=True)), counts[ENDING]


def audit_errors(cells: int, rng: np.random.Generator) -> bool:
    """Compare the engine with the reduction for bodies that have both; return whether every promise holds."""
    fine = True
    print(
        f"{'':8}{'cells':>8}{'endings':>9}{'extremes':>10}{'beyond 2 x stated':>19}{'periods':>10}{'without':>9}"
    )
    for body in NAMES[:FIRST_WITH_POLES]:
        given = draw_starts(body, cells, rng)
        engine = body_runner.run(given, body, duration=1e5, fall_tilt=FALL)
        exact, ending = reduce_starts(given, body)
        other = int((engine.ending != ending).sum())
        apart = np.fmax(np.abs(engine.least - exact["tilt_min"]), np.abs(engine.greatest - exact["tilt_max"]))
        bounded = ending == BOUNDED
        beyond = (apart > 2.0 * engine.tilt_error + np.nan_to_num(exact["tilt_error"]) + 2e-14)[
            bounded
        ].mean()
        late = np.abs(engine.period / exact["nutation_period"] - 1.0)[bounded]
        print(
            f"{body:8}{cells:8d}{other:9d}{np.nanmax(apart):10.1e}{beyond:19.2e}{np.nanmax(late):10.1e}"
            f"{np.isnan(late).sum():9d}"
        )
        fine &= bool(other == 0 and np.nanmax(apart) < TOLERANCE and beyond <= MOST_BEYOND)
        fine &= bool(np.nanmax(late) < PERIOD and np.isnan(late).mean() < MOST_BEYOND)
    return fine


def audit_space(count: int, rng: np.random.Generator) -> bool:
    """Compare the reduction with rigid bodies in space; return whether all agree."""
    worst = 0.0
    for body in NAMES:
        given = draw_starts(body, max(1, count // len(NAMES)), rng)
        exact, ending = reduce_starts(given, body)
        # at rest the first turn is not an event, and near a separatrix both lose digits
        known = (ending == BOUNDED) & (given[PARAMETERS.index("tilt_rate")] != 0.0)
        known &= ~(np.abs(exact["separatrix"]) < 1e-3)
        for cell in np.flatnonzero(known):
            one = dict(zip(PARAMETERS, given[:, cell].tolist(), strict=True))
            unit, tilt = math.sqrt(one["radius"] / one["gravity"]), one["tilt"]
            lengths = (one[name] for name in ("tube", "thickness", "fillet", "offset", "flattening"))
            core, shift, edge, square = arc_of(NAMES.index(body), *lengths)
            shift = -shift if body == NAMES[RIM] and tilt < 0.0 else shift
            rolling = Body(core, shift, edge, one["axial_moment"], one["transverse_moment"], square)
            o, s = (
                unit * one["precession_rate"] * math.cos(tilt),
                unit * (one["roll_rate"] + one["precession_rate"] * math.sin(tilt)),
            )
            found = np.array(rolling.extremes(tilt, unit * one["tilt_rate"], o, s, end=1e4))
            told = [exact[name][cell] for name in ("tilt_min", "tilt_max", "nutation_period")]
            scale = np.array([1.0, 1.0, found[2]])
            apart = float((np.abs(found - [told[0], told[1], told[2] / unit]) / scale).max())
            if apart > NEAR:
                print(f"{body}: difference {apart:.1e}: {one}")
            worst = max(worst, apart)
        print(f"{body:8}{known.sum():6d} motions, largest difference so far {worst:.1e}")
    return worst <= NEAR


PARTS: dict[str, tuple[Callable[[int, np.random.Generator], bool], int]] = {
    "errors": (audit_errors, 25_000),
    "space": (audit_space, 2000),
}


def main() -> None:
    """Run the requested part."""
    if len(sys.argv) < 2 or sys.argv[1] not in PARTS:
        sys.exit(__doc__)
    audit, count = PARTS[sys.argv[1]]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else count
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else time.time_ns() % 2**32
    print(f"seed {seed}")
    sys.exit(0 if audit(count, np.random.default_rng(seed)) else 1)


if __name__ == "__main__":
    main()
