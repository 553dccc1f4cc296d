"""An independent motion of a lossy body of revolution: Newton and Euler in space, by SciPy.

State and units are those of `body_referee`, followed by the quantities of `LEDGER`. The laws act as their words say:
rolling friction against the horizontal part of the angular velocity, pivoting friction against its vertical part,
contour friction against the motion of the contact over the body, along its track. With `soft` dry friction has no jump:
at a rate x it is x / sqrt(x^2 + soft^2) of its largest value.
"""

import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from body_referee import UP, Body, cross
from body_runner import drawn
from scipy.integrate import solve_ivp

from kernels.bodies.shapes import NAMES
from kernels.lossy_bodies.arrays import PARAMETERS, SETTINGS
from kernels.lossy_disk.arrays import COUNTS, MEASURES
from sweep.model.kernel import Kernel

LEDGER = (
    "heading_turned", "path_length", "rolling_loss", "pivoting_loss", "contour_loss", "damping_loss", "air_loss",
)  # fmt: skip
FLAT_TILT = math.radians(85.0)
ARMS = ("rolling_friction", "pivoting_friction", "contour_friction")

#: The variant with all laws except Bildsten's: each variant takes a quarter of a minute to compile.
WITH_ALL_LAWS = "integrate_rolling_pivoting_moffatt_slipping"


@dataclass(frozen=True)
class Lossy:
    """A body, its lever arms over R, its scaled damping and the air film under its face."""

    body: Body
    rolling: float = 0.0
    pivoting: float = 0.0
    contour: float = 0.0
    damping: float = 0.0
    film: float = 0.0
    soft: float = 0.0
    two_edges: bool = False

    def right_side(self, _, y):
        """Return the derivatives of axis, angular velocity and ledger."""
        n, turning = y[:3], y[3:6]
        n_rate = cross(turning, n)
        r, r_rate = self.body.contact(n, n_rate)
        inertia = self.body.inertia(n)
        cosine = math.sqrt(1.0 - n[2] ** 2)
        across = (n[2] * UP - n) / cosine
        track, over = cross(UP, across), r_rate - cross(turning, r)
        # The contact moves over the body opposite to the roll rate.
        way, roll_rate = -over @ track, -turning @ across / cosine
        reach = way / roll_rate if roll_rate else np.linalg.norm(r - (r @ n) * n)
        horizontal = turning - turning[2] * UP
        size = math.hypot(np.linalg.norm(horizontal), self.soft)
        # A torque about the horizontal line across the track that does work only on the roll rate.
        about = -across / cosine
        dry = -self.rolling * horizontal / size
        dry = dry - self.pivoting * turning[2] / math.hypot(turning[2], self.soft) * UP
        rubbing = self.contour * way / math.hypot(way, self.soft)
        dry = dry - rubbing * reach * about
        drag = self.film / cosine * roll_rate
        smooth = -(self.damping * way * reach + drag) * about
        whole = inertia + (r @ r) * np.eye(3) - np.outer(r, r)
        known = -cross(turning, inertia @ turning) + cross(r, UP - cross(turning, r_rate))
        free, slowed = np.linalg.solve(whole, np.stack([known + smooth, dry], axis=1)).T
        lifted = cross(r, UP)
        normal = (1.0 - UP @ cross(turning, r_rate) - free @ lifted) / (1.0 + slowed @ lifted)
        taken = (
            cross(across, -n_rate) @ UP / cosine,
            abs(way),
            -normal * (-self.rolling * horizontal / size) @ turning,
            normal * self.pivoting * turning[2] ** 2 / math.hypot(turning[2], self.soft),
            normal * rubbing * way,
            self.damping * way * way,
            drag * roll_rate,
        )
        return np.concatenate([n_rate, free + normal * slowed, taken])

    def path(self, tilt, w, o, s, times):
        """Return the motion of a start at given times like `body_referee.Body.path`, plus its ``ledger``."""
        first = self.body.start(tilt, w, o, s)
        begin, _ = self.body.contact(first[:3], np.zeros(3))
        painted = np.array([-math.sin(tilt), 0.0, -math.cos(tilt)])
        count = 6 + len(LEDGER)

        def slope(t, y):
            r, _ = self.body.contact(y[:3], np.zeros(3))
            moved = -cross(y[3:6], r), cross(y[3:6], y[count + 3 :])
            return np.concatenate([self.right_side(t, y[:count]), *moved])

        found = solve_ivp(
            slope, (0.0, times[-1]), np.concatenate([first, np.zeros(len(LEDGER)), -begin, painted]),
            method="DOP853", t_eval=times, rtol=1e-12, atol=1e-13,
        ).y.T  # fmt: skip
        rates = np.array([self.right_side(0.0, y[:count]) for y in found])
        reach = [self.body.contact(y[:3], rate[:3]) for y, rate in zip(found, rates, strict=True)]
        force = [
            UP - cross(rate[3:6], r) - cross(y[3:6], r_rate)
            for y, rate, (r, r_rate) in zip(found, rates, reach, strict=True)
        ]
        centre = found[:, count : count + 3]
        return {
            "axis": found[:, :3], "turning": found[:, 3:6], "centre": centre, "painted": found[:, count + 3 :],
            "contact": centre + np.array([r for r, _ in reach]), "force": np.array(force),
            "ledger": found[:, 6:count],
        }  # fmt: skip

    def energy(self, y):
        """Return the energy of the body plus its losses."""
        return self.body.energy(y[:6]) + sum(y[8:])

    def follow(self, start, end, flat=FLAT_TILT, method="DOP853", accuracy=1e-11):
        """Return SciPy's solution from (tilt, w, o, s), up to flat or to a vanishing dry rate, and its tilts."""

        def is_flat(_, y):
            return math.sin(flat) - abs(y[2])

        def turns(_, y):
            return cross(y[3:6], y[:3])[2]

        def stops(_, y):
            return y[3:6] @ (y[:3] - y[2] * UP) if not self.soft else 1.0

        def spins(_, y):
            return y[5] if self.pivoting and not self.soft else 1.0

        def edge(_, y):
            return y[2] if self.two_edges else 1.0

        is_flat.terminal = stops.terminal = spins.terminal = edge.terminal = True
        begun = np.concatenate([self.body.start(*start), np.zeros(len(LEDGER))])
        found = solve_ivp(
            self.right_side, (0.0, end), begun, method=method, rtol=accuracy, atol=1e-2 * accuracy,
            events=[is_flat, stops, spins, edge, turns],
        )  # fmt: skip
        met = [each for each in found.y_events if len(each)]
        x, y, z = np.concatenate([found.y[:, [0, -1]].T, *met])[:, :3].T
        return found, np.arctan2(z, np.hypot(x, y))


def starts(n=1, **parameters):
    """Return float64[len(PARAMETERS), n]: radius, gravity, mass 1, no slip, other parameters default to 0."""
    given = {"radius": 1.0, "gravity": 1.0, "mass": 1.0, "friction": math.inf, **parameters}
    return np.stack([np.broadcast_to(np.float64(given.get(name, 0.0)), n) for name in PARAMETERS])


def run(given, body, variant=WITH_ALL_LAWS, **settings):
    """Integrate starts of a body by name; return its measures and counts."""
    values = {"duration": 30.0, "flat_tilt": FLAT_TILT, "tolerance": 1e-8, "body": NAMES.index(body)}
    row = np.array([float({**values, **settings}.get(name, 0.0)) for name in SETTINGS])
    measures = np.full((len(MEASURES), given.shape[1]), -777.0)
    counts = np.full((len(COUNTS), given.shape[1]), -777, np.int32)
    kernel = Kernel("kernels.lossy_bodies.integrate", variant).load()
    kernel(np.ascontiguousarray(given), row, measures, counts)
    return SimpleNamespace(**dict(zip((*MEASURES, *COUNTS), (*measures, *counts), strict=True)))


def some(rng, names, least=-4.0, most=-1.3):
    """Return coefficients by name, each 0 or of random magnitude."""
    return {name: 10.0 ** rng.uniform(least, most) * (rng.random() < 0.7) for name in names}


def drawn_lossy(name, rng, most=-1.3):
    """Return a random lossy body's parameters by input name, and the referee's body; arms reach 10^most.

    One in three hardly moves.
    """
    lengths, (axial, transverse), (core, shift, edge, _) = drawn(name, rng)
    calm = 0.1 if rng.random() < 0.3 else 1.0
    tilt, rates = calm * rng.uniform(-1.3, 1.3), calm * rng.normal(size=3) * (0.3, 1.0, 1.0)
    laws = some(rng, (*ARMS, "contour_damping"), most=most)
    air = some(rng, ("air_viscosity",)) if name in ("rounded", "rim") else {"air_viscosity": 0.0}
    words = {**lengths, **laws, **air, "axial_moment": axial, "transverse_moment": transverse, "tilt": tilt}
    words |= dict(zip(("tilt_rate", "precession_rate", "roll_rate"), rates, strict=True))
    body = Body(core, -shift if name == "rim" and tilt < 0.0 else shift, edge, axial, transverse)
    film = 0.25 * math.pi * air["air_viscosity"] * core**3
    arms = (laws[each] for each in ARMS)
    return words, Lossy(body, *arms, laws["contour_damping"], film, two_edges=name == "rim")


def scaled(words):
    """Return (tilt, w, o, s) of a start with radius and gravity 1."""
    tilt, turn = words["tilt"], words["precession_rate"]
    return tilt, words["tilt_rate"], turn * math.cos(tilt), words["roll_rate"] + turn * math.sin(tilt)
