"""Quantities of all kinds are complete, readable in labels, and their tables are immutable."""

import math

import numpy as np
import pytest

from sweep.atlas.cf_metadata import curve_quantities, edge_quantities, point_quantities
from sweep.model.disk.exact import AUDIT
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import CONTACT_VARIABLES, PARAMETERS, REDUCTION, SETTINGS, VARIABLES
from sweep.model.quantity import DECISION, GRID, Quantity, positive, table
from sweep.request.units import _FITTING

QUANTITIES = [
    *PARAMETERS.values(),
    *SETTINGS.values(),
    *VARIABLES.values(),
    *CONTACT_VARIABLES.values(),
    *REDUCTION.values(),
    *AUDIT.variables.values(),
    *edge_quantities(DISK, "roll_rate").values(),
    *curve_quantities().values(),
    *point_quantities(PARAMETERS, ("tilt", "roll_rate")).values(),
]


def test_attributes_are_ascii():
    """All attributes are ASCII, because some netCDF readers refuse other characters."""
    for quantity in QUANTITIES:
        assert all(str(value).isascii() for value in quantity.attributes().values()), quantity


def test_every_quantity_is_complete():
    """Each quantity has a long name, units or flags, a file type, a label and a reason for its tolerance."""
    for quantity in QUANTITIES:
        assert quantity.long_name, quantity
        assert ("units" in quantity.attributes()) != ("flag_values" in quantity.attributes()), quantity
        assert quantity.dtype in {"i1", "i2", "i4", "f4", "f8"}, quantity
        assert quantity.units in _FITTING, quantity
        assert quantity.plot_label, quantity
        assert quantity.tolerance.reason, quantity


def test_flags_are_written_as_cf_has_them():
    """Codes have the variable's type, names have no spaces, and `flag` returns a readable name."""
    for quantity in [each for each in QUANTITIES if each.flags is not None]:
        attributes = quantity.attributes()
        assert attributes["flag_values"].dtype == quantity.dtype, quantity
        meanings = attributes["flag_meanings"].split()
        assert dict(zip(attributes["flag_values"].tolist(), meanings, strict=True)) == quantity.flags, (
            quantity
        )
        assert [quantity.flag(code) for code in quantity.flags] == [
            name.replace("_", " ") for name in meanings
        ], quantity


@pytest.mark.parametrize(
    ("units", "printed"),
    [
        ("s-1", "(s$^{-1}$)"), ("kg m2 s-1", "(kg m$^{2}$ s$^{-1}$)"), ("m3 kg-1 s-2", "(m$^{3}$ kg$^{-1}$ s$^{-2}$)"),
        ("m", "(m)"), ("rad", "(deg)"), ("1", "rate"),
    ],
)  # fmt: skip
def test_units_of_any_model_are_typeset_alike(units, printed):
    """Exponents are superscripts, for the units of any model."""
    assert Quantity("rate", "", units, "a rate", GRID).plot_label.endswith(printed)


def test_labels_speak_of_degrees():
    """The label of an angle says degrees, and its scale turns pi rad into 180."""
    tilt = VARIABLES["tilt_max"]
    assert tilt.plot_label.endswith("(deg)")
    assert math.pi * tilt.plot_scale == pytest.approx(180.0, rel=1e-15)  # one rounding
    assert tilt.spell(math.pi / 2) == "90 deg"
    assert PARAMETERS["alpha"].spell(0.5) == "0.5"


def test_a_table_is_not_changed():
    """A table lists its rows by name, in their order, and is immutable."""
    rows = [Quantity(name, "", "1", name, DECISION) for name in ("b", "a")]
    made = table(*rows)
    assert list(made) == ["b", "a"]
    with pytest.raises(TypeError):
        made["c"] = rows[0]


def test_positive_excludes_zero_and_nan():
    """The rule of many inputs holds only above zero."""
    assert positive(np.array([-1.0, 0.0, 5e-324, np.nan])).tolist() == [False, False, True, False]
