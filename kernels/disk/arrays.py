"""placeholder until the kernels' branch is merged."""

PARAMETERS = ("tilt", "tilt_rate", "precession_rate", "roll_rate", "alpha", "radius", "gravity")
SETTINGS = ("duration", "step", "fall_tilt", "tolerance")
MEASURES = ("tilt_min", "tilt_max", "fall_time", "nutation_period", "energy_drift", "tilt_error")
COUNTS = ("ending", "steps", "refinements")
EXACT_MEASURES = ("tilt_min", "tilt_max", "nutation_period", "separatrix", "tilt_error")
EXACT_COUNTS = ("ending", "wells")
CONTACT = ("least_normal_force", "friction_needed")
