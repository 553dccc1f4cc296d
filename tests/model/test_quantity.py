import math

import numpy as np
import pytest

from kernels.disk.endings import ENDINGS
from sweep.schema import (
    CONTACT_VARIABLES,
    EVERYDAY_UNITS,
    FITTING,
    PARAMETERS,
    SETTINGS,
    STABLE,
    UNDECIDED,
    UNSTABLE,
    VARIABLES,
    boundary_quantities,
)

INPUTS = [*PARAMETERS.values(), *SETTINGS.values()]
QUANTITIES = [
    *INPUTS,
    *VARIABLES.values(),
    *CONTACT_VARIABLES.values(),
    *boundary_quantities("roll_rate").values(),
]


@pytest.mark.parametrize("quantity", QUANTITIES, ids=lambda quantity: quantity.name)
def test_attributes_are_ascii(quantity):
    """No attribute holds a character outside ASCII: some readers of netCDF refuse them."""
    assert all(str(value).isascii() for value in quantity.attributes().values())


@pytest.mark.parametrize("quantity", QUANTITIES, ids=lambda quantity: quantity.name)
def test_every_quantity_is_complete(quantity):
    """Each quantity has a long name, units or flags, a file type, a label and a reason for its tolerance."""
    assert quantity.long_name
    assert ("units" in quantity.attributes()) != ("flag_values" in quantity.attributes())
    assert quantity.dtype in {"i1", "i2", "i4", "f4", "f8"}
    assert quantity.units in FITTING
    assert quantity.plot_label
    assert quantity.tolerance.reason


def test_the_seven_parameters_and_their_defaults():
    """The parameters are physics.md's seven, and the default disk is uniform, 0.5 m in radius, on Earth."""
    defaults = {name: parameter.default for name, parameter in PARAMETERS.items()}
    assert defaults == {
        "tilt": 0.0,
        "tilt_rate": 0.0,
        "precession_rate": 0.0,
        "roll_rate": 0.0,
        "alpha": 0.5,
        "radius": 0.5,
        "gravity": 9.81,
    }


@pytest.mark.parametrize("quantity", INPUTS, ids=lambda quantity: quantity.name)
def test_defaults_obey_their_rules(quantity):
    """A default that is a number is allowed by its own rule."""
    if not isinstance(quantity.default, str):
        assert quantity.allows(np.array([quantity.default])).all()


@pytest.mark.parametrize(
    ("name", "inside", "outside"),
    [
        ("tilt", [-1.57, 0.0, 1.57], [-math.pi / 2, math.pi / 2, math.nan]),
        ("roll_rate", [-1e300, 0.0, 1e300], [math.inf, math.nan]),
        ("alpha", [1e-300, 0.5, 1.0], [0.0, -0.5, np.nextafter(1.0, 2.0), math.nan]),
        ("radius", [1e-3], [0.0, -0.5]),
        ("gravity", [1.62], [0.0, -9.81]),
        ("duration", [1e-3], [0.0, -1.0]),
        ("step", [1e-3], [0.0, -1.0]),
        ("fall_tilt", [0.1, 1.57], [0.0, -0.1, math.pi / 2]),
        ("tolerance", [1e-12, 0.1], [0.0, 1e-13, -1e-8, 0.11]),
    ],
)
def test_domains_end_where_the_rule_says(name, inside, outside):
    """The predicate of each rule holds inside the rule's interval and fails on and beyond its open ends."""
    allows = {**PARAMETERS, **SETTINGS}[name].allows
    assert allows(np.array(inside)).all()
    assert not allows(np.array(outside)).any()


def test_endings_are_those_of_the_kernels():
    """The flags of `ending` are the closed list of the kernels, code by code."""
    attributes = VARIABLES["ending"].attributes()
    assert list(attributes["flag_values"]) == list(ENDINGS)
    assert attributes["flag_meanings"].split() == [name for name, _ in ENDINGS.values()]
    assert attributes["flag_values"].dtype == np.int8


def test_stability_flags():
    """Zero is undecided, so that a cell without a verdict is never called stable."""
    assert VARIABLES["stability"].flags == {UNDECIDED: "undecided", STABLE: "stable", UNSTABLE: "unstable"}
    assert (UNDECIDED, STABLE, UNSTABLE) == (0, 1, 2)


def test_boundary_quantities_follow_their_axis():
    """The four quantities of a boundary bear the name and the units of the axis that it was found along."""
    quantities = boundary_quantities("precession_rate")
    assert list(quantities) == [
        "boundary_precession_rate",
        "boundary_precession_rate_halfwidth",
        "predicted_precession_rate",
        "critical_precession_rate",
    ]
    assert {quantity.units for quantity in quantities.values()} == {PARAMETERS["precession_rate"].units}


def test_labels_speak_of_degrees():
    """An angle's label says degrees, and its scale turns pi rad into 180 of them."""
    tilt = VARIABLES["tilt_max"]
    assert tilt.plot_label.endswith("(deg)")
    assert math.pi * tilt.plot_scale == pytest.approx(180.0, rel=1e-15)  # one rounding
    assert tilt.spell(math.pi / 2) == "90 deg"
    assert PARAMETERS["alpha"].spell(0.5) == "0.5"


@pytest.mark.parametrize("unit", EVERYDAY_UNITS)
def test_everyday_units_agree_with_pint(unit):
    """The units that are read without pint have pint's factors."""
    import pint

    spelled = unit.replace("s-1", "s**-1").replace("s-2", "s**-2").replace("s2", "s**2")
    units, factor = EVERYDAY_UNITS[unit]
    si = {"rad": "rad", "rad s-1": "rad/s", "m": "m", "m s-2": "m/s**2", "s": "s", "kg": "kg"}[units]
    # 1e-15: pint may round its own product once.
    assert factor == pytest.approx(pint.UnitRegistry().Quantity(1.0, spelled).to(si).magnitude, rel=1e-15)
