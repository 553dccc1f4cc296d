"""Machine code of entry points: made by Numba (`kernels.native.compiler`), loaded without it.

Loading takes 30 ms: most of it is the import of llvmlite, and 3 ms the linking of a kernel of 60 kB.
"""

import ctypes
import os
from typing import NamedTuple

#: What keeps loaded code in memory.
_engines = []


class MachineCode(NamedTuple):
    """A compiled entry point.

    Attributes
    ----------
    name : str
        Of its function.
    results : tuple of str
        The types of the numbers that it returns: ``int64`` or ``float64``.
    needed : tuple of str
        The functions outside of it that it calls by name, beside those that LLVM puts in.
    code : bytes
        An object file.
    has_addresses : bool
        Whether addresses in the memory of this process are part of it: of an array that is global in its module, and
        large (over 1 MB) or not contiguous.
    """

    name: str
    results: tuple
    needed: tuple
    code: bytes
    has_addresses: bool = False

    def is_lasting(self):
        """Whether another process can load it: it calls the C library and nothing of Numba's, and has no address."""
        library = ctypes.CDLL(None)
        return not self.has_addresses and all(hasattr(library, name) for name in self.needed)


def vector_bits():
    """Width of the vectors that compiled code prefers [bits]: EULERDISK_VECTOR_BITS, by default that of AVX-512.

    A processor whose vectors are narrower has those.
    """
    return int(os.environ.get("EULERDISK_VECTOR_BITS") or 512)


def load(machine_code):
    """Return the address of the function of machine code.

    Raises
    ------
    RuntimeError
        If a function that it needs is not there: see `MachineCode.is_lasting`.
    """
    from llvmlite import binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    target = binding.Target.from_default_triple().create_target_machine(jit=True)
    # an engine for each, so that functions of the same name in two of them do not meet
    engine = binding.create_mcjit_compiler(binding.parse_assembly(""), target)
    missing = [name for name in machine_code.needed if not binding.address_of_symbol(name)]
    if missing:
        # to link it would end the process
        raise RuntimeError(
            f"{machine_code.name} needs {', '.join(missing)}, which this process does not have."
        )
    engine.add_object_file(binding.ObjectFileRef.from_data(machine_code.code))
    engine.finalize_object()
    _engines.append(engine)
    return engine.get_function_address(machine_code.name)
