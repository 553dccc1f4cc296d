"""What decides the bits of a cell on this machine, beside the code: how it rounds, and the values of the axes.

Names of processors and of their features say less than a probe: which of them change a bit depends on the compiler, the
C library and NumPy. So a small kernel is run and its results are hashed, and so are the starts of the cells.
"""

import hashlib
import os
from collections.abc import Mapping
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from sweep.engine.grid import Span, blocks, starts_of
from sweep.errors import RequestError
from sweep.model.kernel import Kernel
from sweep.model.quantity import GRID, Array
from sweep.platforms import check_features
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec

_PROBE = Kernel("kernels.rounding", "probe", seconds=1.0)

#: Rows and columns of the results of the probe; cells at each end of the grid whose starts are compared.
_ROWS, _COLUMNS, _CELLS = 12, 4000, 256

#: Common baseline -> the environment in which a process computes its bits, on every processor that has the features.
_BASELINES: dict[str, tuple[Mapping[str, str], tuple[str, ...]]] = {
    # the C library of Linux has its own variants for processors with fused multiply-add
    "generic": (
        {
            "NUMBA_CPU_NAME": "generic",
            "NUMBA_CPU_FEATURES": "",
            "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4",
        },
        (),
    ),
    "x86-64-v3": ({"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}, ("avx2", "bmi2", "fma")),
}


def environment(baseline: str) -> Mapping[str, str]:
    """Return the environment variables of a common baseline, with which a process has to be started; none for "".

    Raises
    ------
    RequestError
        If there is no such baseline, or this processor lacks its features.
    """
    if not baseline:
        return {}
    if baseline not in _BASELINES:
        raise RequestError(
            f"There is no baseline {baseline!r}; the baselines are {', '.join(_BASELINES)}.",
            hint="Choose generic for processors of every kind, x86-64-v3 for those with AVX2.",
            where="--baseline",
        )
    variables, features = _BASELINES[baseline]
    check_features(baseline, features)
    return variables


def in_words(baseline: str) -> str:
    """Return the environment variables of a baseline as they stand before a command in a shell."""
    return " ".join(f"{name}='{value}'" for name, value in environment(baseline).items())


def check_baseline(baseline: str) -> None:
    """Refuse to compute for a common baseline in a process that was not started for it.

    Raises
    ------
    RequestError
    """
    if any(os.environ.get(name) != value for name, value in environment(baseline).items()):
        raise RequestError(
            f"The run is computed for the baseline {baseline}, and this process was not started for it.",
            hint=f"Start it with {in_words(baseline)}; the command line does that by itself.",
            where="baseline",
        )


def facts(spec: SweepSpec) -> dict[str, str]:
    """Return what decides the bits of the cells of a spec on this machine: see the module."""
    fused, rounding = _rounding()
    return {"fused_multiply_add": fused, "rounding": rounding, "starts": starts_hash(spec)}


@lru_cache
def _rounding() -> tuple[str, str]:
    """Return whether compiled code has fused multiply-add, and the SHA-256 of the results of the probe."""
    values = 0.1 + 3.0 * np.random.Generator(np.random.PCG64(1)).random((3, _COLUMNS))
    # (1 + e)(1 - e) - 1 is 0 if the product is rounded first, and -e**2 if it is not
    values[:, 0] = 1.0 + 2.0**-30, 1.0 - 2.0**-30, 1.0
    results = np.zeros((_ROWS, _COLUMNS))
    _PROBE.load()(values, results)
    return "no" if results[0, 0] == 0.0 else "yes", hashlib.sha256(results.tobytes()).hexdigest()


def starts_hash(spec: SweepSpec) -> str:
    """Return the SHA-256 of the values of all axes, and of the completed starts of the first and last cells."""
    digest = hashlib.sha256()
    # the numbers of a list of starts are what they are everywhere
    for name in () if spec.is_list else spec.axes:
        axis = getattr(spec, name)
        assert isinstance(axis, Range | Values)
        for span in blocks(len(axis)):
            digest.update(axis.at(np.arange(span.start, span.stop)).tobytes())
    for span in (Span(0, min(spec.size, _CELLS)), Span(max(0, spec.size - _CELLS), spec.size)):
        for values in starts_of(spec, span).values():
            digest.update(np.asarray(values, np.float64).tobytes())
    return digest.hexdigest()


class RecordedRange(Range):
    """A range with the values that the machine has computed which prepared the run; reads and prints as a range."""

    def array(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Return the values, shape (count,)."""
        return np.array(self._recorded)

    def at(self, places: npt.ArrayLike) -> Array:
        """Return the values at some places, shape of `places`."""
        return self.array()[np.asarray(places, np.intp)]

    @classmethod
    def of(cls, given: Range, values: list[float]) -> "RecordedRange":
        """Return a range with recorded values."""
        made = cls(given.start, given.stop, given.count, given.spacing)
        object.__setattr__(made, "_recorded", tuple(values))
        return made

    _recorded: tuple[float, ...]


def recorded_axes(spec: SweepSpec) -> dict[str, list[float]]:
    """Return the values of the axes whose last bits depend on the processor: logarithmic ones."""
    axes = {name: getattr(spec, name) for name in spec.axes}
    return {
        name: axis.array().tolist() for name, axis in axes.items() if getattr(axis, "spacing", "") == "log"
    }


def fits_axes(spec: SweepSpec, axes: object) -> bool:
    """Return whether `axes`, read from a file, is what `recorded_axes` returns for a spec, but for the last bits."""
    if not isinstance(axes, dict):
        return False
    expected = recorded_axes(spec)
    return all(
        name in expected
        and isinstance(values, list)
        and len(values) == len(expected[name])
        and all(isinstance(each, float) for each in values)
        and np.allclose(values, expected[name], rtol=GRID.relative, atol=GRID.absolute)
        for name, values in axes.items()
    )


def with_axes(spec: SweepSpec, axes: Mapping[str, list[float]]) -> SweepSpec:
    """Return a spec whose axes have recorded values; its text and fingerprint are the same."""
    return spec.replace(
        **{name: RecordedRange.of(getattr(spec, name), values) for name, values in axes.items()}
    )
