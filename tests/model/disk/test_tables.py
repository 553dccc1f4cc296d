"""The disk's tables: parameters with their domains, endings, and the rows of the kernels' arrays."""

import math

import numpy as np

from kernels.bodies import arrays as body_arrays
from kernels.bodies.arrays import REDUCED
from kernels.disk import arrays, endings
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import (
    CONTACT_VARIABLES,
    ENDINGS,
    OPTIONS,
    PARAMETERS,
    REDUCTION,
    SETTINGS,
    UNTIMED,
    VARIABLES,
)
from sweep.model.quantity import FAILED, FINAL, LOST, MISSING, OPEN, STABLE, UNDECIDED, UNDISTURBED, UNSTABLE

INPUTS = [*PARAMETERS.values(), *SETTINGS.values()]


def test_the_seven_parameters_and_their_defaults():
    """The default disk is uniform, has a radius of 0.5 m, and rests upright on Earth."""
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


def test_defaults_obey_their_rules():
    """A numeric default satisfies its own rule; a text default is one of the allowed words."""
    for quantity in INPUTS:
        if isinstance(quantity.default, str):
            assert quantity.default in quantity.words, quantity
        else:
            assert quantity.allows(np.array([quantity.default])).all(), quantity


def test_options_have_a_default_among_their_choices():
    """Every text setting has a default that is one of its choices."""
    assert all(word.default in word.choices for word in OPTIONS.values())


def test_domains_end_where_the_rule_says():
    """Each rule's predicate holds inside its interval and fails on and beyond its open ends."""
    for name, inside, outside in [
        ("tilt", [-1.57, 0.0, 1.57], [-math.pi / 2, math.pi / 2, math.nan]),
        ("roll_rate", [-1e300, 0.0, 1e300], [math.inf, math.nan]),
        ("alpha", [1e-300, 0.5, 1.0], [0.0, -0.5, np.nextafter(1.0, 2.0), math.nan]),
        ("radius", [1e-3], [0.0, -0.5]),
        ("gravity", [1.62], [0.0, -9.81]),
        ("duration", [1e-3], [0.0, -1.0]),
        ("step", [1e-3], [0.0, -1.0]),
        ("fall_tilt", [0.1, 1.57], [0.0, -0.1, math.pi / 2]),
        ("tolerance", [1e-12, 0.1], [0.0, 1e-13, -1e-8, 0.11]),
    ]:
        allows = {**PARAMETERS, **SETTINGS}[name].allows
        assert allows(np.array(inside)).all(), (name, inside, outside)
        assert not allows(np.array(outside)).any(), (name, inside, outside)


def test_rows_are_those_of_the_kernels():
    """Python passes rows to the kernels, and reads them, in the order of the kernels' own tables."""
    assert tuple(PARAMETERS) == arrays.PARAMETERS
    assert tuple(SETTINGS) == arrays.SETTINGS
    assert (DISK.measures, DISK.counts) == (arrays.MEASURES, arrays.COUNTS)
    assert tuple(CONTACT_VARIABLES) == (*body_arrays.CONTACT, "contact_state")
    states = ("NO_MOTION", "PRESSES", "LIFTS_OFF", "UNRESOLVED_FORCES")
    flags = CONTACT_VARIABLES["contact_state"].flags
    assert [flags[getattr(body_arrays, name)] for name in states] == [
        "no_motion", "presses", "lifts_off", "unresolved"
    ]  # fmt: skip
    assert {*DISK.measures, *DISK.counts} <= set(VARIABLES)
    assert {*REDUCED, "wells"} <= {*VARIABLES, *REDUCTION}


def test_endings_are_those_of_the_kernels():
    """The flags of `ending` are the kernels' codes; each has a meaning and a reason.

    The last code belongs to bodies with two edges, which the disk does not have.
    """
    codes = {name.lower(): code for name, code in vars(endings).items() if name.isupper()}
    assert codes.pop("edge_change") == max(codes.values()) + 1
    assert {each.name: each.code for each in ENDINGS} == codes
    assert VARIABLES["ending"].flags == {code: name for name, code in codes.items()}
    assert VARIABLES["ending"].attributes()["flag_values"].dtype == np.int8
    for each in ENDINGS:
        assert each.meaning in VARIABLES["ending"].description
        assert each.reason


def test_what_endings_mean_for_the_verdict():
    """Every ending has the role that determines its verdict."""
    assert {each.name: each.role for each in ENDINGS} == {
        "not_computed": MISSING,
        "bounded": FINAL,
        "steady": UNDISTURBED,
        "horizon": OPEN,
        "fell": LOST,
        "unresolved": FAILED,
        "invalid": FAILED,
    }


def test_stability_flags():
    """Zero means undecided, so a cell without a verdict is never called stable."""
    assert VARIABLES["stability"].flags == {UNDECIDED: "undecided", STABLE: "stable", UNSTABLE: "unstable"}
    assert (UNDECIDED, STABLE, UNSTABLE) == (0, 1, 2)


def test_what_the_exact_reduction_does_not_find_is_said_of_its_atlases():
    """Each measure that needs time integration is in `UNTIMED`, or criteria would use missing values."""
    assert {*UNTIMED} == {*arrays.MEASURES, *arrays.COUNTS} - {*REDUCED}
