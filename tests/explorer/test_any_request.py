"""Every possible request, at any place and with any words, gets an answer or a refusal in a sentence."""

import numpy as np
import pytest

from sweep.errors import RequestError
from sweep.explorer.answers import Answers
from sweep.explorer.body import SLIDERS
from sweep.model.bodies.model import BODIES

SIDES = [
    ("roll_rate", "tilt"), ("tilt", "precession_rate"), ("radius", "tilt"), ("gravity", "roll_rate"),
    ("alpha", "radius"),
]  # fmt: skip
WORDS = [
    "tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha", "radius", "gravity", "speed", "inclination",
    "scaled_roll_rate", "scaled_precession_rate", "duration", "fall_tilt", "tolerance", "criterion", "contact",
    "method",
]  # fmt: skip
VALUES = [
    0, -1, 1, 1e-300, 1e12, -1e12, "1,2,3", "1:3:4", "1:2:3:log", "uniform:1:2", "steady", "steady-slow", "", "x",
    "nan", "-1m/s", "1m", "yes", "exact", "departure:5deg", "100deg", "1e400",
]  # fmt: skip
LOSSES = ["rolling_friction", "contour_friction", "contour_damping", "air_law", "mass", "friction", "nothing"]
LOST = [0, -1, 1e-3, 0.3, 1e12, "moffatt", "bildsten", "none", "1,2", True, None, [1]]
PLACES = [0.5, 0.1, 0, -1, -0.5, 1, 2, 1e12, -1e12, 1e-300, 1.5708]
PATHS = ["plan", "command", "point", "lines", "explain", "window"]


def drawn(rng):
    """Return an address and the fields of a request; each field may be valid or not."""

    def one(choices):
        return choices[rng.integers(len(choices))]

    names = one(SIDES)
    sides = [
        {"name": name, "centre": one(PLACES), "half": one([1, 1e-9, 0.3, 5, 1e12]), "scale": scale}
        for name, scale in zip(names, one([("linear", "linear"), ("log", "linear")]), strict=True)
    ]
    words = {one(WORDS): one(VALUES) for _ in range(one([0, 1, 1, 2]))}
    base = one(["rolling", "spinning", "circling"])
    fields = {"view": {"base": base, "words": words, "x": sides[0], "y": sides[1]}}
    path = one(PATHS)
    if path == "window" or (path == "command" and one([True, False])):
        fields |= {"width": one([1, 3, 8]), "height": one([1, 2, 7]), "quantity": one(["peak_tilt", "x"])}
    elif path not in ("lines", "plan"):
        fields |= {"x": one(PLACES), "y": one(PLACES)}
        fields |= {"losses": {one(LOSSES): one(LOST)}} if one([True, False]) else {}
    return path, fields


@pytest.mark.slow_lane
def test_every_request_is_answered_or_refused(rng, count):
    """No error other than a refusal occurs, and refusals are not the majority."""
    answers, refused = Answers(None), 0
    for _ in range(count(600, 6000)):
        path, fields = drawn(rng)
        try:
            # as the server does
            with np.errstate(all="ignore"):
                answers.answer(path, fields, lambda: None)
        except RequestError:
            refused += 1
        except Exception as problem:
            raise AssertionError(path, fields) from problem
    assert 0 < refused < 0.9 * count(600, 6000)


def test_sliders_reach_the_bodies_that_people_have():
    """Both ends of each slider are valid, and the range includes rings, coins, eggs and tablets."""
    met = {"tube": (0.02, 0.6), "thickness": (0.05, 1.0), "fillet": (0.0, 0.4), "offset": (-0.3, 0.3),
           "flattening": (-0.5, 0.5), "axial_moment": (0.3, 0.95), "transverse_moment": (0.2, 0.5)}  # fmt: skip
    assert met.keys() == SLIDERS.keys()
    for name, ends in met.items():
        low, high, _ = SLIDERS[name]
        assert BODIES.parameters[name].allows(np.array([low, high])).all(), name
        assert low <= ends[0] < ends[1] <= high, name
