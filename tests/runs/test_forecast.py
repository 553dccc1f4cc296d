"""The forecast of a run: its time from measurements, and its bytes on disk."""

from pathlib import Path

import numpy as np
import pytest
from messages import assert_in_order, refused

from sweep.request.spec import SweepSpec
from sweep.runs import forecast, journal
from sweep.runs.forecast import Forecast, check_run_fits, coarse
from sweep.runs.run import run_to_file

MILLION = SweepSpec(roll_rate="1:4:1000", tilt="1deg:5deg:1000")


def test_the_time_of_a_run():
    """Storing a million cells takes one processor a second next to computing; start and search are added."""
    for rate, threads, processors, expected in [
        (1e3, 1, 2, 1000.0),  # computing dominates
        (1e9, 1, 2, 1.0),  # one thread stores the results
        (1e9, 2, 2, 0.5),  # two threads store them
        (1e6, 1, 2, 1.0),  # both at once
        (1e6, 2, 2, 1.5),  # both at once, on the same processors
        (1e6, 1, 1, 2.0),  # one after the other
        (1e6, 8, 64, 1.0),
    ]:
        found = Forecast(rate, 1e-6, 20.0, 30.0, 0.4, 0.25)
        assert found.seconds(MILLION, threads, processors) - 0.65 == pytest.approx(expected, rel=3e-3)


@pytest.fixture
def peak(monkeypatch):
    """Return a function that runs a spec and returns the bytes of its whole journal and its file."""

    def of(spec, path):
        taken = []
        publish = journal.publish_bytes
        with monkeypatch.context() as context:
            context.setattr(
                journal, "publish_bytes", lambda *given: (taken.append(len(given[1])), publish(*given))
            )
            run_to_file(spec, path)
        return sum(taken), path.stat().st_size

    return of


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize(
    "words",
    [
        ["rolling", "roll_rate=2:4:300", "tilt=0.001deg:5deg:300:log"],
        ["rolling", "roll_rate=2:4:300", "tilt=0.001deg:5deg:300:log", "method=exact"],
        ["spinning", "precession_rate=1:9:250", "tilt=0.1deg:40deg:300"],
        ["circling", "tilt=5deg:60deg:60", "alpha=0.1:1:40", "duration=2s"],
        ["rolling", "roll_rate=2:4:100", "tilt=0.001deg:5deg:100:log", "contact=yes"],
        ["rolling", "roll_rate=0:0.1:100", "tilt=84.9deg:85.1deg:100"],
    ],
)
def test_the_bytes_on_disk_are_foretold(peak, tmp_path, words):
    """The estimate is at least what the run takes, and at most 1.5 times that."""
    spec = SweepSpec.from_words(words[0], words[1:])
    found = Forecast.measured(spec, 1)
    kept, written = peak(spec, tmp_path / "atlas.nc")
    assert (
        kept + written <= found.journal_bytes(spec) + found.file_bytes(spec) <= 1.5 * (kept + written) + 1e5
    )


def test_a_run_is_refused_only_where_it_does_not_fit(machine, monkeypatch):
    """A run starts if the measured need fits, even below the bound; otherwise the message has the bytes."""
    bound = forecast.journal_bytes(MILLION, MILLION.size) + forecast.file_bytes(MILLION)

    def with_free(size):
        machine(free_bytes=size)
        check_run_fits(Path("atlas.nc"), MILLION, MILLION.size)

    monkeypatch.setattr(forecast, "_keeping", lambda spec, rate: (0.0, 20.0, 30.0))
    with_free(1.01 * bound)
    with_free(51e6)
    with refused("atlas.nc") as caught:
        with_free(49e6)
    assert_in_order(caught.value.message, "50 MB", "49 MB")


def test_what_is_computed_already_needs_no_room_in_the_journal(machine, monkeypatch):
    """A resumed run needs room for the rest of the journal and for the whole file."""
    machine(free_bytes=31e6)
    monkeypatch.setattr(forecast, "_keeping", lambda spec, rate: (0.0, 20.0, 30.0))
    check_run_fits(Path("atlas.nc"), MILLION, 0)
    with refused("atlas.nc", "31 MB"):
        check_run_fits(Path("atlas.nc"), MILLION, MILLION.size)


def test_a_coarse_grid_is_spread_over_the_grid():
    """It has about the requested number of cells, at most the grid's, with values from the grid's axes."""
    for cells in [1, 10, 500, 10**6]:
        spec = SweepSpec.preset("rolling")
        sample = coarse(spec, cells)
        assert min(cells, spec.size) / 4 <= sample.size <= min(4 * cells, spec.size)
        for name in spec.axes:
            value = getattr(sample, name)
            assert set(np.atleast_1d(value.array())) <= set(getattr(spec, name).array())


def test_the_memory_of_a_run_holds_the_verdicts_and_what_the_boundary_has():
    """A cell takes 1 byte and a row 40; for curves a cell takes 3 more, and each point 160."""
    spec = SweepSpec(roll_rate="1:4:10000", tilt="1deg:5deg:100000")
    process = forecast.memory_bytes(SweepSpec(roll_rate="1:4:10000", tilt="1deg:5deg:99"))
    assert forecast.memory_bytes(spec) - process == pytest.approx(1e9 + 40 * 1e5 + 800 * 2**16, rel=0.01)
    more = forecast.memory_bytes(spec.replace(boundary="refined")) - forecast.memory_bytes(spec)
    assert more == pytest.approx(3e9 + 160 * 110000)


def test_what_a_file_stores_as_it_is():
    """The axes and edge of a million rows with three cells are half as large as the cells."""
    spec = SweepSpec(roll_rate="1:4:3", tilt="1deg:5deg:1000000")
    assert forecast.plain_bytes(spec) == 8 * 1000003 + 33 * 1000000
    assert forecast.plain_bytes(spec.replace(roll_rate=2.0)) == 8 * 1000000
    # Each start of a list has its own values of the listed parameters.
    grid = SweepSpec(roll_rate="1:4:3", tilt="1deg,5deg")
    listed = SweepSpec(roll_rate="uniform:1:4", tilt="uniform:1deg:5deg", samples=6)
    assert forecast.cell_bytes(listed) - forecast.cell_bytes(grid) == 16
    # A refined boundary has a point (two coordinates with half-widths) on each line of cells, both ways.
    refined = spec.replace(boundary="refined")
    assert forecast.plain_bytes(refined) - forecast.plain_bytes(spec) == 16 * 2 * (1000000 + 3)
