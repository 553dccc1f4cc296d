"""Models on a CUDA device, in Numba's simulator, compared with the CPU."""

from types import SimpleNamespace

import kernel_runner
import numpy as np
import pytest
import referee

from kernels.disk.endings import FELL, HORIZON, INVALID, STEADY, UNRESOLVED
from kernels.lanes import cuda as device
from sweep.engine.grid import whole
from sweep.request.spec import SweepSpec


def test_a_device_that_fails_is_told(monkeypatch):
    """A missing device, a compiler that fails and a wrong number each have their reason."""

    def fail(_):
        raise AttributeError("module 'numpy' has no attribute 'row_stack'")

    for available, jit, reason in [
        (False, fail, "no device"),
        (True, fail, "row_stack"),
        (True, lambda _: {(1, 1): lambda numbers: None}, "wrong number"),
        (True, lambda kernel: {(1, 1): kernel}, ""),
    ]:
        monkeypatch.setattr(device, "cuda", SimpleNamespace(is_available=lambda a=available: a, jit=jit))
        assert reason in device.problem()
        assert bool(device.problem()) == bool(reason)


_SIMULATED = """
import sys, numpy as np
from kernel_runner import unwritten
from kernels.disk.integrate import LANE_MODEL
from kernels.lanes.cuda import bind
held = np.load(sys.argv[1])
measures, counts = unwritten(held["starts"].shape[1])
with np.errstate(all="ignore"):  # plain Python warns of what compiled code passes over
    bind(LANE_MODEL)(held["starts"], held["settings"], measures, counts)
np.savez(sys.argv[2], measures=measures, counts=counts)
"""


def simulated(tmp_path, starts, duration=300.0, step=0.0, tolerance=1e-8):
    """Return the `kernel_runner.Results` of the CUDA kernel with one Python thread per cell."""
    given, found = tmp_path / "given.npz", tmp_path / "found.npz"
    np.savez(given, starts=starts, settings=np.array([duration, step, referee.FALL_TILT, tolerance]))
    done = kernel_runner.process(["-c", _SIMULATED, given, found], simulator=True, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with np.load(found) as held:
        return kernel_runner.Results.of(held["measures"], held["counts"])


def assert_same(device, cpu, tilt):
    """Assert equal endings, refinements and steps, and tilts and times within `tilt` [rad]."""
    assert list(device.ending) == list(cpu.ending)
    assert list(device.refinements) == list(cpu.refinements)
    # the last bit can move a turning point across the end of a step
    assert np.abs(device.steps - cpu.steps).max() <= 2
    for name in ("least", "greatest", "energy_drift", "tilt_error"):
        np.testing.assert_allclose(getattr(device, name), getattr(cpu, name), rtol=0.0, atol=tilt)
    for name in ("fall_time", "period"):
        np.testing.assert_allclose(getattr(device, name), getattr(cpu, name), rtol=1e-9)


@pytest.mark.release
@pytest.mark.compiled
def test_a_small_grid_on_the_device(tmp_path):
    """For all seven parameters, device threads agree with CPU lanes and with the referee."""
    given = kernel_runner.scattered(40, seed=11)
    device, truth = simulated(tmp_path, given), referee.extremes(given)
    assert_same(device, kernel_runner.run(given), 1e-12)
    assert list(device.ending == FELL) == list(truth.fell)
    assert kernel_runner.errors(device, truth).max() <= 1e-7


@pytest.mark.slow_lane
@pytest.mark.compiled
def test_every_ending_and_refinement_on_the_device(tmp_path):
    """Steady, horizon, fell, invalid and unresolved cells, and a refined step, end as on the CPU."""
    given = referee.starts(
        tilt=[0.0, 0.2, 1.0, 2.0, 0.3, 1.5],
        tilt_rate=[0.0, 0.0, 0.0, 0.0, np.nan, 0.0],
        roll_rate=[3.0, 1.0, 0.0, 1.0, 1.0, 1.0],
    )
    device, cpu = simulated(tmp_path, given, duration=0.5), kernel_runner.run(given, duration=0.5)
    assert_same(device, cpu, 1e-12)
    assert {STEADY, HORIZON, FELL, INVALID} <= set(device.ending)
    long = referee.starts(tilt=[0.3, 0.5], roll_rate=[4.0, 3.0])
    device, cpu = simulated(tmp_path, long, step=0.3), kernel_runner.run(long, step=0.3)
    assert_same(device, cpu, 1e-9)
    assert (device.refinements >= 1).all()
    hopeless = {"step": 1e-7, "duration": 1e3}
    device, cpu = simulated(tmp_path, long, **hopeless), kernel_runner.run(long, **hopeless)
    assert list(device.ending) == list(cpu.ending) == [UNRESOLVED] * 2


_SIMULATED_MODEL = """
import sys, numpy as np
from importlib import import_module
from kernels.lanes.cuda import bind, problem
from sweep.request.spec import SweepSpec
given, found, preset, *words = sys.argv[1:]
assert problem() == ""
spec, held = SweepSpec.from_words(preset, words), np.load(given)
kernel = spec.model.integrator(spec)
measures, counts = held["measures"].copy(), held["counts"].copy()
with np.errstate(all="ignore"):
    bind(getattr(import_module(kernel.module), kernel.function).lane_model)(
        held["starts"], held["settings"], measures, counts
    )
np.savez(found, measures=measures, counts=counts)
"""


@pytest.mark.slow_lane
@pytest.mark.compiled
@pytest.mark.parametrize(
    "words",
    [
        ["torus", "tube=0.1,0.3", "scaled_roll_rate=0.3:0.5:3"],
        [
            "rolling",
            "body=rim",
            "thickness=0.2",
            "fillet=0.05",
            "tilt=-40deg,20deg",
            "roll_rate=3",
            "duration=1",
        ],
        [
            "rolling",
            "tilt=20deg,70deg",
            "roll_rate=3",
            "contour_friction=1mm",
            "friction=0.3",
            "duration=0.3",
        ],
        ["kapitza", "shake=90,110", "angle=1deg,5deg", "duration=1s"],
    ],
    ids=["torus", "rim", "losses", "kapitza"],
)
def test_other_models_on_the_device(tmp_path, words):
    """Bodies, losses with their further steps, and systems whose lanes go on have the CPU's endings and values."""
    spec = SweepSpec.from_words(words[0], words[1:])
    model, starts = spec.model, np.stack([*whole(spec).values()])
    settings = model.kernel_settings(spec)
    n = starts.shape[1]
    measures, counts = np.full((len(model.measures), n), -7.0), np.full((len(model.counts), n), -7, np.int32)
    given, found = tmp_path / "given.npz", tmp_path / "found.npz"
    np.savez(given, starts=starts, settings=settings, measures=measures, counts=counts)
    done = kernel_runner.process(
        ["-c", _SIMULATED_MODEL, given, found, *words], simulator=True, folder=tmp_path
    )
    assert done.returncode == 0, done.stderr
    model.integrator(spec).load()(starts, settings, measures, counts)
    with np.load(found) as device:
        np.testing.assert_allclose(device["measures"], measures, rtol=1e-9, atol=1e-11)
        # the last bit can move an event across the end of a step
        assert np.abs(device["counts"].astype(int) - counts).max() <= 2
        whole_numbers = [row for row, name in enumerate(model.counts) if "ending" in name]
        assert (device["counts"][whole_numbers] == counts[whole_numbers]).all()
        assert len(whole_numbers) > 0
