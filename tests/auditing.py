"""Right and wrong atlases for the tests of the audit."""

from functools import lru_cache

import numpy as np

import sweep
from sweep.checks.verify import findings, verify
from sweep.model.disk.exact import AUDIT
from sweep.model.disk.initial_conditions import circling
from sweep.model.disk.tables import ENDINGS as TABLE
from sweep.request.sources import Range
from sweep.request.spec import SweepSpec

PRESETS = ("rolling", "spinning", "circling")
ENDINGS = {each.name: each.code for each in TABLE}


def coarse(preset, **changes):
    """Return a preset with 40 x 30 cells over its own ranges."""
    spec = SweepSpec.preset(preset)
    for name in spec.axes:
        axis = getattr(spec, name)
        count = 30 if name == "tilt" else 40
        spec = spec.replace(**{name: Range(axis.start, axis.stop, count, axis.spacing)})
    return spec.replace(**changes)


@lru_cache
def atlas(preset):
    """Return the coarse atlas of a preset, which must not be changed."""
    return sweep.run(coarse(preset))


def flags(audited):
    """Return the name of each cell's flag."""
    return np.array(list(AUDIT.variables["audit"].flags.values()))[audited.audit.values]


def counts(dataset):
    """Return the number of cells for each flag that occurs in the audit."""
    return {name: count for name, count in findings(verify(dataset)).counts.items() if count}


def changed(dataset, place, **values):
    """Return a copy of an atlas with other values in the cell at the given indices."""
    copy = dataset.copy(deep=True)
    for name, value in values.items():
        copy[name].values[place] = value
    return copy


def moved(dataset, place, low=0.0, high=0.0):
    """Return a copy with the extremes of one cell moved [rad], and everything derived from them updated."""
    copy = changed(
        dataset,
        place,
        tilt_min=dataset.tilt_min.values[place] + low,
        tilt_max=dataset.tilt_max.values[place] + high,
    )
    spec = SweepSpec.from_canonical(dataset.attrs["sweep_spec"])
    least, greatest = (float(copy[name].values[place]) for name in ("tilt_min", "tilt_max"))
    start = float(dataset.tilt[place[spec.axes.index("tilt")]]) if "tilt" in spec.axes else spec.tilt
    steady = start if circling(spec) else 0.0
    reach = max(abs(least - steady), abs(greatest - steady))
    before = max(abs(float(dataset[name].values[place]) - steady) for name in ("tilt_min", "tilt_max"))
    scale = before / float(dataset.amplification.values[place])
    # This code did not make these numbers, so their integration must not be repeated.
    copy = copy.assign_attrs(kernel_hash="0" * 64)
    copy = changed(copy, place, peak_tilt=max(abs(least), abs(greatest)), amplification=reach / scale)
    return changed(copy, place, stability=sweep.reclassify(copy, spec.criterion).stability.values[place])
