"""What the cells are integrated on: the processor, or an NVIDIA device. Never the one in place of the other."""

from collections.abc import Callable
from functools import lru_cache

from sweep.engine import compiled
from sweep.errors import RequestError
from sweep.request.spec import SweepSpec


def check_device(spec: SweepSpec) -> None:
    """Refuse a spec whose device is not there, or cannot do what is asked for.

    Raises
    ------
    RequestError
    """
    if spec.device == "cpu":
        return
    if spec.method != "rk4":
        raise RequestError(
            "that method does not run on that device",
            "device=cuda goes with method=rk4",
            f"method={spec.method} device={spec.device}",
            "leave device out: the exact method is fast without one",
            "device",
        )
    missing = _missing()
    if missing:
        raise RequestError(
            "this machine cannot compute with CUDA",
            "device=cuda needs an NVIDIA device, its driver and the extra cuda",
            missing,
            "install the driver and `pip install 'eulerdisk[cuda]'`, or leave device=cuda out",
            "device",
        )


def integrator(spec: SweepSpec) -> Callable[..., None]:
    """Return the lane kernel for the device of a spec: `kernels.disk.integrate` or `kernels.disk.integrate_cuda`.

    Raises
    ------
    RequestError
        As `check_device`.
    """
    if spec.device == "cpu":
        return compiled.integrate()
    check_device(spec)
    from kernels.disk import integrate_cuda

    kernel: Callable[..., None] = integrate_cuda.integrate
    return kernel


@lru_cache
def _missing() -> str:
    """What keeps CUDA from being used; empty if nothing does."""
    try:
        from numba import cuda

        return "" if cuda.is_available() else "device=cuda, and no device with a driver was found"
    except ImportError as problem:
        return f"device=cuda, and {problem}"
