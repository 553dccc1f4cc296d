from kernels.bodies.arrays import REDUCED
from kernels.disk import arrays, motion_arrays

#: Prefixes of the row constants by table.
PREFIXES = {
    "PARAMETERS": "",
    "SETTINGS": "",
    "MEASURES": "",
    "COUNTS": "",
    "CONTACT": "CONTACT_",
    "TRAJECTORY_SETTINGS": "TRAJECTORY_",
    "SAMPLES": "",
    "DERIVED": "DERIVED_",
}


def test_each_row_number_is_the_place_of_its_name():
    """The constant with the capitalized name is the index of the name in its table."""
    for table in PREFIXES:
        (module,) = {each for each in (arrays, motion_arrays) if table in vars(each)}
        names = getattr(module, table)
        # a row that another table has too has its constant there
        rows = {**vars(arrays), **vars(module)}
        assert [rows[PREFIXES[table] + name.upper()] for name in names] == list(range(len(names))), table


def test_shared_rows_come_first():
    """Measures, also of the reduction, start with the extreme tilts, parameters and samples with the state."""
    count = len(arrays.EXTREME_TILTS)
    assert arrays.MEASURES[:count] == REDUCED[:count] == arrays.EXTREME_TILTS
    count = len(arrays.STATE)
    assert arrays.PARAMETERS[:count] == motion_arrays.SAMPLES[:count] == arrays.STATE
