"""Closed forms of the lossy wobble with a resting center, leading order in the inclination (scaled)."""

import math

import lossy_cells
import lossy_referee as referee

LAWS = ("contour", "damping", "moffatt", "bildsten", "rolling")

#: The inclination falls as (t_f - t)^n.
EXPONENTS = {"contour": 2 / 3, "damping": 1 / 2, "moffatt": 1 / 3, "bildsten": 4 / 9, "rolling": 2}


def time_to_flat(law, coefficient, alpha, inclination):
    """Return the time to zero inclination; for air laws `coefficient` is the coefficient of the torque."""
    rate = math.sqrt(2.0 / alpha)
    factor = {
        "contour": 1.0 / rate,
        "damping": 3.0 * alpha / 8.0,
        "moffatt": alpha / 4.0,
        "bildsten": 2.0 / 3.0 / (2.0 / alpha) ** 1.25,
        "rolling": 3.0 / rate,
    }[law]
    return factor / coefficient * inclination ** (1.0 / EXPONENTS[law])


def start(law, turns, alpha, inclination):
    """Return a start with one law, its air law and a coefficient small enough that it takes about `turns`."""
    duration = turns * 2.0 * math.pi * math.sqrt(alpha * inclination / 2.0)
    coefficient = time_to_flat(law, 1.0, alpha, inclination) / duration
    tilt, turning, rolling = lossy_cells.wobble(inclination, alpha)
    words = {
        "contour": {"contour_friction": coefficient},
        "damping": {"contour_damping": coefficient},
        "moffatt": {"air_viscosity": 4.0 * coefficient / math.pi},
        "bildsten": {"air_viscosity": 2.0 * coefficient**2, "air_density": 1.0},
        "rolling": {"rolling_friction": coefficient},
    }[law]
    given = referee.starts(tilt=tilt, precession_rate=turning, roll_rate=rolling, alpha=alpha, **words)
    return given, law if law in lossy_cells.AIR_LAWS else "none", coefficient


def time_between(run, law, turns, alpha, first, last):
    """Return the time `run` takes between two inclinations over the difference of the closed forms."""
    given, air, coefficient = start(law, turns, alpha, first)
    found = run(given, air=air, duration=1e5, flat_tilt=0.5 * math.pi - last)
    forms = [time_to_flat(law, coefficient, alpha, inclination) for inclination in (first, last)]
    return float(found.end_time[0]) / (forms[0] - forms[1])


def exponent(run, law, turns, alpha, first, last):
    """Return the exponent n between inclinations `first` and `last`, followed to a hundredth of `last`.

    The closed form gives the time from there to the end.
    """
    given, air, coefficient = start(law, turns, alpha, 1.2 * first)
    ends = [0.5 * math.pi - inclination for inclination in (first, last, 0.01 * last)]
    early, late, end = (float(run(given, air=air, duration=1e5, flat_tilt=tilt).end_time[0]) for tilt in ends)
    end += time_to_flat(law, coefficient, alpha, 0.01 * last)
    return math.log(first / last) / math.log((end - early) / (end - late))
