"""The reduction of a body to one degree of freedom, as a reference: extremes and period without time stepping."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from kernels.bodies import arrays, shapes
from kernels.disk import motion_arrays
from kernels.disk.arrays import COUNTS, MEASURES
from sweep.model.bodies.shape import body_of
from sweep.model.bodies.tables import ENDINGS
from sweep.model.description import Columns, Request, Starts
from sweep.model.disk.exact import AUDIT, ExactReduction, fall_times, without_vague
from sweep.model.disk.path import PATHS, call_by_body, path_columns
from sweep.model.disk.tables import REDUCTION as OF_THE_DISK
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Quantity, table

_KERNELS = {
    "reduce": Kernel("kernels.reduction.cells", "reduce", seconds=6.0),
    "paths": PATHS,
    "contact": Kernel("kernels.reduction.contact_extremes", "contact", seconds=14.0),
    "wells": Kernel("kernels.reduction.wells", "wells", seconds=4.0),
}


def kernel_of(body: str, name: str) -> Kernel:
    """Return the kernel `reduce`, `paths`, `contact` or `wells` of a body.

    Only the series of contact forces differ for a spheroid, whose meridian is not an arc of a circle.
    """
    kernel = _KERNELS[name]
    return replace(kernel, function="contact_ellipses") if (body, name) == ("spheroid", "contact") else kernel


#: What an atlas of the reduction holds besides.
REDUCTION: Mapping[str, Quantity] = table(
    replace(
        OF_THE_DISK["separatrix"],
        long_name="maximum of the potential beside the motion minus its energy, over m g R",
        description="of the nearest maximum that the motion passes (negative) or turns below (positive), from the "
        "parabola there: the nearer, the more exact; missing: there is none",
    )
)

#: Variables of an audit that only the disk has.
_OF_THE_DISK_ALONE = "wells"


def path_of_bodies(spec: Request, starts: Starts) -> Columns:
    """Return where the contact points of cells go: `sweep.model.disk.path.PATH_VARIABLES`, arrays of shape (n,)."""
    rows = np.stack([starts[name] for name in arrays.PARAMETERS])
    return path_columns(rows, shapes.NAMES.index(spec.body), spec.fall_tilt)


def contact_columns(spec: Request, starts: Starts) -> dict[str, npt.NDArray[Any]]:
    """Return the extremes of the contact forces of cells (`kernels.reduction.contact_extremes`): arrays, shape (n,)."""
    rows = np.stack([starts[name] for name in arrays.PARAMETERS])
    extremes = np.empty((len(motion_arrays.CONTACT), rows.shape[1]))
    states = np.empty(rows.shape[1], np.int64)
    kind = float(shapes.NAMES.index(spec.body))
    kernel = kernel_of(spec.body, "contact")
    call_by_body(kernel, rows, (kind, float(spec.fall_tilt)), (extremes, states))
    return {**dict(zip(motion_arrays.CONTACT, extremes, strict=True)), "contact_state": states}


class BodyReduction(ExactReduction):
    """See `sweep.model.description.ExactReference`."""

    variables = REDUCTION
    audit = replace(
        AUDIT,
        variables=MappingProxyType(
            {
                name: REDUCTION.get(name, each)
                for name, each in AUDIT.variables.items()
                if name != _OF_THE_DISK_ALONE
            }
        ),
    )

    def rigid_bodies(self, spec: Request, starts: Starts) -> dict[str, Array]:
        """Return the fields of `sweep.model.rigid_body.RigidBody` of starts."""
        fields = body_of(spec, starts)._asdict()
        del fields["ratio"]
        return {name: np.broadcast_to(values, starts["tilt"].shape) for name, values in fields.items()}

    def measures(
        self, spec: Request, starts: Starts, extremes_only: bool = False
    ) -> dict[str, npt.NDArray[Any]]:
        """Return what the reduction says of cells, without time stepping (`kernels.reduction`).

        Parameters
        ----------
        spec : Request
        starts : mapping of str to array, shape (n,)
        extremes_only : bool
            Leave out the nutation period.

        Returns
        -------
        dict of str to array, shape (n,)
            The measures and counts of a body and `variables`; NaN or 0 where the reduction has none. A cell whose
            extremes are not known to the tolerance of the spec (on a separatrix) is unresolved.
        """
        rows = np.stack([starts[name] for name in arrays.PARAMETERS])
        n = rows.shape[1]
        measures, counts = np.empty((len(arrays.REDUCED), n)), np.empty((1, n), np.int32)
        body = float(shapes.NAMES.index(spec.body))
        settings = (body, float(spec.fall_tilt), int(not extremes_only))
        call_by_body(kernel_of(spec.body, "reduce"), rows, settings, (measures, counts))
        found = dict(zip(arrays.REDUCED, measures, strict=True)) | {"ending": counts[0]}
        return without_vague(found, spec, (MEASURES, COUNTS), ENDINGS)

    def with_wells(self, spec: Request, starts: Starts) -> dict[str, npt.NDArray[Any]]:
        """Return `measures` without periods, and how many wells the potential has, 0 if unknown."""
        rows = np.stack([starts[name] for name in arrays.PARAMETERS])
        counts = np.empty(rows.shape[1], np.int64)
        call_by_body(kernel_of(spec.body, "wells"), rows, (float(shapes.NAMES.index(spec.body)),), (counts,))
        return {**self.measures(spec, starts, extremes_only=True), "wells": counts}

    def truth(self, spec: Request, starts: Starts, first: int, stored: Columns) -> Columns:
        """Return what `check` holds cells against: `measures`, fall times of some cells, and a sample in space."""
        exact = self.measures(spec, starts)
        # endings are compared many times
        exact["ending"] = exact["ending"].astype(np.int8)
        if spec.method != "exact":
            rows = np.stack([starts[name] for name in arrays.PARAMETERS])
            exact["fall_time"] = fall_times(spec, starts, exact, rows, shapes.NAMES.index(spec.body))
        return self._with_sample(spec, starts, first, exact)
