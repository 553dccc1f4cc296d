"""The WebAssembly module of a page that does not show the thin disk, made on the user's machine."""

import json
import subprocess
import sys
from functools import lru_cache
from pathlib import Path
from threading import Lock
from typing import Any

from sweep.errors import RequestError
from sweep.explorer.body import is_body
from sweep.explorer.system import is_system
from sweep.model.kernel import kept_bytes
from sweep.notices import notice
from sweep.request.spec import SweepSpec

#: Program that makes the module, for a separate process in which no kernel has been compiled yet
#: (`kernels.native.wasm`).
_BUILD = """
import json
import sys
from kernels.native import wasm
wasm.begin()
from kernels.page.c_library import C_LIBRARY
from kernels.page.{room} import entries_and_sizes
entries, sizes = entries_and_sizes(*json.load(sys.stdin))
sys.stdout.buffer.write(wasm.module(entries, C_LIBRARY, sizes))
"""

#: Body -> the body whose kernels compute it with other numbers; their pages have the same module.
_KERNELS_OF = dict.fromkeys(("rounded", "rim", "arc"), "torus")

#: A page asks for its module from several threads at once; only the first makes it.
_making = Lock()


def has_own_module(spec: SweepSpec | None) -> bool:
    """Return whether a spec is given and its cells need a module other than the built-in one of the disk."""
    return is_system(spec) or is_body(spec)


def kernels_of(spec: SweepSpec | None) -> bytes | None:
    """Return the module that computes the cells of a spec in a page; None if it is the built-in one of the disk.

    Making it takes ten to thirty seconds; it is cached on disk.

    Raises
    ------
    RequestError
        If it cannot be made here.
    """
    if spec is None or not has_own_module(spec):
        return None
    arguments: list[Any]
    if is_system(spec):
        told, room, arguments = spec.model.integrate.told, "system", [spec.model.integrate.function]
    else:
        contact, path = (getattr(spec, name, None) == "yes" for name in ("contact", "path"))
        told, room = f"the kernel of a {spec.body}", "bodies"
        arguments = [_KERNELS_OF.get(spec.body, spec.body), contact, path]
    code = [f"kernels.page.{room}", "kernels.page.c_library", "kernels.native.wasm"]
    given = json.dumps(arguments)
    with _making:
        return kept_bytes(
            f"page_{room}", code, given, lambda: _make_module(told, _BUILD.format(room=room), given)
        )


@lru_cache(maxsize=8)
def _make_module(told: str, program: str, given: str) -> bytes:
    """Return the output of a program that makes a module; raises as `kernels_of`."""
    notice(f"Compiling {told} for the page (ten to thirty seconds) ...")
    # Python looks for modules in this folder first: it contains the packages, and no files of the user
    packages = Path(__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", program], input=given.encode(), cwd=packages, capture_output=True, check=False
    )
    if done.returncode:
        *_, said = ["no reason was given", *done.stderr.decode(errors="replace").strip().splitlines()]
        raise RequestError(
            f"{told[0].upper()}{told[1:]} could not be compiled for the page: {said}.",
            hint="Draw an atlas with eulerdisk plot instead.",
        )
    return done.stdout
