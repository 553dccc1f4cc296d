"""Small atlases of the presets, and the axes of their figures."""

import pytest
from figure_axes import CIRCLING, ROLLING, SPINNING

import sweep
from sweep.figures import plots


@pytest.fixture(scope="module")
def atlases():
    """Return a small atlas of every preset."""
    return {
        "rolling": sweep.run(ROLLING),
        "spinning": sweep.run(SPINNING),
        "circling": sweep.run(CIRCLING),
    }


@pytest.fixture(scope="module")
def panels(atlases):
    """Return the axes of a figure of every preset: the map and the strip."""
    return {name: plots.figure([atlas]).axes for name, atlas in atlases.items()}
