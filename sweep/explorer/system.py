"""What the page has to know to compute the cells of a user's system: its expressions, and the module of its kernel."""

import subprocess
import sys
from functools import lru_cache
from pathlib import Path
from typing import Any

from sweep.errors import RequestError
from sweep.model.kernel import Kernel
from sweep.model.system import passes, tables
from sweep.model.system.definition import Constant, Node, Symbol
from sweep.model.system.model import SystemModel
from sweep.notices import notice
from sweep.request.spec import SweepSpec

#: Makes the module in a process of its own: there no kernel may have been compiled before (`kernels.native.wasm`).
_BUILD = """
import sys
from kernels.native import wasm
wasm.begin()
from kernels.page.c_library import C_LIBRARY
from kernels.page.system import entries_and_sizes
entries, sizes = entries_and_sizes(sys.stdin.read())
sys.stdout.buffer.write(wasm.module(entries, C_LIBRARY, sizes))
"""


def is_system(spec: SweepSpec | None) -> bool:
    """Return whether there is a spec, and it asks for a user's system."""
    return spec is not None and isinstance(spec.model, SystemModel)


def system_cells(model: SystemModel) -> dict[str, Any]:
    """Return what makes the columns of cells of their passes (`sweep.model.system.passes`), which JSON can hold."""
    definition = model.definition
    quantities = model.variables
    names = [name for name in quantities if name not in ("stability", "steps", "unproved")]
    end_time = tables.END_TIME
    return {
        "passes": list(passes.PASSES),
        "states": [each.name for each in definition.states],
        "state_ends": [_named(each.name + tables.AT_END) for each in definition.states],
        "end_time": end_time,
        "end_time_stated": tables.stated(end_time),
        "measures": [
            {
                **_named(each.name),
                "kind": each.kind,
                "expressions": [_plain(node) for node in each.expressions],
            }
            for each in definition.measures
        ],
        "labels": [[_plain(node) for node in each.all_positive] for each in definition.labels],
        "conserved": [_plain(node) for node in definition.conserved],
        "columns": names,
        "coded": [name for name in names if quantities[name].flags is not None],
        **passes.NUMBERS,
    }


def _named(name: str) -> dict[str, str]:
    return {"name": name, "stated": tables.stated(name)}


def _plain(node: Node) -> Any:
    """Return an expression as JSON: a number, a name, or an operation with its parts behind it."""
    if isinstance(node, Constant):
        return node.value
    if isinstance(node, Symbol):
        return node.name
    return [node.name, *map(_plain, node.arguments)]


def kernels_of(spec: SweepSpec | None) -> bytes | None:
    """Return the module that computes the cells of a spec in a page; None for that of the disk, which is there."""
    return system_module(spec.model.integrate) if spec and is_system(spec) else None


@lru_cache(maxsize=8)
def system_module(kernel: Kernel) -> bytes:
    """Return the module of WebAssembly of a system's kernel; it takes some ten seconds, once in a process.

    Parameters
    ----------
    kernel : Kernel
        `SystemModel.integrate`.

    Raises
    ------
    RequestError
        If it cannot be made here.
    """
    notice(f"Compiling {kernel.told} for the page (some ten seconds) ...")
    # Python looks for modules in its folder first: there are the packages, and no files of the user
    packages = Path(__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", _BUILD],
        input=kernel.function.encode(),
        cwd=packages,
        capture_output=True,
        check=False,
    )
    if done.returncode:
        *_, said = ["no reason was given", *done.stderr.decode(errors="replace").strip().splitlines()]
        raise RequestError(
            f"The kernel of {kernel.told} could not be compiled for a page: {said}.",
            hint="Draw an atlas of it with eulerdisk plot instead.",
        )
    return done.stdout
