"""Calls of the kernels of bodies: starts in, named results out."""

import math

import kernel_runner
import numpy as np

from kernels.bodies.arrays import REDUCED
from kernels.bodies.shapes import NAMES, solid_moments, torus_moments
from kernels.disk.arrays import COUNTS, ENDING, MEASURES
from sweep.model.bodies.exact import kernel_of
from sweep.model.bodies.model import Bodies
from sweep.model.bodies.shape import has_poles

FALL_TILT = math.radians(88.0)
TORUS = {"tube": 0.25, "axial_moment": 0.609375, "transverse_moment": 0.3203125}


def run(given, body, *, duration=300.0, step=0.0, fall_tilt=FALL_TILT, tolerance=1e-8):
    """Integrate starts of a body by name; a body that rolls through its poles is reduced instead."""
    n = given.shape[1]
    measures, counts = np.full((len(MEASURES), n), -777.0), np.full((len(COUNTS), n), -777, np.int32)
    if has_poles(body):
        known = reduce(given, body, fall_tilt)
        counts[ENDING] = known["ending"]
        for row, name in enumerate(MEASURES):
            measures[row] = known.get(name, np.nan)
    else:
        settings = np.array([duration, step, fall_tilt, tolerance, float(NAMES.index(body))])
        Bodies.integrate.load()(np.ascontiguousarray(given), settings, measures, counts)
    return kernel_runner.Results.of(measures, counts)


def reduce(given, body, fall_tilt=FALL_TILT):
    """Return the reduction's measures of starts by name, and the endings."""
    n = given.shape[1]
    measures, counts = np.full((len(REDUCED), n), -777.0), np.full((1, n), -777, np.int32)
    kernel_of(body, "reduce").load()(
        np.ascontiguousarray(given), float(NAMES.index(body)), fall_tilt, 1, measures, counts
    )
    return dict(zip(REDUCED, measures, strict=True)) | {"ending": counts[0]}


def drawn(body, rng):
    """Return random lengths of a body by input name, its moments, and its `kernels.bodies.shapes.Arc`."""
    if body == "torus":
        tube = rng.uniform(0.0, 0.9)
        return {"tube": tube}, torus_moments(tube, rng.random() < 0.5), (1.0 - tube, 0.0, tube, 1.0)
    if body == "ball":
        offset, across = rng.uniform(-0.8, 0.8), rng.uniform(0.2, 0.6)
        return {"offset": offset}, (across * rng.uniform(0.5, 1.5), across), (0.0, offset, 1.0, 1.0)
    if body == "arc":
        fillet, offset, across = rng.uniform(0.0, 1.0), rng.uniform(-0.5, 0.5), rng.uniform(0.2, 0.6)
        return (
            {"fillet": fillet, "offset": offset},
            (across * rng.uniform(0.5, 1.5), across),
            (1.0 - fillet, offset, fillet, 1.0),
        )
    if body == "spheroid":
        q, across = rng.uniform(0.4, 2.0), rng.uniform(0.2, 0.6)
        offset = 0.8 * q * rng.uniform(-1.0, 1.0) * (rng.random() < 0.7)
        lengths = {"offset": offset, "flattening": 1.0 - q}
        return lengths, (across * rng.uniform(0.5, 1.5), across), (0.0, offset, 1.0, q * q)
    thickness = rng.uniform(0.01, 1.0)
    fillet = 0.5 * thickness if body == "rounded" else rng.uniform(0.0, 0.5 * thickness)
    lengths = {"thickness": thickness} | ({"fillet": fillet} if body == "rim" else {})
    return lengths, solid_moments(thickness, fillet), (1.0 - fillet, 0.5 * thickness - fillet, fillet, 1.0)
