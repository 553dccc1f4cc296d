"""The reduction of a body to one degree of freedom, as a method and a reference without time stepping."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from kernels.bodies import arrays, shapes
from sweep.model.bodies.shape import body_of
from sweep.model.description import Columns, Request, Starts
from sweep.model.disk.contact import CONTACT, contact_columns
from sweep.model.disk.exact import AUDIT, REDUCE, ExactReduction
from sweep.model.disk.path import PATHS, path_columns
from sweep.model.disk.tables import REDUCTION as OF_THE_DISK
from sweep.model.kernel import Kernel
from sweep.model.quantity import Array, Quantity, table

_KERNELS = {
    "reduce": REDUCE,
    "paths": PATHS,
    "contact": CONTACT,
}


def kernel_of(body: str, name: str) -> Kernel:
    """Return the kernel `reduce`, `paths` or `contact` of a body.

    Only the contact forces of a spheroid need another kernel, because its meridian is not an arc of a circle.
    """
    kernel = _KERNELS[name]
    return replace(kernel, function="contact_ellipses") if (body, name) == ("spheroid", "contact") else kernel


#: Additional variables of an atlas of the reduction. Wells would take most of the time if every cell has another body.
REDUCTION: Mapping[str, Quantity] = table(OF_THE_DISK["separatrix"])

#: The variable of an audit that only the disk has.
_OF_THE_DISK_ALONE = "wells"


def path_of_bodies(spec: Request, starts: Starts) -> Columns:
    """Return the paths of the contact points of cells: `sweep.model.disk.path.PATH_VARIABLES`, arrays of shape (n,)."""
    rows = np.stack([starts[name] for name in arrays.PARAMETERS])
    return path_columns(rows, shapes.NAMES.index(spec.body), spec.fall_tilt)


def contact_of_bodies(spec: Request, starts: Starts) -> Columns:
    """Return the extremes of the contact forces of cells, as by `sweep.model.disk.contact.contact_columns`."""
    rows = np.stack([starts[name] for name in arrays.PARAMETERS])
    kernel = kernel_of(spec.body, "contact")
    return contact_columns(rows, shapes.NAMES.index(spec.body), spec.fall_tilt, kernel)


class BodyReduction(ExactReduction):
    """See `sweep.model.description.ExactReference`."""

    variables = REDUCTION
    audit = replace(
        AUDIT,
        variables=MappingProxyType(
            {name: row for name, row in AUDIT.variables.items() if name != _OF_THE_DISK_ALONE}
        ),
    )

    def rigid_bodies(self, spec: Request, starts: Starts) -> dict[str, Array]:
        """Return the fields of `sweep.model.rigid_body.RigidBody` of starts."""
        fields = body_of(spec, starts)._asdict()
        del fields["ratio"]
        return {name: np.broadcast_to(values, starts["tilt"].shape) for name, values in fields.items()}

    def rows(self, spec: Request, starts: Starts) -> tuple[Array, int]:
        """Return the rows of starts (`kernels.bodies.arrays.PARAMETERS`), and the index of their kind of body."""
        return np.stack([starts[name] for name in arrays.PARAMETERS]), shapes.NAMES.index(spec.body)
