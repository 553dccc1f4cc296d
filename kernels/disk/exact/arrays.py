"""Rows of the arrays that the exact reduction writes; as `kernels.disk.arrays`."""

#: Measures of the exact reduction: extreme tilts [rad], nutation period [s], saddle of the potential minus the energy,
#: over m g R [1], estimated error of the extreme tilts [rad]. NaN where a measure does not exist.
EXACT_MEASURES = ("tilt_min", "tilt_max", "nutation_period", "separatrix", "tilt_error")
EXACT_TILT_MIN, EXACT_TILT_MAX, EXACT_NUTATION_PERIOD, EXACT_SEPARATRIX, EXACT_TILT_ERROR = range(
    len(EXACT_MEASURES)
)

#: Counts of the exact reduction: code of `kernels.disk.endings`, wells of the potential (1, 2; 0 where unknown).
EXACT_COUNTS = ("ending", "wells")
EXACT_ENDING, EXACT_WELLS = range(len(EXACT_COUNTS))
