"""From starts to columns: measures and derived variables of each cell, on any number of threads or devices."""

import math
from dataclasses import replace

import numpy as np
import pytest
from kernel_runner import process, run_blocks

import sweep
from kernels.disk.endings import BOUNDED, FELL, HORIZON, INVALID, STEADY
from sweep.engine import compute
from sweep.engine.grid import Span, starts_of, whole
from sweep.errors import RequestError
from sweep.model.disk.contact import CONTACT
from sweep.model.disk.exact import REDUCE, WELLS
from sweep.model.disk.model import DISK
from sweep.model.disk.tables import CONTACT_VARIABLES, REDUCTION, VARIABLES
from sweep.model.quantity import STABLE, UNDECIDED, UNSTABLE
from sweep.request.spec import SweepSpec

GRID = SweepSpec(roll_rate="2:4:13", tilt="0.1deg:20deg:7:log")


def columns(spec, **how):
    """Return the columns of all cells, with the blocks joined."""
    found = list(run_blocks(spec, **how))
    return {name: np.concatenate([each.columns[name] for each in found]) for name in found[0].columns}


def bits(spec, **how):
    """Return all computed columns as bytes."""
    return {name: column.tobytes() for name, column in columns(spec, **how).items()}


def test_a_block_holds_every_variable():
    """Blocks are contiguous, and each has all variables of the table with their types."""
    found = list(run_blocks(GRID, block_cells=40))
    assert [each.span for each in found] == [Span(0, 40), Span(40, 80), Span(80, 91)]
    for each in found:
        assert list(each.columns) == list(VARIABLES)
        for name, column in each.columns.items():
            assert (column.dtype, column.shape) == (VARIABLES[name].dtype, (len(each.span),))


def test_bits_depend_on_the_cell_alone():
    """Threads, blocks and neighboring cells do not change a bit of a cell."""
    for spec in [GRID, SweepSpec.preset("circling").replace(tilt="1deg:25deg:5", precession_rate="-1:4:11")]:
        whole = bits(spec, threads=1)
        for how in ({"block_cells": 1}, {"block_cells": 17}, {"threads": compute.usable_threads(None)}):
            assert bits(spec, **how) == whole
        alone = compute.compute(spec, starts_of(spec, Span(30, 37)))
        assert {name: column.tobytes() for name, column in alone.items()} == {
            name: column[30:37].tobytes() for name, column in columns(spec).items()
        }


def test_the_printed_extreme_tilts():
    """Whole runs agree to the printed digits with the extreme tilts from the exact reduction."""
    for words, least, greatest, digits in [
        ({"tilt_rate": 0.01, "roll_rate": 2.0}, -41.6082, 41.6082, 4),
        ({"tilt_rate": 0.01, "roll_rate": 2.5}, -13.1205, 13.1205, 4),
        ({"tilt_rate": 0.1, "precession_rate": 3.5}, -28.6591, 28.6591, 4),
        ({"tilt": 0.01, "roll_rate": 3.0}, 0.5730, 3.5887, 4),
        ({"tilt": 0.5, "precession_rate": 4.5}, 28.6479, 79.3831, 4),
    ]:
        found = columns(SweepSpec(**words))
        assert found["ending"] == BOUNDED
        assert np.degrees(found["tilt_min"]) == pytest.approx(least, abs=0.5001 * 10**-digits)
        assert np.degrees(found["tilt_max"]) == pytest.approx(greatest, abs=0.5001 * 10**-digits)


def test_derived_measures_follow_from_the_extremes():
    """The peak is the larger magnitude; the amplification is the largest departure over the perturbation."""
    released = GRID.replace(tilt="-20deg,-1deg,1deg,20deg")
    found = columns(released)
    low, high = abs(found["tilt_min"]), abs(found["tilt_max"])
    assert (low > high).any()
    assert (low < high).any()
    np.testing.assert_array_equal(found["peak_tilt"], np.maximum(low, high))
    np.testing.assert_array_equal(
        found["amplification"], found["peak_tilt"] / abs(np.tile(released.tilt.array(), 13))
    )
    circling = SweepSpec(roll_rate="steady", tilt="10deg", precession_rate=1.0, tilt_rate=1e-3)
    found = columns(circling)
    reach = max(found["tilt_max"][0] - math.radians(10), math.radians(10) - found["tilt_min"][0])
    # the kick over the fall rate of the default disk, sqrt(15.696) / s
    assert found["amplification"] == pytest.approx(reach / (1e-3 / math.sqrt(15.696)), rel=1e-12)


def test_how_cells_end():
    """Each ending that a request can reach is reported, with the verdict it implies."""
    for words, ending, verdict in [
        ({"tilt": 0.01, "roll_rate": 4.0}, BOUNDED, STABLE),
        ({"tilt": 0.01, "roll_rate": 1.0}, BOUNDED, UNSTABLE),
        ({"tilt": 0.5}, FELL, UNSTABLE),
        ({"roll_rate": 4.0}, STEADY, UNDECIDED),
        ({"tilt": 0.01, "roll_rate": 4.0, "duration": 0.01}, HORIZON, UNDECIDED),
    ]:
        found = columns(SweepSpec(**words))
        assert (found["ending"], found["stability"]) == (ending, verdict), words
        assert np.isfinite(found["fall_time"]) == (ending == FELL)
        assert np.isnan(found["amplification"]) == (ending == STEADY)


def test_an_impossible_cell_does_not_stop_the_others():
    """A circling cell without precession is invalid and has no numbers; the other cells are computed."""
    found = columns(SweepSpec.preset("circling").replace(tilt="10deg,20deg", precession_rate="-1:1:5"))
    invalid = found["ending"] == INVALID
    assert np.flatnonzero(invalid).tolist() == [2, 7]
    assert (found["ending"][~invalid] == BOUNDED).all()
    assert (found["stability"][invalid] == UNDECIDED).all()
    for name in ("roll_rate", "tilt_min", "tilt_max", "peak_tilt", "amplification"):
        np.testing.assert_array_equal(np.isnan(found[name]), invalid, err_msg=name)


def test_impossible_ways_to_run_are_refused():
    """A number of threads or cells out of range is refused by name and with the given value."""
    for how in [
        {"threads": 0},
        {"threads": 10**6},
        {"threads": True},
        {"block_cells": 0},
        {"block_cells": True},
        {"block_cells": 2.5},
    ]:
        with pytest.raises(RequestError, match=f"got {next(iter(how.values()))}") as caught:
            sweep.run(GRID, **how)
        assert caught.value.where == next(iter(how))


def test_a_number_of_threads_may_be_one_of_numpy():
    """The number of threads may be a NumPy integer."""
    threads = compute.usable_threads(np.int64(1))
    assert (threads, type(threads)) == (1, int)
    compute.check_block_cells(np.int64(1))


@pytest.mark.compiled
def test_a_block_is_kept_without_what_follows_from_it():
    """Measured blocks contain no verdicts or derived columns; these are derived later with the same bits."""
    for words in [
        {},
        {"method": "exact"},
        {"contact": "yes"},
        {"roll_rate": "steady", "precession_rate": 2.0, "tilt_rate": 1e-3},
    ]:
        spec, span = GRID.replace(**words), Span(2, 7)
        measured = compute.measure_block(spec, span)
        assert not {"stability", "amplification", "peak_tilt"} & set(measured)
        assert {*DISK.measures, *DISK.counts, *spec.computed} <= set(measured)
        expected = compute.compute(spec, starts_of(spec, span))
        found = compute.derive_block(spec, span, measured)
        assert list(found) == list(expected) == [*spec.model.cell_variables(spec), *spec.computed]
        for name, column in expected.items():
            assert found[name].dtype == column.dtype
            assert found[name].tobytes() == column.tobytes()


@pytest.mark.compiled
def test_method_and_options_decide_the_variables():
    """method=exact adds the variables of the reduction, and contact=yes those of the contact."""
    for words, more in (
        ({}, ()),
        ({"method": "exact"}, REDUCTION),
        ({"contact": "yes"}, CONTACT_VARIABLES),
        ({"method": "exact", "contact": "yes"}, (*REDUCTION, *CONTACT_VARIABLES)),
    ):
        assert list(columns(SweepSpec(tilt=0.1, roll_rate=3.0, **words))) == [*VARIABLES, *more]


def test_reach_and_scale_of_a_cell():
    """The reach is the larger distance of the extremes from the undisturbed tilt; without extremes it is NaN."""
    spec = SweepSpec(tilt="0.1,0.2,0.3", roll_rate="steady", precession_rate=1.0, tilt_rate=0.5)
    measured = {"tilt_min": np.array([0.05, 0.1, np.nan]), "tilt_max": np.array([0.12, 0.5, np.nan])}
    reach, scale = compute.reach_and_scale(spec, whole(spec), measured)
    assert reach == pytest.approx([0.05, 0.3, np.nan], rel=1e-14, nan_ok=True)
    # the kick over the fall rate of the default disk, sqrt(15.696) / s
    assert scale == pytest.approx(0.5 / math.sqrt(15.696), rel=1e-14)


def test_the_hash_is_of_the_code_that_runs():
    """The hash depends on the kernels of method, options and device, not on grid or criterion."""
    found = {
        words: compute.arithmetic_hash(GRID.replace(**dict(words)))
        for words in (
            (),
            (("method", "exact"),),
            (("contact", "yes"),),
            (("device", "cuda"),),
            (("method", "exact"), ("contact", "yes")),
        )
    }
    assert len(set(found.values())) == len(found)
    other = SweepSpec(tilt="1deg,2deg", criterion="amplification:3", duration=1.0)
    assert compute.arithmetic_hash(other) == found[()]
    assert DISK.kernels(GRID) == (DISK.integrate,)
    assert DISK.kernels(GRID.replace(method="exact", contact="yes")) == (REDUCE, WELLS, CONTACT)


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize(
    ("preset", "verdict"),
    [
        ("rolling roll_rate=2.2:3:35 tilt=1deg,4deg duration=0.05s", "stability"),
        ("torus tube=0.1,0.3 scaled_roll_rate=0.3:0.5:3", "stability"),
        ("kapitza shake=90,110 angle=1deg,5deg duration=0.5s", "ending"),
    ],
)
def test_a_run_on_the_device(tmp_path, preset, verdict):
    """`device=cuda` writes the same atlas as the CPU for several thread blocks; the file names the device."""
    words = ["-m", "sweep", "run", *preset.split()]
    for device, simulator in (("cpu", False), ("cuda", True)):
        done = process(
            [*words, f"device={device}", "-o", f"{device}.nc"], simulator=simulator, folder=tmp_path
        )
        assert done.returncode == 0, done.stderr
    with sweep.open_atlas(tmp_path / "cuda.nc") as device, sweep.open_atlas(tmp_path / "cpu.nc") as cpu:
        assert '"device":"cuda"' in device.attrs["sweep_spec"]
        assert (device[verdict] == cpu[verdict]).all()
        if verdict == "stability":
            assert np.abs(device.peak_tilt - cpu.peak_tilt).max() <= 1e-11


@pytest.mark.parametrize(
    ("words", "facts"),
    [
        (["device=cuda"], ["NVIDIA", "driver", "pip install"]),
        (["device=cuda", "method=exact"], ["method=exact", "device=cuda"]),
        (["device=cuda", "contour_friction=1mm"], ["losses", "minutes"]),
        (["device=gpu"], ["device=cpu", "device=cuda", "gpu"]),
    ],
)
def test_without_cuda_nothing_is_computed(tmp_path, words, facts):
    """A missing device, or a method without it, gives status 2 and advice; there is no fallback."""
    from numba import cuda

    if cuda.is_available() and words == ["device=cuda"]:
        pytest.skip("this machine has a CUDA device")
    command = ["-m", "sweep", "run", "rolling", "tilt=1deg", "-o", "a.nc"]
    done = process([*command, *words], simulator=False, folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "device: " in done.stderr
    assert all(fact in done.stderr for fact in facts), done.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_hash_follows_the_types_of_what_is_measured(monkeypatch):
    """The hash depends on the types of the measures, but not on derived variables."""
    spec, variables = SweepSpec(), dict(DISK.variables)
    before = compute.arithmetic_hash(spec)
    for name, same in (("steps", False), ("amplification", True)):
        changed = {**variables, name: replace(variables[name], dtype="f8" if name == "steps" else "f4")}
        monkeypatch.setattr(type(DISK), "variables", changed)
        assert (compute.arithmetic_hash(spec) == before) is same


@pytest.mark.compiled
@pytest.mark.parametrize("criterion", ["nutation_period > 3.2s", "wells == two_wells", "peak_tilt > 10deg"])
def test_verdicts_alone_are_those_of_all_columns(criterion):
    """Verdicts computed alone equal those computed with all columns, whatever the criterion uses."""
    spec = GRID.replace(method="exact", criterion=criterion)
    every, only = (compute.compute(spec, whole(spec), verdicts_only) for verdicts_only in (False, True))
    assert {STABLE, UNSTABLE} <= set(every["stability"].tolist())
    assert np.array_equal(only["stability"], every["stability"])


@pytest.mark.compiled
@pytest.mark.parametrize(
    "words",
    [
        {"roll_rate": "2:4:3", "tilt": "1deg:9deg:3"},
        {"roll_rate": "uniform:2:4", "tilt": 0.01, "samples": 7},
        {"roll_rate": "steady", "tilt": "1deg:9deg:3", "precession_rate": "1:3:2"},
    ],
    ids=str,
)
def test_stored_quantities_are_the_variables_with_cells(words):
    """A block has the variables that an atlas stores per cell, including the listed parameters."""
    spec = SweepSpec(**words)
    stored = compute.stored_quantities(spec)
    atlas = sweep.run(spec)
    cells = {name for name, each in atlas.variables.items() if each.dims == atlas.ending.dims}
    assert stored.keys() == compute.compute(spec, whole(spec)).keys() == cells - {"start"}
