"""The table of what the exact reduction adds: to an atlas that it made, and to the audit of one that it did not."""

from collections.abc import Mapping
from types import MappingProxyType

from sweep.schema import CONTACT_VARIABLES, EXACT_DECISION, VARIABLES, Quantity, Tolerance, table

NOT_COMPUTED, AGREES, WITHIN, MARGINAL, ATLAS_UNRESOLVED, EXACT_UNRESOLVED, INVALID = range(7)
AGREEING = (AGREES, WITHIN, MARGINAL)
EXTREMES_DIFFER, ENDING_DIFFERS, PERIOD_DIFFERS, VERDICT_DIFFERS, CONTRADICTORY = DISAGREEING = range(7, 12)

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
             "within: time ended the run inside the exact extremes; marginal: ending or verdict differ, but within the "
             "tolerance of where they change; contradictory: its numbers do not follow from its own extremes", "i1",
             MappingProxyType({
                 NOT_COMPUTED: "not_computed", AGREES: "agrees", WITHIN: "within", MARGINAL: "marginal",
                 ATLAS_UNRESOLVED: "unresolved_in_the_atlas", EXACT_UNRESOLVED: "unresolved_by_the_reduction",
                 INVALID: "invalid", EXTREMES_DIFFER: "extremes_differ", ENDING_DIFFERS: "ending_differs",
                 PERIOD_DIFFERS: "period_differs", VERDICT_DIFFERS: "verdict_differs",
                 CONTRADICTORY: "contradictory"})),
    Quantity("tilt_difference", r"\Delta\theta", "rad", "larger difference of the extreme tilts from the exact ones",
             _AUDIT_TILT, "of a run that time ended: how far its extremes lie beyond the exact ones"),
    Quantity("period_difference", r"\Delta P", "s", "nutation period minus the exact one", _AUDIT_TILT),
    Quantity("period_share", "", "1", "magnitude of period_difference over what the tolerance allows", _AUDIT_TILT),
    Quantity("exact_tilt_min", r"\theta_{\min}", "rad", "exact smallest tilt of the motion", _AUDIT_TILT, "signed"),
    Quantity("exact_tilt_max", r"\theta_{\max}", "rad", "exact largest tilt of the motion", _AUDIT_TILT, "signed"),
    Quantity("exact_period", "P", "s", "exact nutation period", _AUDIT_TILT),
    Quantity("exact_stability", "", "1", "verdict of the criterion on the exact extremes", EXACT_DECISION, "", "i1",
             VARIABLES["stability"].flags),
)
# fmt: on


#: Variables of an atlas that follow from the others and the spec.
DERIVED = ("stability", "peak_tilt", "amplification")


def atlas_variables(method: str, contact: str = "no") -> Mapping[str, Quantity]:
    """Return the variables of an atlas with one value per cell, for a method, with or without contact forces."""
    exact = REDUCTION if method == "exact" else {}
    return {**VARIABLES, **exact, **(CONTACT_VARIABLES if contact == "yes" else {})}
