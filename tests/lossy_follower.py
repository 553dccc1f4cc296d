"""Calls of the scalar integrator of the lossy disk: one start in, named results out."""

import math

import numpy as np
from lossy_referee import FLAT_TILT

from kernels.jit import kernel
from kernels.lossy_disk import arrays, follow, trajectory
from kernels.lossy_disk.arrays import BILDSTEN, LOSSES, MEASURES, MOFFATT, NONE, SAMPLES, TILT_MIN

AIR_LAWS = {"none": NONE, "moffatt": MOFFATT, "bildsten": BILDSTEN}


@kernel
def _followed(start, settings, horizon, reach, piece):
    """Follow a start to its ending, in pieces of at least the scaled time `piece`, as when resumed from lanes."""
    begun = trajectory.beginning(start, settings)
    case, unit, state = trajectory.case_of(begun, start[arrays.TILT, 0], settings), begun.unit, begun.state
    motion, event = follow.begun(state, case, reach)
    tilt, pieces, ending = follow.tilt_of(state), 0, follow.ending_of(event)
    record = follow.Record(tilt, tilt, math.nan, 0.0, 0.0)
    while ending == follow.MOVING:
        motion, record, ending = follow.follow(
            motion, record, case, horizon / unit, reach, motion.time + piece
        )
        pieces += 1
    return motion, record, ending, pieces


class Followed:
    """The end of a motion: its ending, its measures by `arrays.MEASURES` in SI, and its scaled state."""

    def __init__(self, start, found):
        motion, self.record, self.ending, self.pieces = found
        unit, (turned, path, *lost) = math.sqrt(start[arrays.RADIUS] / start[arrays.GRAVITY]), motion.ledger
        record = self.record
        values = (
            record.least, record.greatest, unit * motion.time, math.atan2(motion.state[0], motion.state[1]),
            turned, start[arrays.RADIUS] * path, *lost, unit * record.breach,
        )  # fmt: skip
        self.measures = dict(zip(MEASURES[TILT_MIN:], values, strict=False))
        self.state, self.senses, self.switches, self.steps = (
            motion.state,
            motion.senses,
            record.switches,
            record.steps,
        )
        self.lost = sum(lost)

    def __getattr__(self, name):
        """Return a measure by its name."""
        return self.measures[name]


def _settings(air, relative_step, flat_tilt):
    return np.array([0.0, relative_step, flat_tilt, AIR_LAWS[air]])


def followed(
    start,
    *,
    air="none",
    horizon=100.0,
    relative_step=0.03,
    flat_tilt=FLAT_TILT,
    reach=math.inf,
    piece=math.inf,
):
    """Follow one start, float64[len(arrays.PARAMETERS)]."""
    start = np.ascontiguousarray(start)
    settings = _settings(air, relative_step, flat_tilt)
    return Followed(start, _followed(start[:, np.newaxis], settings, horizon, reach, piece))


def sampled(start, times, *, air="none", relative_step=0.03, flat_tilt=FLAT_TILT):
    """Return ending, time of the last sample, and the filled samples by `arrays.SAMPLES`."""
    samples = np.full((len(SAMPLES), len(times)), np.nan)
    settings = _settings(air, relative_step, flat_tilt)
    ending, filled, last, _ = trajectory.trajectory(
        np.ascontiguousarray(start)[:, np.newaxis], settings, np.asarray(times, float), samples
    )
    return ending, last, dict(zip(SAMPLES, samples[:, :filled], strict=True))


def energy(state, alpha):
    """Return the energy over m g R of a scaled state (S, C, w, f, v)."""
    S, C, w, f, v = state
    s, o = f * C * C + v * S, C * (v - f * S)
    return 0.5 * (1 + alpha / 2) * w * w + 0.5 * (1 + alpha) * s * s + alpha / 4 * o * o + C


def lost_in(samples):
    """Return the sum of all losses of samples, over m g R."""
    return sum(samples[name] for name in LOSSES)


def energy_of(start):
    """Return the energy over m g R of a start."""
    S, C, unit = (
        math.sin(start[0]),
        math.cos(start[0]),
        math.sqrt(start[arrays.RADIUS] / start[arrays.GRAVITY]),
    )
    w, heading, f = unit * start[1:4]
    return energy((S, C, w, f, heading + f * S), start[arrays.ALPHA])
