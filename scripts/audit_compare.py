"""Check the rules of `eulerdisk compare` on random cells: how far two integrations of one start are apart.

Each start is integrated with several tolerances and with 1e-11, to the end and for 0.7 s. Differences larger than the
two integrations state are counted; the largest ratio is printed for each variable.

    python scripts/audit_compare.py 30000 7
"""

import argparse

import numpy as np

from sweep import SweepSpec
from sweep.checks.variables import Stated, allowed_of_cells
from sweep.engine.compute import compute
from sweep.model.quantity import Array

#: Tolerance [rad] and step of the coarse integration, duration [s] of both.
SETTINGS = [
    (tolerance, step, duration)
    for tolerance, step in ((1e-10, "auto"), (1e-8, "auto"), (1e-5, "auto"), (1e-3, "auto"), (1e-2, 0.05))
    for duration in (300.0, 0.7)
]
FINE = 1e-11
VARIABLES = ("tilt_min", "tilt_max", "peak_tilt", "amplification", "fall_time", "nutation_period")


def random_starts(count: int, seed: int) -> dict[str, Array]:
    """Return starts of disks of any shape, with tilts and rates over five decades, some of them zero."""
    rng = np.random.default_rng(seed)

    def signed(low: float, high: float, signs: list[int]) -> Array:
        return np.asarray(rng.choice(signs, count) * 10.0 ** rng.uniform(low, high, count))

    return {
        "tilt": signed(-5.0, 0.1, [-1, 1]),
        "tilt_rate": signed(-4.0, 1.0, [-1, 0, 1]),
        "precession_rate": signed(-2.0, 1.3, [-1, 0, 1]),
        "roll_rate": signed(-2.0, 1.3, [-1, 0, 1]),
        "alpha": rng.uniform(0.1, 1.0, count),
        "radius": 10.0 ** rng.uniform(-2.0, 0.0, count),
        "gravity": np.full(count, 9.81),
    }


def main() -> None:
    """Print one line for each setting, and the totals."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("cells", type=int)
    parser.add_argument("seed", type=int)
    request = parser.parse_args()
    starts = random_starts(request.cells, request.seed)
    values = beyond = flips = 0
    for tolerance, step, duration in SETTINGS:
        specs = (
            SweepSpec(tolerance=tolerance, step=step, duration=duration),
            SweepSpec(tolerance=FINE, duration=duration),
        )
        new, fine = (Stated(spec, compute(spec, starts)) for spec in specs)
        alike = new.columns["ending"] == fine.columns["ending"]
        flips += int((~alike).sum())
        shares = []
        for name in VARIABLES:
            quantity = specs[0].model.variables[name]
            apart = np.abs(new.columns[name] - fine.columns[name])
            judged = alike & np.isfinite(apart)
            share = apart[judged] / allowed_of_cells(quantity, new, fine, starts)[judged]
            values, beyond = values + share.size, beyond + int((share > 1.0).sum())
            shares.append(f"{name} {share.max(initial=0.0):.2g}")
        print(f"tolerance {tolerance:g}, step {step}, {duration:g} s: {', '.join(shares)}", flush=True)
    print(f"{beyond} of {values} values differ by more than allowed; {flips} different endings")


if __name__ == "__main__":
    main()
