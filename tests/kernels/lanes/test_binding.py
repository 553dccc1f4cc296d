"""Lanes for any model, here a small one besides the disk, and what binding does to functions."""

import types

import numpy as np
import pytest

from kernels.disk import integrate as disk
from kernels.jit import kernel, simd
from kernels.lanes import schedule
from kernels.lanes.binding import bind, copied, rebound, replacements, variant
from kernels.lanes.interface import LaneModel
from kernels.lanes.layout import LANES, offsets, place_rows

# The model: a value grows by a rate per step up to a goal, and then returns to zero at the opposite rate.
VALUE, RATE, STEPS, LEG, TOTAL = offsets(0, 5)
LAYOUT = types.SimpleNamespace(STEPPING=2 * LANES, RETURNED=RATE, STEPS=STEPS, SIZE=5 * LANES)


@kernel
def prepared_settings(settings):
    """Return the goal."""
    return (settings[0],)


@simd
def read_start(cell, lane, starts, run, lanes, measures, counts):
    """Read a start, which must have a positive rate."""
    if not starts[0, cell] > 0.0:
        measures[0, cell], counts[0, cell] = np.nan, -1
        fill_idle(lane, lanes)
        return False
    lanes[RATE + lane], lanes[LEG + lane], lanes[TOTAL + lane] = starts[0, cell], 0.0, 0.0
    return True


@kernel
def fill_idle(lane, lanes):
    """Fill an idle lane with a rate of one."""
    lanes[RATE + lane], lanes[LEG + lane], lanes[TOTAL + lane] = 1.0, 0.0, 0.0


@simd
def prepare(lane, run, lanes):
    """Start at zero."""
    lanes[VALUE + lane] = 0.0


@simd
def needs_integration(cell, lane, run, lanes, measures, counts):
    """Skip the integration if one step would pass the goal."""
    if lanes[RATE + lane] > run[0]:
        measures[0, cell], counts[0, cell] = lanes[RATE + lane], 0
        return False
    return True


@simd
def set_off(lane, run, lanes):
    """Set the sign of the rate, negative on the second leg."""
    rate = lanes[RATE + lane]
    lanes[RATE + lane] = -abs(rate) if lanes[LEG + lane] > 0.0 else abs(rate)


@simd
def advance(lane, run, lanes):
    """Make one step; at an end, set the rate to zero."""
    rate = lanes[RATE + lane]
    value = lanes[VALUE + lane] + rate
    ended = (value >= run[0]) | (value <= 0.0)
    lanes[VALUE + lane] = value
    lanes[RATE + lane] = 0.0 if ended else rate
    return ended


@simd
def land(lane, run, lanes):
    """Add the steps of the leg."""
    lanes[TOTAL + lane] += lanes[STEPS + lane]


@simd
def finish_leg(cell, lane, run, lanes, measures, counts):
    """Start the second leg, or write the results after it."""
    if lanes[LEG + lane] == 0.0:
        lanes[LEG + lane] = 1.0
        measures[0, cell] = lanes[VALUE + lane]
        set_off(lane, run, lanes)
        return True
    counts[0, cell] = int(lanes[TOTAL + lane])
    return False


MODEL = LaneModel(
    name="counter",
    layout=LAYOUT,
    prepared_settings=prepared_settings,
    read_start=read_start,
    fill_idle=fill_idle,
    prepare=prepare,
    needs_integration=needs_integration,
    set_off=set_off,
    advance=advance,
    land=land,
    finish_leg=finish_leg,
)

GOAL = 64.0


@pytest.fixture(scope="module")
def integrate():
    """Return the entry point of the small model."""
    return bind(MODEL)


def results(integrate, rates):
    """Return the values and step counts of cells with the given rates."""
    measures, counts = np.full((1, len(rates)), -777.0), np.full((1, len(rates)), -777, np.int32)
    integrate(np.array([rates]), np.array([GOAL]), measures, counts)
    return measures[0], counts[0]


@pytest.mark.slow_lane
def test_cells_of_different_lengths(integrate):
    """Every cell takes the steps of its own two legs, for any number of cells and any neighbors."""
    for n in [0, 1, LANES - 1, LANES, 5 * LANES + 3, 2 * schedule.CHUNK + 5]:
        rates = 2.0 ** np.random.default_rng(n).integers(-2, 7, n)
        values, steps = results(integrate, rates)
        assert (values == GOAL).all(), n
        assert (steps == 2 * GOAL / rates).all(), n


def test_cells_without_a_leg(integrate):
    """Cells that are finished before or after `prepare` leave their lanes to others."""
    rates = np.tile([4.0, np.nan, 65.0, -1.0], LANES)
    values, steps = results(integrate, rates)
    assert list(steps[:4]) == [32, -1, 0, -1]
    assert (steps == np.tile(steps[:4], LANES)).all()
    assert (values[2::4] == 65.0).all()


#: True if the small model grows twice as fast.
FAST = False


@simd
def advance_by_flag(lane, run, lanes):
    """Like `advance`, but double the rate if FAST is set."""
    rate = lanes[RATE + lane]
    value = lanes[VALUE + lane] + (2.0 * rate if FAST else rate)
    ended = (value >= run[0]) | (value <= 0.0)
    lanes[VALUE + lane] = value
    lanes[RATE + lane] = 0.0 if ended else rate
    return ended


@pytest.mark.slow_lane
def test_a_variant_has_other_flags(integrate):
    """A flag has its value in the functions of its own variant only."""
    rates = 2.0 ** np.random.default_rng(1).integers(-2, 5, 100)
    usual = bind(MODEL._replace(name="by flag", advance=advance_by_flag))
    other = bind(MODEL._replace(name="by other flag", advance=advance_by_flag, flags={"FAST": True}))
    assert (results(usual, rates)[1] == results(integrate, rates)[1]).all()
    # twice as fast up but back in one step: the second leg starts with the rate that ended the first
    assert (results(other, rates)[1] == GOAL / rates).all()


@simd
def step_on(lane, number, run, lanes):
    """Make several steps without checking the goal; an ended lane has rate zero."""
    lanes[VALUE + lane] += number * lanes[RATE + lane]


@pytest.mark.slow_lane
def test_a_model_may_make_steps_without_looking_for_events():
    """Further steps follow each checked step, so fewer checks reach the goal; a lane with an event rests."""
    stepping = bind(MODEL._replace(name="stepping", further_step=step_on, further_steps=np.ones(1)))
    further = bind(MODEL._replace(name="further", further_step=step_on, further_steps=np.array([1.0, 2.0])))
    rates = np.array([4.0, 1.0, 8.0, 2.0])
    values, looks = results(stepping, rates)
    # steps 1, 3, 5, ... are checked: up to the first odd number beyond the goal, and as many back
    assert (values == GOAL + rates).all()
    assert (looks == GOAL / rates / 2 + 2).all()
    values, looks = results(further, rates)
    # steps 1, 5, 9, ...
    assert (values == GOAL + rates).all()
    assert (looks == GOAL / rates / 4 + 2).all()


#: A lane of `pausing` rests at every multiple of four until it is continued; KEPT holds the cell's rate.
KEPT, OWED = LEG, TOTAL


@simd
def begin_pausing(lane, run, lanes):
    """Start at zero and save the rate."""
    lanes[VALUE + lane], lanes[KEPT + lane], lanes[OWED + lane] = 0.0, lanes[RATE + lane], 0.0


@simd
def keep_set_off(lane, run, lanes):
    """Do nothing, because there is only one leg."""


@simd
def pause(lane, run, lanes):
    """Make one step, or report an event if the rate is zero, as at every multiple of four."""
    value = lanes[VALUE + lane] + lanes[RATE + lane]
    pausing = lanes[RATE + lane] == 0.0
    lanes[VALUE + lane] = value
    lanes[RATE + lane] = 0.0 if value % 4.0 == 0.0 else lanes[RATE + lane]
    return pausing


@kernel
def unpause(lane, place, run, memory):
    """Restore the cell's rate, except at the goal."""
    memory[RATE + lane] = memory[KEPT + place] if memory[VALUE + lane] < run[0] else 0.0
    return memory[RATE + lane] != 0.0


@simd
def count(lane, run, lanes):
    """Count the steps of the only leg, without the one that found its end."""
    lanes[OWED + lane] = lanes[STEPS + lane] - 1.0


@kernel
def write_pausing(cell, lane, run, lanes, measures, counts):
    """Write the results."""
    measures[0, cell], counts[0, cell] = lanes[VALUE + lane], int(lanes[OWED + lane])
    return False


@pytest.mark.slow_lane
def test_a_lane_may_go_on_at_once_after_an_event():
    """A lane with an event rests, uncounted, until it continues with the numbers of its own cell."""
    pausing = bind(
        MODEL._replace(
            name="pausing", prepare=begin_pausing, set_off=keep_set_off, advance=pause, go_on=unpause, land=count,
            finish_leg=write_pausing,
        )
    )  # fmt: skip
    rates = 2.0 ** np.random.default_rng(3).integers(-2, 5, 7 * LANES + 3)
    values, steps = results(pausing, rates)
    assert (values == GOAL).all()
    assert (steps == GOAL / rates).all()


def test_each_model_has_an_entry_point_of_its_own(integrate):
    """Binding one model does not change the schedule or the entry point of another."""
    assert bind(MODEL) is not integrate
    assert getattr(disk.integrate, "py_func", disk.integrate).__globals__ is not vars(schedule)
    assert schedule.advance.__module__ == "kernels.lanes.interface"


def test_copies_of_two_models_have_different_names():
    """Numba names machine code by module, function and number, and the linker takes the first of equal names."""
    names = []
    for model in (MODEL, disk.LANE_MODEL):
        made = {}
        rebound(
            schedule.integrate,
            replacements(model),
            {},
            lambda *given, model=model: copied(model.name, *given),
            made,
        )
        copies = [
            copy for source, (copy, _) in made.items() if source.__module__.startswith("kernels.lanes.")
        ]
        names.append({(copy.__module__, copy.__qualname__) for copy in copies})
        assert len(copies) == len(names[-1]) > 5
    assert not names[0] & names[1]


def test_a_flag_that_no_function_uses_is_refused():
    """A misspelled flag would silently have no effect."""
    with pytest.raises(ValueError, match="FASTER"):
        bind(MODEL._replace(name="misspelt", advance=advance_by_flag, flags={"FAST": True, "FASTER": True}))
    with pytest.raises(ValueError, match="advence"):
        variant(schedule.integrate, "misspelt", {"advence": advance_by_flag})


def test_rows_follow_from_their_names():
    """Stepping rows come first; a duplicate name is refused, because two quantities would share a place."""
    rows = place_rows(("A B", "C"), ("D",), returned="C")
    offsets_of = {"A": 0, "B": LANES, "C": 2 * LANES, "D": 3 * LANES}
    assert rows == {**offsets_of, "STEPPING": 3 * LANES, "SIZE": 4 * LANES, "RETURNED": 2 * LANES}
    with pytest.raises(ValueError, match="A B C A"):
        place_rows(("A B", "C"), ("A",), returned="C")
