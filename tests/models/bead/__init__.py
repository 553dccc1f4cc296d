"""A bead on a hoop that turns about its vertical diameter; its bottom is stable while hoop_rate^2 < gravity/radius:
angle'' = hoop_rate^2 sin(angle) cos(angle) - (gravity/radius) sin(angle), the angle counted from the bottom.
"""

from pathlib import Path

import numpy as np

from sweep.model.description import FAILED, FINAL, MISSING, OPEN, Ending, Endings, Model, Words
from sweep.model.kernel import Kernel
from sweep.model.quantity import DURATION, ERROR_GAUGE, GRID, STABILITY, STEP, STEP_COUNT, Input, Quantity
from sweep.model.quantity import Tolerance, positive, table

_CLOSE = Tolerance(1e-6, 1e-6, "each resolved extreme is within 1e-6 rad of the exact one")


def _input(name, symbol, units, long_name, default, **more):
    return Input(name, symbol, units, long_name, GRID, default=default, **more)


class Bead(Model):
    name = "bead"
    parameters = table(
        _input("angle", r"\theta_0", "rad", "initial angle from the bottom", 0.0),
        _input("angle_rate", r"\dot\theta_0", "rad s-1", "initial rate of the angle", 0.0),
        _input("hoop_rate", r"\omega", "rad s-1", "rate of the hoop about the vertical", 0.0, control=True),
        _input("radius", "R", "m", "radius of the hoop", 0.5, rule="radius > 0", allows=positive),
        _input("gravity", "g", "m s-2", "acceleration of gravity", 9.81, rule="gravity > 0", allows=positive),
    )
    settings = table(
        DURATION, STEP,
        _input("tolerance", r"\epsilon", "rad", "largest error", 1e-6, rule="tolerance > 0", allows=positive),
    )  # fmt: skip
    endings = Endings(
        Ending(0, "not_computed", "the cell has not been integrated", MISSING, "it has not been integrated"),
        Ending(1, "bounded", "both turning points were passed", FINAL, "both turning points were passed"),
        Ending(2, "horizon", "the duration was over first", OPEN, "was over before both turning points"),
        Ending(3, "unresolved", "the error is over the tolerance", FAILED, "the error is over the tolerance"),
    )
    variables = table(
        endings.quantity, STABILITY,
        *(Quantity(f"angle_{end}", "", "rad", f"{end}imum of the angle", _CLOSE) for end in ("min", "max")),
        Quantity("peak_angle", r"\max|\theta|", "rad", "largest magnitude of the angle", _CLOSE),
        Quantity("period", "P", "s", "period of the oscillation", _CLOSE),
        Quantity("angle_error", "", "rad", "estimated error of the extremes", ERROR_GAUGE, "", "f4"),
        Quantity("steps", "n", "1", "steps of the integration", STEP_COUNT, "", "i4"),
    )  # fmt: skip
    measures, counts = ("angle_min", "angle_max", "period", "angle_error"), ("ending", "steps")
    coordinate, extremes, error_name, peak = "angle", measures[:2], "angle_error", "peak_angle"
    presets = Path(__file__).with_name("presets")
    integrate = Kernel("bead.kernels", "integrate")
    words = Words("Stability atlas of a bead on a turning hoop, {}.", "bead on a hoop", "any textbook")

    def headline(self, spec):
        return "Bead on a turning hoop: stability of the bottom"

    def undisturbed(self, spec, starts):
        return np.zeros_like(starts["angle"])

    def perturbation(self, spec, starts):
        return np.hypot(starts["angle"], starts["angle_rate"] * np.sqrt(starts["radius"] / starts["gravity"]))

    def derive(self, starts, measured):
        return {"peak_angle": np.maximum(-measured["angle_min"], measured["angle_max"])}

    def lines(self, spec, axis, starts):
        gravity, start = starts["gravity"] / starts["radius"], starts["angle"]
        far = np.minimum(spec.criterion.allowed(self.perturbation(spec, starts)), 0.5 * np.pi)
        energy = 2.0 * gravity * (np.cos(start) - np.cos(far)) - starts["angle_rate"] ** 2
        with np.errstate(invalid="ignore", divide="ignore"):
            predicted = np.sqrt(energy / (np.sin(far) ** 2 - np.sin(start) ** 2))
        return {"lower": (np.sqrt(gravity), predicted)}

    def line_label(self, spec, axis):
        return "g/R"


BEAD = Bead()
