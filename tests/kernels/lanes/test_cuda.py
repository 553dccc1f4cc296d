"""The disk on a CUDA device, in Numba's simulator, compared with the CPU."""

import kernel_runner
import numpy as np
import pytest
import referee
from messages import refused

from kernels.disk.endings import FELL, HORIZON, INVALID, STEADY, UNRESOLVED
from kernels.disk.integrate import LANE_MODEL as DISK
from kernels.lanes.cuda import bind
from kernels.lossy_disk.integrate import LANE_MODEL as LOSSY_DISK

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


def test_a_model_with_stages_of_the_cpu_alone_is_refused():
    """A model with CPU-only further steps would silently get legs of a quarter of their length."""
    for name in ("further_step", "go_on"):
        with refused("'disk'", "CUDA", f"'{name}'", error=ValueError):
            bind(DISK._replace(**{name: getattr(LOSSY_DISK, name)}))


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
