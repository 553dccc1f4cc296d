"""The four passes of a system's lanes, without the layers above them."""

import numpy as np

from kernels.system.lanes import LEGS
from sweep.model.system.model import model_of
from sweep.request.system_file import read_system


def run(text, starts, duration=None, tolerance=1e-11, step=0.0):
    """Return endings (3, n), and the states, time and extremes of each pass, shape (3, rows, n)."""
    model = model_of(read_system(text))
    n = next(len(each) for each in starts.values())
    rows = np.array(
        [np.broadcast_to(starts.get(name, row.default), n) for name, row in model.parameters.items()]
    )
    measures, counts = np.full((len(model.measures), n), np.nan), np.zeros((len(model.counts), n), np.int32)
    settings = np.array([duration or model.definition.duration, step, tolerance])
    model.integrate.load()(np.ascontiguousarray(rows, float), settings, measures, counts)
    return counts[: len(LEGS)], measures.reshape(len(LEGS), -1, n), counts[len(LEGS) :]
