"""Random starts of lossy disks in SI: every law, alone and mixed, and every kind of motion."""

import math

import lossy_referee as referee
import numpy as np

from kernels.lossy_disk import arrays

AIR_LAWS = ("none", "moffatt", "bildsten")
KINDS = ("wobble", "nutating", "tumbling", "nearly upright", "slow")


def wobble(inclination, alpha):
    """Return scaled tilt, precession rate and roll rate of the wobble with a resting center."""
    rate = np.sqrt(2.0 / (alpha * np.sin(inclination)))
    return 0.5 * math.pi - inclination, rate, -rate * np.cos(inclination)


def motions(kind, n, alpha, rng):
    """Return scaled tilt, tilt rate, precession rate and roll rate of n starts of one kind."""
    if kind in ("wobble", "nutating"):
        tilt, turning, rolling = wobble(10.0 ** rng.uniform(-1.7, -0.2, n), alpha)
        width = 1e-3 if kind == "wobble" else 0.1
        return tilt, rng.normal(0, width, n), turning * (1.0 + rng.normal(0, width, n)), rolling
    if kind == "tumbling":
        return rng.uniform(-1.2, 1.2, n), *(rng.normal(0, 1, n) * (rng.random(n) < 0.7) for _ in range(3))
    tilt = 10.0 ** rng.uniform(-4, -1.5, n)
    size = 1.5 if kind == "nearly upright" else 0.1
    rates = (rng.normal(0, size, n) * (rng.random(n) < 0.7) for _ in range(2))
    return tilt, 1e-2 * rng.normal(0, 1, n) * (rng.random(n) < 0.5), *rates


def random_cells(n, rng, kinds=KINDS):
    """Return starts by air law, each float64[len(PARAMETERS), about n/3]; some have a friction coefficient."""
    cells = {}
    for air in AIR_LAWS:
        some = -(-n // (len(AIR_LAWS) * len(kinds)))
        for kind in kinds:
            alpha, radius, gravity = rng.uniform(0.3, 1.0, some), 10.0 ** rng.uniform(-2, 0, some), 9.81
            unit, mass = np.sqrt(radius / gravity), 10.0 ** rng.uniform(-2, 1, some)
            tilt, *rates = motions(kind, some, alpha, rng)
            # Mirror half of them.
            side = rng.choice((-1.0, 1.0), some)
            arms = 10.0 ** rng.uniform(-4, -1.5, (4, some)) * (rng.random((4, some)) < 0.45)
            if kind == "slow":
                # Most of these come to rest.
                arms[0] = 10.0 ** rng.uniform(-2.5, -1.0, some)
            drag = 10.0 ** rng.uniform(-5, -3, some)
            # Convert coefficients of the scaled air laws into viscosities for a density of 1.
            film = 4.0 * mass * drag / (math.pi * radius * unit)
            layer = 2.0 * np.sqrt(gravity) * (mass * drag) ** 2 / radius**4.5
            given = referee.starts(
                tilt=side * tilt, tilt_rate=side * rates[0] / unit, precession_rate=side * rates[1] / unit,
                roll_rate=rates[2] / unit, alpha=alpha, radius=radius, gravity=gravity, mass=mass,
                rolling_friction=arms[0] * radius, pivoting_friction=arms[1] * radius,
                contour_friction=arms[2] * radius, contour_damping=0.1 * arms[3] * mass * gravity * radius * unit,
                air_viscosity={"none": 0.0, "moffatt": film, "bildsten": layer}[air], air_density=1.0,
                friction=np.where(rng.random(some) < 0.2, rng.uniform(0.05, 1.0, some), np.inf),
            )  # fmt: skip
            cells[air] = np.concatenate([cells[air], given], axis=1) if air in cells else given
    return cells


def near_steady(n, rng):
    """Return scaled starts at or almost at rest near a steady motion, each slowed by one contact loss."""
    alpha, tilt, turning = (
        rng.uniform(0.2, 1.0, n),
        rng.uniform(0.05, 1.45, n),
        10.0 ** rng.uniform(-0.3, 0.7, n),
    )
    # The tilt acceleration vanishes.
    pull = 4.0 * np.sin(tilt) + (2.0 + alpha) * turning**2 * np.sin(2.0 * tilt)
    rolling = -pull / (4.0 * (1.0 + alpha) * turning * np.cos(tilt))
    off, tilt_rate = (10.0 ** rng.uniform(low, -2, n) * rng.choice((-1.0, 1.0), n) for low in (-8, -9))
    law, arm = rng.integers(0, 3, n), 10.0 ** rng.uniform(-4, -1.5, n)
    return referee.starts(
        tilt=tilt, tilt_rate=np.where(rng.random(n) < 0.5, 0.0, tilt_rate), precession_rate=turning,
        roll_rate=rolling * (1.0 + off), alpha=alpha, contour_friction=np.where(law == 0, arm, 0.0),
        contour_damping=np.where(law == 1, arm, 0.0), pivoting_friction=np.where(law == 2, arm, 0.0),
    )  # fmt: skip


def without(given, names):
    """Return starts without some losses: their rows of `arrays.PARAMETERS` are 0, or infinite for `friction`."""
    changed = given.copy()
    for name in names:
        changed[arrays.PARAMETERS.index(name)] = math.inf if name == "friction" else 0.0
    return changed


def barely_slipping(given, needed, rng):
    """Return starts with a friction coefficient slightly below a new maximum of what their motion needs.

    `needed` returns what one start needs at equal time intervals; starts without such a maximum are dropped.
    """
    chosen = []
    for start in given.T:
        need = needed(start)
        if len(need) < 3:
            continue
        middle, highest = need[1:-1], np.maximum.accumulate(need)[:-2]
        places = np.flatnonzero((middle > highest) & (middle >= need[2:]) & (middle < 10.0))
        if places.size:
            start = start.copy()
            start[arrays.FRICTION] = middle[rng.choice(places)] * (1.0 - 10.0 ** rng.uniform(-5, -2))
            chosen.append(start)
    return np.ascontiguousarray(np.array(chosen).T)
