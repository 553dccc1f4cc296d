import pytest

from kernels.bodies import arrays as bodies
from kernels.bodies import motion_arrays
from kernels.disk import arrays

#: Module, table, and the prefix of its row constants.
TABLES = [
    *((arrays, table, "") for table in ("PARAMETERS", "SETTINGS", "MEASURES", "COUNTS")),
    (bodies, "PARAMETERS", ""),
    (bodies, "CONTACT", "CONTACT_"),
    (motion_arrays, "SETTINGS", ""),
]


@pytest.mark.parametrize(("module", "table", "prefix"), TABLES)
def test_each_row_number_is_the_place_of_its_name(module, table, prefix):
    """The constant with the capitalized name is the index of the name in its table."""
    names = getattr(module, table)
    assert [getattr(module, prefix + name.upper()) for name in names] == list(range(len(names)))


def test_shared_rows_come_first():
    """Measures, also of the reduction, start with the extreme tilts, parameters and samples with the state."""
    count = len(arrays.EXTREME_TILTS)
    assert arrays.MEASURES[:count] == bodies.REDUCED[:count] == arrays.EXTREME_TILTS
    count = len(arrays.STATE)
    assert arrays.PARAMETERS[:count] == motion_arrays.SAMPLES[:count] == arrays.STATE
