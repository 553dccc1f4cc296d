"""Stored cells in a view: the cell of each pixel, on every axis and for planes of any size."""

import numpy as np
import pytest
from cases import case

import sweep
from sweep.explorer import stored as stored_module
from sweep.explorer.about import base_of
from sweep.explorer.explorer import Subject
from sweep.explorer.view import View


@pytest.fixture(scope="module")
def subject():
    """Return an atlas with a linear and a logarithmic axis."""
    atlas = sweep.run(
        "rolling", roll_rate="1:5:40", tilt="0.01deg:10deg:24:log", method="exact", progress=False
    )
    return Subject.of_dataset(atlas)


def pixels(subject, x, y, size):
    """Return the largest tilts in a window and which of its pixels have a cell."""
    view = View.read({**base_of("", subject.spec)["view"], "x": x, "y": y}, subject.spec)
    shown = subject.stored.quantities()["peak_tilt"]
    value, _, inside = subject.stored.pixels(view, shown, size)
    return value, inside, view


def test_the_border_of_two_cells_lies_in_the_middle_of_their_axis(subject):
    """On a logarithmic axis it is the geometric mean, even if the map shows a linear one."""
    for scale in ["log", "linear"]:
        with case(scale):
            tilts = subject.spec.tilt.array()
            low, high = (np.log(tilts[[3, 9]]) if scale == "log" else tilts[[3, 9]]).tolist()
            sides = (
                {"name": "roll_rate", "centre": 3.01, "half": 1.9, "scale": "linear"},
                {"name": "tilt", "centre": 0.5 * (low + high), "half": 0.5 * (high - low), "scale": scale},
            )
            value, inside, view = pixels(subject, *sides, (37, 211))
            assert inside.all()
            rows = np.abs(np.log(view.y.values(211))[:, None] - np.log(tilts)).argmin(axis=1)
            columns = np.abs(view.x.values(37)[:, None] - subject.spec.roll_rate.array()).argmin(axis=1)
            cells = subject.stored._dataset["peak_tilt"].transpose("tilt", "roll_rate").values
            assert np.array_equal(value, cells[np.ix_(rows, columns)])


def test_half_a_cell_beyond_the_last_one_there_is_none(subject):
    """A pixel more than half a cell outside has no cell, according to the mask."""
    rates = subject.spec.roll_rate.array()
    width = rates[1] - rates[0]
    x = {"name": "roll_rate", "centre": float(rates[-1]), "half": float(width), "scale": "linear"}
    y = {"name": "tilt", "centre": -4.0, "half": 1.0, "scale": "log"}
    _, inside, view = pixels(subject, x, y, (100, 5))
    assert np.array_equal(inside, np.broadcast_to(view.x.values(100) <= rates[-1] + 0.5 * width, (5, 100)))


def test_a_large_plane_is_read_thinned_and_exactly_where_one_looks(subject, monkeypatch):
    """If a plane has too many cells, a pixel's cell is at most as far away as the skipped ones."""
    whole_x = {"name": "roll_rate", "centre": 3.0, "half": 2.0, "scale": "linear"}
    whole_y = {"name": "tilt", "centre": -5.2, "half": 3.4, "scale": "log"}
    near = {"name": "roll_rate", "centre": 4.0, "half": 0.3, "scale": "linear"}, {**whole_y, "half": 0.4}
    size = (200, 150)
    exact_near = pixels(subject, *near, size)[0]
    monkeypatch.setattr(stored_module, "_MOST_CELLS", 100)
    # eight columns of forty, and as many rows, fit: nothing is skipped
    assert np.array_equal(pixels(subject, *near, size)[0], exact_near)
    value, inside, view = pixels(subject, whole_x, whole_y, size)
    cells = subject.stored._dataset["peak_tilt"].transpose("tilt", "roll_rate").values
    rows = np.abs(np.log(view.y.values(size[1]))[:, None] - np.log(subject.spec.tilt.array())).argmin(axis=1)
    columns = np.abs(view.x.values(size[0])[:, None] - subject.spec.roll_rate.array()).argmin(axis=1)
    for i in range(0, size[1], 7):
        for j in range(0, size[0], 7):
            if inside[i, j]:
                # every second row and every fourth column are read, or more
                there = cells[max(rows[i] - 3, 0) : rows[i] + 1, max(columns[j] - 4, 0) : columns[j] + 1]
                assert value[i, j] in there, (i, j)


def test_cells_are_shown_only_where_a_view_has_all_their_words(subject):
    """Another criterion, body or value has no stored cells."""
    view = base_of("", subject.spec)["view"]
    shown = subject.stored.quantities()["peak_tilt"]

    def has_cells(**words):
        read = View.read({**view, "words": {**base_of("", subject.spec)["words"], **words}}, subject.spec)
        return subject.stored.pixels(read, shown, (8, 8)) is not None

    assert has_cells()
    assert has_cells(criterion=str(subject.spec.criterion))
    for words in ({"criterion": "departure:20deg"}, {"alpha": 1.0}, {"fall_tilt": 1.5}, {"tilt_rate": 1e-3}):
        assert not has_cells(**words), words
