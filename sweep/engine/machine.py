"""What decides the bits of a cell on this machine, beside the code: its kind of processor, and the starts."""

import hashlib
import os

import numpy as np

from sweep.engine.grid import Span, blocks, starts_of
from sweep.platforms import processor
from sweep.request.axes import Range, Values
from sweep.request.spec import SweepSpec

#: Cells at each end of the grid whose starts are compared.
_CELLS = 256

#: What makes processors of several kinds compute the same bits, set for every process that takes part. NumPy's
#: logarithm has a variant of its own for AVX-512.
SAME_BITS = (
    "NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES= "
    "NPY_DISABLE_CPU_FEATURES='AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR'"
)


def facts(spec: SweepSpec) -> dict[str, str]:
    """Return the kind of processor that kernels are compiled for, and the SHA-256 of the starts of a spec."""
    name, features = (os.environ.get(f"NUMBA_CPU_{each}", "") for each in ("NAME", "FEATURES"))
    return {"processor": f"{name or processor()} {features}".rstrip(), "starts": starts_hash(spec)}


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
