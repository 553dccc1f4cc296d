"""The figure of one explained cell of an atlas with losses: its motion, to its end."""

from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from sweep.checks.explain import Explanation
from sweep.errors import RequestError
from sweep.figures.disk import stopping_plots
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.motion.request import MotionRequest
from sweep.motion.trajectory import simulate

if TYPE_CHECKING:
    import xarray as xr


def figure(explanation: Explanation) -> Figure:
    """Draw the motion of an explained cell by `sweep.simulate`, with its verdict in the title.

    Raises
    ------
    RequestError
        If the cell has no motion, or one that cannot be integrated.
    """
    return stopping_plots.figure(motion_of(explanation))


def motion_of(explanation: Explanation) -> "xr.Dataset":
    """Return the motion of an explained cell, for the duration of its atlas at most; raises as `figure` does."""
    spec = explanation.spec
    verdict = LOSSY_DISK.variables["stability"].flag(explanation.stored["stability"])
    # a friction coefficient without a limit is no number that a request can say
    start: dict[str, Any] = dict(explanation.start) | {name: getattr(spec, name) for name in spec.constants}
    impossible = [name for name in ("precession_rate", "roll_rate") if not abs(start[name]) < float("inf")]
    if impossible:
        raise RequestError(
            f"This cell has no motion to draw: no {' and no '.join(impossible)} keeps its tilt constant.",
            hint="Leave --plot out, or name another cell.",
        )
    settings = {name: getattr(spec, name) for name in ("duration", "step", "flat_tilt", "air_law")}
    title = f"{spec.title or 'The motion of one cell'}: {verdict} by {spec.criterion}"
    return simulate(MotionRequest.read(**start, **settings, title=title))
