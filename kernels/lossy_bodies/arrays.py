"""The rows of the arrays that Python and the kernels of bodies with losses exchange; see `kernels.lossy_disk.arrays`.

Measures and counts are the same as for the disk with losses.
"""

from kernels.bodies import arrays as bodies
from kernels.lossy_disk import arrays as disk

#: Start of a cell: the start of a body without losses; mass, loss coefficients and friction of the disk with losses.
PARAMETERS = bodies.PARAMETERS + disk.PARAMETERS[disk.MASS :]
globals().update(
    {name.upper(): PARAMETERS.index(name) for name in (*disk.PARAMETERS[disk.MASS :], "radius", "gravity")}
)

#: Settings of an integration: the settings for the disk with losses, and the number of the body
#: (`kernels.bodies.shapes`).
SETTINGS = (*disk.SETTINGS, "body")
BODY = SETTINGS.index("body")

#: Settings of a single motion: the settings for the disk with losses, and the number of the body.
TRAJECTORY_SETTINGS = (*disk.TRAJECTORY_SETTINGS, "body")
TRAJECTORY_AIR_LAW, TRAJECTORY_BODY = (TRAJECTORY_SETTINGS.index(name) for name in ("air_law", "body"))
