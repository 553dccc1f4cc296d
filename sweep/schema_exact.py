"""The table of what the exact reduction adds: to an atlas that it made, and to the audit of one that it did not."""

from collections.abc import Mapping
from types import MappingProxyType

from sweep.schema import CONTACT_VARIABLES, EXACT_DECISION, VARIABLES, Quantity, Tolerance, table

NOT_COMPUTED, AGREES, MARGINAL, DISAGREES, ATLAS_UNRESOLVED, EXACT_UNRESOLVED, INVALID = range(7)

_AUDIT_TILT = Tolerance(1e-8, 0.0, "a difference from the exact value is as large as the error it measures")

# fmt: off
#: What only the reduction knows of a cell.
REDUCTION: Mapping[str, Quantity] = table(
    Quantity("wells", "", "1", "wells of the potential that belongs to the constants of the motion", EXACT_DECISION,
             "two wells: the tilt has a saddle between them", "i1",
             MappingProxyType({0: "unknown", 1: "one_well", 2: "two_wells"})),
    Quantity("separatrix", "", "1", "saddle of the potential minus the energy of the motion, over m g R",
             Tolerance(1e-12, 1e-9, "a difference of energies, each known to rounding"),
             "positive: trapped in one of two wells; negative: passes over the saddle; missing: there is no saddle"),
)

#: What an audit says of a cell.
AUDIT: Mapping[str, Quantity] = table(
    *REDUCTION.values(),
    Quantity("audit", "", "1", "the cell of the atlas against the exact reduction", EXACT_DECISION,
             "marginal: verdict or ending differ, but within the tolerance of where they change", "i1",
             MappingProxyType({
                 NOT_COMPUTED: "not_computed", AGREES: "agrees", MARGINAL: "marginal", DISAGREES: "disagrees",
                 ATLAS_UNRESOLVED: "unresolved_in_the_atlas", EXACT_UNRESOLVED: "unresolved_by_the_reduction",
                 INVALID: "invalid"})),
    Quantity("tilt_difference", r"\Delta\theta", "rad", "larger difference of the extreme tilts from the exact ones",
             _AUDIT_TILT),
    Quantity("period_difference", r"\Delta P", "s", "nutation period minus the exact one", _AUDIT_TILT),
    Quantity("exact_tilt_min", r"\theta_{\min}", "rad", "exact smallest tilt of the motion", _AUDIT_TILT, "signed"),
    Quantity("exact_tilt_max", r"\theta_{\max}", "rad", "exact largest tilt of the motion", _AUDIT_TILT, "signed"),
    Quantity("exact_period", "P", "s", "exact nutation period", _AUDIT_TILT),
    Quantity("exact_stability", "", "1", "verdict of the criterion on the exact extremes", EXACT_DECISION, "", "i1",
             VARIABLES["stability"].flags),
)
# fmt: on


def atlas_variables(method: str, contact: str) -> Mapping[str, Quantity]:
    """Return the variables of an atlas that have one value per cell, for the words `method` and `contact`."""
    reduction = REDUCTION if method == "exact" else {}
    return {**VARIABLES, **reduction, **(CONTACT_VARIABLES if contact == "yes" else {})}
