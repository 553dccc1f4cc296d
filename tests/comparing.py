"""Atlases for the tests of the regression check, and helpers to read its findings."""

import sweep

SPEC = sweep.SweepSpec.preset("rolling").replace(roll_rate="0:3:13", tilt="0.1deg:40deg:6:log")
CIRCLING = sweep.SweepSpec.preset("circling").replace(tilt="5deg:15deg:3", precession_rate="0.1:5:12")
#: The precession rate follows from tilt and roll rate; for a roll rate of 0 there is none.
STEADY = CIRCLING.replace(roll_rate="-8:8:9", precession_rate="steady-slow")
REFINED = SPEC.replace(boundary="refined:1e-6")


def changed(atlas, name, place, value):
    """Return a copy of an atlas with one value changed."""
    copy = atlas.copy(deep=True)
    copy[name].values[place] = value
    return copy


def found(comparison):
    """Return the variables that differ, with the number of different values."""
    return {finding.name: finding.different for finding in comparison.findings if finding.different}


def finding(comparison, name):
    """Return the finding about one variable."""
    return next(each for each in comparison.findings if each.name == name)
