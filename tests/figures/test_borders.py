"""Borders between stable and unstable cells: complete around large regions, absent where cells alternate."""

import numpy as np
import pytest
from figure_words import misplaced, words_drawn
from matplotlib.collections import LineCollection

import sweep
from sweep.figures import plots
from sweep.figures.borders import find_borders
from sweep.figures.look import Look
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE


def verdicts(unstable):
    """Return codes of cells that are stable unless marked unstable."""
    return np.where(unstable, UNSTABLE, STABLE)


ROWS, COLUMNS = np.indices((40, 50))


@pytest.mark.parametrize(
    "unstable",
    [
        COLUMNS < 20,
        ROWS < COLUMNS,
        2 * ROWS < COLUMNS,
        (ROWS - 20) ** 2 + (COLUMNS - 25) ** 2 < 144,
        (ROWS > 10) & (COLUMNS > 30),
    ],
    ids=["upright", "diagonal", "slant", "circle", "corner"],
)
def test_large_regions_have_whole_borders(unstable):
    """Every pair of a stable and an unstable cell at the edge of a large region has its border."""
    found = find_borders(verdicts(unstable))
    assert len(found.upright[0]) == np.count_nonzero(unstable[:, 1:] != unstable[:, :-1])
    assert len(found.level[0]) == np.count_nonzero(unstable[1:] != unstable[:-1])
    assert not found.mixed.any()


def test_cells_that_alternate_have_no_borders(rng):
    """Cells of random verdicts count as mixed and have no lines; a large region next to them has its border."""
    unstable = COLUMNS >= 40
    unstable[:, :20] = rng.random((40, 20)) < 0.5
    found = find_borders(verdicts(unstable))
    # the corners have too few cells to decide
    assert found.mixed[3:-3, :17].all()
    assert not found.mixed[:, 25:].any()
    columns = found.upright[1]
    assert (columns[columns > 25] == 39).all()
    assert np.count_nonzero(columns == 39) == 40
    inner = (found.upright[0] > 3) & (found.upright[0] < 36) & (columns < 17)
    assert not inner.any()


def test_a_single_cell_has_no_line_around_it():
    """A line around a single cell would cover it, so there is none."""
    unstable = np.zeros((40, 50), bool)
    unstable[10, 10] = unstable[30, 30] = True
    found = find_borders(verdicts(unstable))
    assert len(found.upright[0]) + len(found.level[0]) == 0
    assert not found.mixed.any()


def test_undecided_cells_have_no_borders_and_are_not_mixed(rng):
    """Undecided cells are hatched, whatever is next to them."""
    found = find_borders(np.where(rng.random((40, 50)) < 0.5, UNDECIDED, UNSTABLE))
    assert len(found.upright[0]) + len(found.level[0]) == 0
    assert not found.mixed.any()


@pytest.fixture
def chaotic(rng):
    """Return an atlas of a system with made-up cells: alternating verdicts below, unstable above."""
    atlas = sweep.run("henon_heiles", u="-1:1:40", v="-1:1:40", duration=1)
    codes = np.full((40, 40), UNSTABLE, np.int8)
    # the second axis is drawn upward
    codes[:, :24] = verdicts(rng.random((40, 24)) < 0.5)
    codes[30:, :8] = UNDECIDED
    atlas["stability"] = atlas["stability"].copy(data=codes)
    return atlas


def test_a_chaotic_map_shows_its_cells(chaotic):
    """Few lines are drawn; mixed and undecided regions have names and legend entries."""
    drawn = plots.figure([chaotic], look=Look(quantity="end_time"))
    axes = drawn.axes[0]
    lines = [each for each in axes.collections if isinstance(each, LineCollection)]
    assert sum(len(each.get_segments()) for each in lines) < 100
    told = [each.get_text() for each, _ in words_drawn(drawn)]
    assert {"mixed", "unstable", "undecided"} <= set(told)
    assert any(text.startswith("mixed:") for text in told)
    assert misplaced(drawn) == []


def test_each_part_of_a_region_has_its_name():
    """Both unstable bands on the sides of a stable one are named."""
    atlas = sweep.run("henon_heiles", u="-1:1:40", v="-1:1:40", duration=1)
    codes = np.full((40, 40), UNSTABLE, np.int8)
    codes[:, 14:26] = STABLE
    atlas["stability"] = atlas["stability"].copy(data=codes)
    drawn = plots.figure([atlas], look=Look(quantity="end_time"))
    told = [each.get_text() for each, _ in words_drawn(drawn)]
    assert (told.count("stable"), told.count("unstable")) == (1, 2)
