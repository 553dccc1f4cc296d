"""The CUDA kernel, run by Numba's simulator, against the CPU; and what is said where there is no CUDA."""

import os
import subprocess
import sys
from pathlib import Path

import engine
import numpy as np
import pytest
import referee

import sweep
from kernels.disk.endings import FELL, HORIZON, INVALID, STEADY, UNRESOLVED

CHECKOUT = Path(__file__).parents[1]

_SIMULATED = """
import sys, numpy as np
from kernels.lanes.cuda import integrate
held = np.load(sys.argv[1])
n = held["starts"].shape[1]
measures, counts = np.full((6, n), -777.0), np.full((3, n), -777, np.int32)
with np.errstate(all="ignore"):  # plain Python warns of what compiled code passes over
    integrate(held["starts"], held["settings"], measures, counts)
np.savez(sys.argv[2], measures=measures, counts=counts)
"""


def _process(code, *words, simulator, folder):
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT), "NUMBA_ENABLE_CUDASIM": str(int(simulator))}
    # the warnings of what a simulator is made of are not ours
    return subprocess.run(
        [sys.executable, *code, *map(str, words)],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip


def simulated(tmp_path, starts, duration=300.0, step=0.0, tolerance=1e-8):
    """Return the `engine.Results` of the CUDA kernel, one thread of Python per cell."""
    given, found = tmp_path / "given.npz", tmp_path / "found.npz"
    np.savez(given, starts=starts, settings=np.array([duration, step, referee.FALL_TILT, tolerance]))
    done = _process(["-c", _SIMULATED], given, found, simulator=True, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with np.load(found) as held:
        return engine.Results(*held["measures"], *held["counts"])


def assert_same(device, cpu, tilt):
    """Endings, refinements and steps are equal, tilts within `tilt` [rad], times likewise."""
    assert list(device.ending) == list(cpu.ending)
    assert list(device.refinements) == list(cpu.refinements)
    # the last bit can move a turning point across the end of a step
    assert np.abs(device.steps - cpu.steps).max() <= 2
    for name in ("least", "greatest", "energy_drift", "tilt_error"):
        np.testing.assert_allclose(getattr(device, name), getattr(cpu, name), rtol=0.0, atol=tilt)
    for name in ("fall_time", "period"):
        np.testing.assert_allclose(getattr(device, name), getattr(cpu, name), rtol=1e-9)


@pytest.mark.compiled
def test_a_small_grid_on_the_device(tmp_path):
    """All over the seven parameters a device thread says what a CPU lane says, and both agree with the referee."""
    given = engine.scattered(40, seed=11)
    device, truth = simulated(tmp_path, given), referee.extremes(given)
    assert_same(device, engine.run(given), 1e-12)
    assert list(device.ending == FELL) == list(truth.fell)
    assert engine.errors(device, truth).max() <= 1e-7


@pytest.mark.compiled
def test_every_ending_and_refinement_on_the_device(tmp_path):
    """Steady, horizon, fell, invalid and unresolved cells, and a step that is refined, end as on the CPU."""
    given = referee.starts(
        tilt=[0.0, 0.2, 1.0, 2.0, 0.3, 1.5],
        tilt_rate=[0.0, 0.0, 0.0, 0.0, np.nan, 0.0],
        roll_rate=[3.0, 1.0, 0.0, 1.0, 1.0, 1.0],
    )
    device, cpu = simulated(tmp_path, given, duration=0.5), engine.run(given, duration=0.5)
    assert_same(device, cpu, 1e-12)
    assert {STEADY, HORIZON, FELL, INVALID} <= set(device.ending)
    long = referee.starts(tilt=[0.3, 0.5], roll_rate=[4.0, 3.0])
    device, cpu = simulated(tmp_path, long, step=0.3), engine.run(long, step=0.3)
    assert_same(device, cpu, 1e-9)
    assert (device.refinements >= 1).all()
    hopeless = {"step": 1e-7, "duration": 1e3}
    device, cpu = simulated(tmp_path, long, **hopeless), engine.run(long, **hopeless)
    assert list(device.ending) == list(cpu.ending) == [UNRESOLVED] * 2


@pytest.mark.compiled
def test_a_run_on_the_device(tmp_path):
    """`device=cuda` on the command line writes the atlas of the CPU; the file says which device it was."""
    words = ["-m", "sweep", "run", "rolling", "roll_rate=2.2:3:5", "tilt=1deg,4deg"]
    for device, simulator in (("cpu", False), ("cuda", True)):
        done = _process(words, f"device={device}", "-o", f"{device}.nc", simulator=simulator, folder=tmp_path)
        assert done.returncode == 0, done.stderr
    with sweep.open_atlas(tmp_path / "cuda.nc") as device, sweep.open_atlas(tmp_path / "cpu.nc") as cpu:
        assert '"device":"cuda"' in device.attrs["sweep_spec"]
        assert (device.stability == cpu.stability).all()
        assert np.abs(device.peak_tilt - cpu.peak_tilt).max() <= 1e-12


@pytest.mark.parametrize(
    ("words", "what", "do"),
    [
        (["device=cuda"], "device: this machine cannot compute with CUDA", "install the driver and `pip install"),
        (["device=cuda", "method=exact"], "device: that method does not run on that device", "leave device out"),
        (["device=gpu"], "device: unknown device", "write device=cpu or device=cuda"),
    ],
)  # fmt: skip
def test_without_cuda_nothing_is_computed(tmp_path, words, what, do):
    """A device that is not there, or not for that method, ends with 2 and says what to do; nothing falls back."""
    from numba import cuda

    if cuda.is_available() and words == ["device=cuda"]:
        pytest.skip("this machine has a CUDA device")
    command = ["-m", "sweep", "run", "rolling", "tilt=1deg", "-o", "a.nc"]
    done = _process(command, *words, simulator=False, folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert what in done.stderr
    assert do in done.stderr
    assert list(tmp_path.iterdir()) == []
