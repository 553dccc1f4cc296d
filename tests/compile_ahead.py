"""Compile what tests need beside the kernels of `eulerdisk warmup`: scripts/test runs it while one processor is idle.

None of it is compiled by that command at the same time. What is missing here is compiled by the first test with it.
"""

import lossy_referee

import sweep

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

if __name__ == "__main__":
    lossy_referee.run(lossy_referee.starts(tilt=0.1, roll_rate=1.0), duration=0.1)
    for preset, words in LOSSES:
        sweep.run(preset, **words, progress=False)
    for preset in SYSTEMS:
        sweep.simulate(preset, duration=1e-3)
