"""Build the WebAssembly module with which the explorer's page computes: sweep/explorer/page/kernels.wasm.

    python scripts/build_page_module.py [PATH]

The same versions of Numba and llvmlite give the same bytes; the module records the versions and the hash of its code.
tests/explorer/test_page_module.py checks that this is the present code, and in the slow lane builds the module again.
"""

import sys
from pathlib import Path

from kernels.native import wasm
from sweep.model.kernel import code_hash

TARGET = Path(__file__).resolve().parents[1] / "sweep" / "explorer" / "page" / "kernels.wasm"


def sources() -> dict[str, str]:
    """Return the hash of the module's code, and the versions of the tools that build it."""
    import llvmlite
    import numba

    code = code_hash(["kernels.page.module", "kernels.page.c_library", "kernels.native.wasm"])
    return {"code": code, "numba": numba.__version__, "llvmlite": llvmlite.__version__}


def build() -> bytes:
    """Return the bytes of the module; must run in a process that has not compiled anything yet."""
    wasm.begin()
    from kernels.page.c_library import C_LIBRARY
    from kernels.page.module import ENTRIES
    from kernels.page.sizes import sizes_of

    made: bytes = wasm.module(ENTRIES, C_LIBRARY, {**sizes_of(ENTRIES), "made_of": sources()})
    return made


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else TARGET
    target.write_bytes(build())
    print(f"{target}: {target.stat().st_size} bytes")
