"""The number of wells of a potential, compared with SciPy's solution of the linear pair."""

import math

import numpy as np
import pytest
from body_referee import Body, start_of
from scipy.integrate import solve_ivp

from sweep.model.disk.exact import WELLS


def meridian(body, tilt):
    """Return height, a, b and radius of curvature of a meridian, from its support function and derivatives."""
    S, C = math.sin(tilt), math.cos(tilt)
    root = math.sqrt(C * C + body.square * S * S)
    h = body.core * C + body.shift * S + body.edge * root
    slope = -body.core * S + body.shift * C + body.edge * (body.square - 1.0) * S * C / root
    bend = (
        -body.core * C
        - body.shift * S
        + body.edge
        * ((body.square - 1.0) * (C * C - S * S) / root - ((body.square - 1.0) * S * C) ** 2 / root**3)
    )
    return h, C * h - S * slope, -S * h - C * slope, h + bend


def potential(body, tilt, o, s):
    """Return the potential on a fine grid of tilts for a motion with o and s at a tilt."""
    A, axial = body.transverse, body.axial

    def right_side(theta, y):
        S, C, T = math.sin(theta), math.cos(theta), math.tan(theta)
        _, a, b, r = meridian(body, theta)
        P = (a - r * C) * y[0] - (r * S + axial / A * b) * y[1]
        D = axial * A + axial * b * b + A * a * a
        return T * y[0] - axial / A * y[1] - b * axial / D * P, -a * A / D * P

    found = []
    for end in (-1.57, 1.57):
        places = np.linspace(tilt, end, 4000)
        solution = solve_ivp(
            right_side, (tilt, end), (o, s), method="DOP853", t_eval=places, rtol=1e-11, atol=1e-13
        )
        values = []
        for theta, (along, spin) in zip(places, solution.y.T, strict=True):
            h, a, b, _ = meridian(body, theta)
            v = a * spin + b * along
            values.append(0.5 * (A * along * along + axial * spin * spin + v * v) + h)
        found.append(np.array(values))
    return np.concatenate([found[0][:0:-1], found[1]])


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_wells_are_the_minima_of_the_potential(rng, count):
    """For random starts of a torus, a ball and a spheroid with offset centers, the number of wells agrees."""
    seen = set()
    for name in ("torus", "ball", "spheroid"):
        for draw in range(count(6, 14)):
            across = rng.uniform(0.2, 0.6)
            axial, e, q = across * rng.uniform(0.4, 1.9), rng.uniform(-0.3, 0.3), rng.uniform(0.4, 1.6)
            body, lengths = {
                "torus": (Body(1.0 - abs(e), 0.0, abs(e), axial, across), {"tube": abs(e)}),
                "ball": (Body(0.0, e, 1.0, axial, across), {"offset": e}),
                "spheroid": (Body(0.0, e, 1.0, axial, across, q * q), {"offset": e, "flattening": 1.0 - q}),
            }[name]
            tilt, o, s = rng.uniform(-1.0, 1.0), rng.uniform(0.02, 1.0), rng.uniform(-0.8, 0.8)
            if draw == 0:
                # too slow to stay upright, so a torus has two wells
                tilt, o, s = 0.3, 0.1, 0.05
            given, kind = start_of(name, tilt, 0.3, o, s, axial, across, **lengths)
            counts = np.zeros(given.shape[1], np.int64)
            WELLS.load()(np.ascontiguousarray(given), float(kind), counts)
            values = potential(body, tilt, o, s)
            minima = np.sum((values[1:-1] < values[:-2]) & (values[1:-1] < values[2:]))
            assert counts[0] == minima, (name, tilt, o, s)
            seen.add(int(minima))
    assert seen == {1, 2}


@pytest.mark.compiled
def test_a_rim_has_the_wells_of_its_edge(rng):
    """Only wells at tilts on its own side count, equally for mirror images; there is none if it always falls back."""
    seen = set()
    # the first falls back to its edge from everywhere
    known = [(0.28, 0.75, -1.32), (0.8, 0.1, 0.1)]
    drawn = [(rng.uniform(0.05, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-1.5, 1.5)) for _ in range(10)]
    for tilt, o, s in (*known, *drawn):
        body = Body(0.95, 0.15, 0.05, 0.5, 0.27)
        values = potential(body, tilt, o, s)
        # the places of `potential`, starting at the least tilt
        places = np.concatenate([np.linspace(tilt, -1.57, 4000)[:0:-1], np.linspace(tilt, 1.57, 4000)])
        own = values[places > 0.0]
        minima = np.sum((own[1:-1] < own[:-2]) & (own[1:-1] < own[2:]))
        for side in (1.0, -1.0):
            lengths = {"thickness": 0.4, "fillet": 0.05}
            given, kind = start_of("rim", side * tilt, 0.0, side * o, s, 0.5, 0.27, **lengths)
            counts = np.zeros(given.shape[1], np.int64)
            WELLS.load()(np.ascontiguousarray(given), float(kind), counts)
            assert counts[0] == minima, (side, tilt, o, s)
        seen.add(int(minima))
    assert seen == {0, 1}
