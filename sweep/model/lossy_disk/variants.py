"""The compiled variants of the integration with losses: a request pays for the laws that it has, and for no others."""

from functools import lru_cache

from sweep.model.kernel import Kernel
from sweep.model.lossy_disk.tables import NO_AIR

_MODULE = "kernels.lossy_disk.integrate"


@lru_cache
def integrator(
    *, contour: bool, damping: bool, rolling: bool, pivoting: bool, air: str, slips: bool
) -> Kernel:
    """Return the kernel with some laws and no others, as `kernels.lossy_disk.integrate.variant` names it.

    Parameters
    ----------
    contour, damping, rolling, pivoting : bool
        Whether there is dry contour friction, viscous contour friction, rolling friction, and pivoting friction.
    air : str
        The law of the air.
    slips : bool
        Whether the friction that rolling needs is held against a friction coefficient.
    """
    # the kernels themselves, which would say the name, are not imported before they are used
    rubbing = ("" if contour else "_viscous") if damping else ("_dry" if contour else "_bare")
    drag = "" if air == NO_AIR else f"_{air}"
    laws = (rubbing, "_rolling" * rolling, "_pivoting" * pivoting, drag, "_slipping" * slips)
    return Kernel(_MODULE, "integrate" + "".join(laws), seconds=8.0)
