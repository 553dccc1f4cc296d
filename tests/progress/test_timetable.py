"""Estimates of the remaining time count all remaining work; the clock stands still."""

import pytest

from sweep.progress.timetable import Stage, Status, Timetable, duration


class Clock:
    """A clock that stands still until it is set."""

    now = 100.0

    def __call__(self):
        """Return the time."""
        return self.now


@pytest.fixture
def clock():
    """Return a clock."""
    return Clock()


@pytest.fixture
def heard():
    """Return an empty list for the statuses shown."""
    return []


def test_the_time_to_go_counts_all_that_is_to_be_done(clock, heard):
    """40 of 100 cells in 8 s leave 12 s for the rest, 20 s for bisecting 100 more, and 5 s for the check."""
    stages = [Stage("a", 100), Stage("b", 100), Stage("c", 1000, 0.005)]
    timetable = Timetable(stages, heard.append, clock)
    timetable.begin("a")
    clock.now += 8.0
    timetable.report(40)
    clock.now += 12.0
    timetable.report(100)
    timetable.begin("b")
    timetable.begin("c")
    clock.now += 1.0
    timetable.report(100)
    timetable.report(1000)
    assert heard == [
        Status("a", 0, 100, None),
        Status("a", 40, 100, pytest.approx(12.0 + 20.0 + 5.0)),
        Status("a", 100, 100, pytest.approx(20.0 + 5.0)),
        Status("b", 0, 100, pytest.approx(20.0 + 5.0)),
        Status("c", 0, 1000, pytest.approx(5.0)),
        # The measured pace counts, not the expected one.
        Status("c", 100, 1000, pytest.approx(9.0)),
        Status("c", 1000, 1000, 0.0),
    ]


def test_cells_of_an_earlier_run_do_not_count_as_pace(clock, heard):
    """A run resumed at 900 of 1000 cells that needs 10 s for 10 more has 90 s to go, not 1."""
    timetable = Timetable([Stage("a", 1000)], heard.append, clock)
    timetable.begin("a", 900)
    clock.now += 10.0
    timetable.report(910)
    assert heard == [Status("a", 900, 1000, None), Status("a", 910, 1000, pytest.approx(90.0))]


def test_compiling_does_not_count_as_pace(clock, heard):
    """A first block that took 15 s for compiling does not affect the estimate for the others of 1 s each."""
    timetable = Timetable([Stage("a", 1000)], heard.append, clock)
    timetable.begin("a")
    clock.now += 15.0
    timetable.measure_from(100)
    clock.now += 1.0
    timetable.report(200)
    assert heard[1:] == [Status("a", 100, 1000, None), Status("a", 200, 1000, pytest.approx(8.0))]


def test_times_for_people():
    """They are in seconds, minutes, hours or days, whichever is easiest to read."""
    for seconds, text in [
        (0.24, "0.2 s"),
        (9.94, "9.9 s"),
        (9.96, "10 s"),
        (119.4, "119 s"),
        (600, "10 min"),
        (9000, "2.5 h"),
        (400000, "4.7 days"),
    ]:
        assert duration(seconds) == text
