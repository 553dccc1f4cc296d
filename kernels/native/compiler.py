"""Numba's compiler with three changes, only for these kernels: full vectors, no machine code of parts, fewer passes.

Vectors
    For most Intel processors with AVX-512, LLVM prefers vectors of half their width, because early ones ran slower
    for a while after a wide instruction. On later ones, loops over lanes lose a third of their speed by this. An
    attribute of each function requests the full width, or EULERDISK_VECTOR_BITS. Numba's settings would change the
    width for all code that a program compiles. The width changes no bit of a result, because lanes never exchange
    numbers.

Parts
    Numba makes machine code of every function, even of those that only other kernels call and that are part of the
    code of their callers too. This would double the time. Here only functions called from Python become machine code.

Fewer passes
    Passes for features that kernels do not use are omitted, and Python's garbage collector is disabled meanwhile:
    each saves a tenth of the time. The operator for given types of numbers is looked up only once, which saves a
    third of the time for a user's system.
"""

import gc
from contextlib import contextmanager

from numba import njit, types
from numba.core import ir
from numba.core.cgutils import alloca_once
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

from kernels.native.machine_code import MachineCode, vector_bits

_RESULTS = {"int64", "float64"}

#: Numba's passes for closures, for array expressions, and for library functions that ask to be inlined.
_NEEDLESS = {"InlineClosureLikes", "NopythonRewrites", "InlineOverloads"}

#: Operator and types of numbers -> Numba's result for them, which it would look up again each time.
_operators = {}


class _Lower(Lower):
    def setup_function(self, fndesc):
        super().setup_function(fndesc)
        # llvmlite only knows attributes without a value, and its own `add` rejects others
        set.add(self.function.attributes, f'"prefer-vector-width"="{vector_bits()}"')

    def alloca_lltype(self, name, lltype, datamodel=None):
        # without Numba's debug information for each variable
        return alloca_once(self.builder, lltype, name=name, zfill=False)

    def lower_binop(self, resty, expr, op):
        signature, operands = self.fndesc.calltypes[expr], (expr.lhs, expr.rhs)
        is_static = not (expr.static_lhs is ir.UNDEFINED and expr.static_rhs is ir.UNDEFINED)
        if is_static or not all(isinstance(each, types.Number) for each in signature.args):
            return super().lower_binop(resty, expr, op)
        function = self.context.typing_context.resolve_value_type(op)
        if (op, signature.args) not in _operators:
            found = function.get_call_type(self.context.typing_context, signature.args, {})
            _operators[op, signature.args] = found
        values = [
            self.context.cast(self.builder, self.loadvar(each.name), self.typeof(each.name), to)
            for each, to in zip(operands, signature.args, strict=True)
        ]
        implementation = self.context.get_function(function, _operators[op, signature.args])
        result = implementation(self.builder, values)
        return self.context.cast(self.builder, result, signature.return_type, resty)


class _PartLibrary(JITCodeLibrary):
    """The code of a function that is linked into its callers, as LLVM IR."""

    def _optimize_final_module(self):
        # Numba's first passes, which inline small functions. All others can wait for the whole, because they would be
        # repeated for every caller.
        passes, builder = self._codegen._module_pass_manager(
            loop_vectorize=False, slp_vectorize=False, opt=0, cost="cheap"
        )
        passes.run(self._final_module, builder)

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def object_code(self):
        """Optimise all linked code together; return the LLVM module and its object file."""
        self._ensure_finalized()
        passes, builder = self._codegen._module_pass_manager()
        passes.run(self._final_module, builder)
        return self._final_module, self._codegen._tm.emit_object(self._final_module)


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    _name = "lowering_of_kernels"

    @property
    def lowering_class(self):
        return _Lower

    def run_pass(self, state):
        if not state.flags.no_cpython_wrapper:
            return super().run_pass(state)
        state.library = _PartLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        # Numba identifies a function by the object that Python would call; this one is never called
        stand_in = [].append
        state.targetctx.insert_user_function(stand_in, state.cr.fndesc, [state.library])
        state.cr = state.cr._replace(cfunc=stand_in)
        return True


class KernelCompiler(Compiler):
    """Numba's compiler without needless passes, and with a different last pass, which writes LLVM IR."""

    def define_pipelines(self):
        """Return Numba's passes for the compiled function."""
        pipelines = super().define_pipelines()
        for each in pipelines:
            each.passes = [
                (_Lowering if one is NativeLowering else one, description)
                for one, description in each.passes
                if one.__name__ not in _NEEDLESS
            ]
            # finalize again, with the changed passes
            each._finalized = False
            each.finalize()
        return pipelines


def compiled_function(function, options):
    """Return Numba's function, to be compiled for the types of its arguments."""
    return njit(pipeline_class=KernelCompiler, **options)(function)


@contextmanager
def without_collecting():
    """Disable the garbage collector: a compilation makes many objects, but little garbage."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def machine_code(dispatcher, argument_types):
    """Compile a function returned by `compiled_function`, for arguments with these Numba types.

    Returns
    -------
    MachineCode

    Raises
    ------
    TypeError
        If the function returns anything except numbers of 64 bits.
    """
    with global_compiler_lock, without_collecting():
        dispatcher.compile(argument_types)
        made = dispatcher.overloads[argument_types]
        module, code = made.library.object_code()
    results = results_of(made.signature)
    if not _RESULTS.issuperset(results):
        raise TypeError(
            f"{dispatcher.py_func.__qualname__} must return nothing or numbers, each float64 or int64; got "
            f"{', '.join(results)}."
        )
    outside = (each.name for each in module.functions if each.is_declaration)
    needed = tuple(each for each in outside if not each.startswith("llvm."))
    return MachineCode(made.fndesc.llvm_func_name, results, needed, code, made.library.has_dynamic_globals)


def results_of(signature):
    """Return the types of the numbers that a function returns, as a tuple of str."""
    returned = signature.return_type
    return () if returned == types.none else tuple(map(str, getattr(returned, "types", (returned,))))
