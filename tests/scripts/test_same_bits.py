"""The script that compares the atlases of two checkouts reports a single changed bit."""

import shutil
from pathlib import Path

import netCDF4
import numpy as np
import same_bits
from messages import assert_facts

CHECKOUT = Path(__file__).parents[2]


def test_a_changed_bit_and_a_changed_attribute_are_told(tmp_path):
    """A file equals itself; a changed bit, units, an extra variable and an attribute each give a sentence."""
    one = same_bits.compute(CHECKOUT, "cell", tmp_path / "one.nc")
    other = Path(shutil.copy(one, tmp_path / "other.nc"))
    assert list(same_bits.differences(one, other)) == []
    with netCDF4.Dataset(other, "a") as file:
        file["tilt_max"][...] = np.nextafter(file["tilt_max"][...], 9.0)
        file["tilt_min"].units = "deg"
        file.history = "free"
        file.title = "another"
        file.createVariable("more", "f8", ())
    found = list(same_bits.differences(one, other))
    assert [each.split()[0] for each in found] == ["only", "tilt_max", "units", "title"]
    assert_facts(found[1], "bits", "1 of 1")
