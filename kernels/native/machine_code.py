"""Machine code of entry points, made with Numba (`kernels.native.compiler`) and loaded without it.

Loading takes 30 ms, mostly to import llvmlite; linking a kernel of 60 kB takes 3 ms.
"""

import ctypes
import os
from typing import NamedTuple

#: Keeps loaded code in memory.
_engines = []


class MachineCode(NamedTuple):
    """A compiled entry point.

    Attributes
    ----------
    name : str
        Name of its function.
    results : tuple of str
        Types of the numbers that it returns: ``int64`` or ``float64``.
    needed : tuple of str
        External functions that it calls by name, except those that LLVM inserts.
    code : bytes
        An object file.
    has_addresses : bool
        Whether it contains addresses in the memory of this process: of an array that is global in its module, and
        large (over 1 MB) or not contiguous.
    """

    name: str
    results: tuple
    needed: tuple
    code: bytes
    has_addresses: bool = False

    def is_lasting(self):
        """Return whether other processes can load it: it calls only the C library and contains no address."""
        library = ctypes.CDLL(None)
        return not self.has_addresses and all(hasattr(library, name) for name in self.needed)


def vector_bits():
    """Return the preferred width of vectors in compiled code [bits]: EULERDISK_VECTOR_BITS, by default 512 (AVX-512).

    A processor with narrower vectors uses those.
    """
    return int(os.environ.get("EULERDISK_VECTOR_BITS") or 512)


def load(machine_code):
    """Return the address of the function of machine code.

    Raises
    ------
    RuntimeError
        If a function that it needs is missing: see `MachineCode.is_lasting`.
    """
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    target = binding.Target.from_default_triple().create_target_machine(jit=True)
    # a separate engine for each, so that functions of the same name do not collide
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), target)
    missing = [name for name in machine_code.needed if not binding.address_of_symbol(name)]
    if missing:
        # linking it would end the process
        raise RuntimeError(
            f"{machine_code.name} needs {', '.join(missing)}, which this process does not have."
        )
    engine.add_object_file(binding.ObjectFileRef.from_data(machine_code.code))
    engine.finalize_object()
    _engines.append(engine)
    return engine.get_function_address(machine_code.name)
