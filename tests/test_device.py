"""device=cuda on the command line, run by Numba's simulator; and what is said where there is no CUDA."""

import numpy as np
import pytest
from kernel_runner import process

import sweep


@pytest.mark.compiled
def test_a_run_on_the_device(tmp_path):
    """`device=cuda` on the command line writes the atlas of the CPU; the file says which device it was."""
    words = ["-m", "sweep", "run", "rolling", "roll_rate=2.2:3:5", "tilt=1deg,4deg"]
    for device, simulator in (("cpu", False), ("cuda", True)):
        done = process(
            [*words, f"device={device}", "-o", f"{device}.nc"], simulator=simulator, folder=tmp_path
        )
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
    done = process([*command, *words], simulator=False, folder=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert what in done.stderr
    assert do in done.stderr
    assert list(tmp_path.iterdir()) == []
