"""Machine code of entry points: made by Numba, loaded without it.

Loading takes 30 ms: most of it is the import of llvmlite, and 3 ms the linking of a kernel of 60 kB.
"""

import ctypes
import gc
from contextlib import contextmanager
from typing import NamedTuple

from kernels.native.function import lazy

_RESULTS = {"int64", "float64"}

_LLVM_NAMES = {
    ctypes.c_double: "double",
    ctypes.c_int64: "i64",
    ctypes.c_int32: "i32",
    ctypes.c_bool: "i8",
    ctypes.c_void_p: "ptr",
}

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


def compiled(function, types, c_types, options):
    """Compile a function.

    Parameters
    ----------
    function : function
    types : tuple
        The types of Numba that it is compiled for.
    c_types : list
        The C types that it is called with, after the addresses of its result and of a failure.
    options : dict
        Of Numba.

    Returns
    -------
    MachineCode

    Raises
    ------
    RuntimeError
        If this version of Numba passes arguments in another way: the first call would end the process.
    TypeError
        If the function returns anything but numbers of 64 bits.
    """
    from numba.core.compiler_lock import global_compiler_lock

    from kernels.native.pipeline import remembering_types

    dispatcher = lazy(**options)(function).compiled
    with global_compiler_lock, remembering_types(dispatcher.typingctx), without_garbage_collection():
        dispatcher.compile(types)
        made = dispatcher.overloads[types]
        module, code = made.library.object_code()
    name = made.fndesc.llvm_func_name
    expected = [_LLVM_NAMES[each] for each in (ctypes.c_void_p, ctypes.c_void_p, *c_types)]
    passed = [str(each.type) for each in module.get_function(name).arguments]
    if ["ptr" if each.endswith("*") else each for each in passed] != expected:
        raise RuntimeError(
            f"This version of Numba passes arguments as {passed}; expected {expected}. Install the version that "
            "eulerdisk was tested with."
        )
    outside = (each.name for each in module.functions if each.is_declaration)
    needed = tuple(each for each in outside if not each.startswith("llvm."))
    results = _numbers(made.signature.return_type)
    if not _RESULTS.issuperset(results):
        raise TypeError(
            f"{function.__qualname__} must return nothing or numbers, each float64 or int64; got {', '.join(results)}."
        )
    return MachineCode(name, results, needed, code, made.library.has_dynamic_globals)


@contextmanager
def without_garbage_collection():
    """Import Numba or compile in this context: a tenth faster, as millions of objects make next to no cycles."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _numbers(returned):
    """Return the names of the numbers that make up a type of Numba: none, a number or a tuple of numbers."""
    from numba import types

    if returned == types.none:
        return ()
    return tuple(map(str, getattr(returned, "types", (returned,))))


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
