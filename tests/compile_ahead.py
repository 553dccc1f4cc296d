"""Compile in advance: the kernels of `eulerdisk warmup`, and others that tests need.

scripts/test runs this first. A kernel that is missing here is compiled by the first test that uses it.
"""

import sys
from functools import partial

import lossy_referee

import sweep
from sweep.commands.warmup import perform, usual_tasks

LOSSES = [
    ("rolling", {"roll_rate": 3.0, "tilt": "5deg", "contour_friction": "1um"}),
    (
        "toy",
        {
            "body": "rim",
            "thickness": "12.8mm",
            "fillet": "2mm",
            "tilt": "60deg",
            "scaled_precession_rate": 2.0,
        },
    ),
]
SYSTEMS = ["henon_heiles", "kapitza", "magnets"]


def tasks():
    """Return all tasks by name."""
    found = dict(usual_tasks()[0])
    found["referee"] = partial(lossy_referee.run, lossy_referee.starts(tilt=0.1, roll_rate=1.0), duration=0.1)
    found |= {f"losses {k}": partial(sweep.run, LOSSES[k][0], **LOSSES[k][1]) for k in range(len(LOSSES))}
    return found | {name: partial(sweep.simulate, name, duration=1e-3) for name in SYSTEMS}


if __name__ == "__main__":
    for name, seconds in perform(tasks()):
        sys.stdout.write(f"{name:<20} {seconds:6.1f} s\n")
