"""The endings of a model: their names, codes and roles."""

import numpy as np
import pytest
from messages import refused

from sweep.model import registry
from sweep.model.quantity import FAILED, FINAL, LOST, MISSING, OPEN, Ending, Endings

ENDINGS = Endings(
    Ending(0, "not_computed", "not integrated", MISSING),
    Ending(1, "final", "goes no further", FINAL),
    Ending(3, "lost", "gone", LOST, "it is gone"),
    Ending(4, "broken", "too coarse", FAILED),
    Ending(7, "invalid", "no such start", FAILED),
)


def test_an_ending_is_found_by_its_name_and_by_its_code():
    """Names and codes match the list, also with gaps; any other code is an error in the file."""
    assert [each.code for each in ENDINGS] == [0, 1, 3, 4, 7]
    for each in ENDINGS:
        assert ENDINGS.code(each.name) == each.code
        assert ENDINGS.of(each.code) is each
        assert ENDINGS.of(np.float64(each.code)) is each
    with pytest.raises(KeyError):
        ENDINGS.code("horizon")
    with refused("2", "0, 1, 3, 4, 7"):
        ENDINGS.of(2)


def test_cells_are_told_by_the_roles_of_their_endings():
    """A role covers all its endings, for cells of any shape, also for a single cell."""
    codes = np.array([[0, 1, 3], [4, 7, 1]], np.int8)
    assert ENDINGS.codes(FAILED) == [4, 7]
    assert ENDINGS.codes(FAILED, LOST) == [3, 4, 7]
    assert ENDINGS.have(FAILED, codes).tolist() == [[False, False, False], [True, True, False]]
    assert ENDINGS.have(FINAL, codes).tolist() == [[False, True, False], [False, False, True]]
    assert not ENDINGS.have(OPEN, codes).any()
    assert np.shape(ENDINGS.have(OPEN, codes)) == codes.shape
    assert bool(ENDINGS.have(LOST, np.int8(3)))


def test_the_file_declares_every_ending():
    """It lists each code with its name and each name with its meaning. The list is immutable."""
    assert ENDINGS.flags == {0: "not_computed", 1: "final", 3: "lost", 4: "broken", 7: "invalid"}
    for each in ENDINGS:
        assert f"{each.name}: {each.meaning}" in ENDINGS.quantity.description
    assert ENDINGS.quantity.flags == ENDINGS.flags
    with pytest.raises(TypeError):
        ENDINGS.flags[2] = "other"


#: Endings by code from 0 on, for each model. A code that files contain must keep its meaning.
CODES = {
    "disk": ["not_computed", "bounded", "steady", "horizon", "fell", "unresolved", "invalid"],
    "lossy_disk": [
        "not_computed", "flat", "rest", "horizon", "lift_off", "slip", "undisturbed", "unresolved", "invalid",
    ],
    "bodies": ["not_computed", "bounded", "steady", "horizon", "fell", "unresolved", "invalid", "edge_change"],
    "lossy_bodies": [
        "not_computed", "flat", "rest", "horizon", "lift_off", "slip", "undisturbed", "unresolved", "invalid",
        "edge_change",
    ],
}  # fmt: skip


@pytest.mark.parametrize("name", CODES)
def test_codes_of_files_keep_their_meanings(name):
    """Programs in other languages compare with these codes."""
    assert dict(registry.named(name).variables["ending"].flags) == dict(enumerate(CODES[name]))
