"""Numba's compiler with three changes, for these kernels alone: vectors, no machine code for parts, and its own time.

Width
    For most Intel processors with AVX-512 LLVM prefers vectors of half their width, because the early ones ran slower
    for a while after a wide instruction; on later ones loops over lanes lose a third of their speed by it. The
    preference can be changed for a single function, with an attribute of LLVM; Numba's settings would change it for
    whatever a program compiles. The width changes no bit of a result: lanes never exchange a number.

Parts
    Numba makes machine code of every function, also of those that only other kernels call and that are part of these
    kernels' code too. Here only what Python calls becomes machine code.

Time
    Two thirds of the time goes to Numba's own Python code. What it would find out again and again (the type of the sum
    of an integer and an integer), or for no use (the size of a variable, for a debugger; the time of every call of
    LLVM), is left out: a fifth to a third of the time. The machine code is the same, byte by byte.
"""

from contextlib import contextmanager
from inspect import signature
from types import CodeType

from numba.core import types
from numba.core.cgutils import alloca_once
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.ir import UNDEFINED
from numba.core.lowering import Lower
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature
from numba.core.typed_passes import NativeLowering, NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes

_preferred = 0


@contextmanager
def preferring(bits):
    """Let kernels that are compiled in this context prefer vectors of so many bits; 0 leaves the choice to LLVM.

    Other Python threads compile nothing meanwhile: it would get this width too.
    """
    global _preferred
    with global_compiler_lock:
        before, _preferred = _preferred, bits
        try:
            yield
        finally:
            _preferred = before


@contextmanager
def remembering_types(typing_context):
    """Let a typing context of Numba find out once what operators and functions of Numba return for given types."""
    resolve, found = typing_context.resolve_function_type, {}

    def remembered(function, arguments, keywords):
        # kernels are types too, and may be half compiled; what is called by a name has arguments that are no types
        known = isinstance(function, types.BaseFunction) or not isinstance(function, types.Type | str)
        if keywords or not known:
            return resolve(function, arguments, keywords)
        question = function, tuple(arguments)
        answer = found.get(question)
        if answer is None:
            answer = found[question] = resolve(function, arguments, keywords)
        return answer

    typing_context.resolve_function_type = remembered
    try:
        yield
    finally:
        del typing_context.resolve_function_type


class _Lower(Lower):
    def setup_function(self, fndesc):
        super().setup_function(fndesc)
        if _preferred:
            # llvmlite knows attributes without a value only, and its own `add` refuses others
            set.add(self.function.attributes, f'"prefer-vector-width"="{_preferred}"')

    def alloca_lltype(self, name, lltype, datamodel=None):
        # without what Numba tells a debugger of each variable
        return alloca_once(self.builder, lltype, name=name, zfill=False)

    def lower_binop(self, resty, expr, op):
        if not (expr.static_lhs is expr.static_rhs is UNDEFINED):
            return super().lower_binop(resty, expr, op)
        typed, values = self.fndesc.calltypes[expr], []
        for operand, expected in zip((expr.lhs, expr.rhs), typed.args, strict=True):
            value = self.loadvar(operand.name)
            values.append(self.context.cast(self.builder, value, self.typeof(operand.name), expected))
        typing_context = self.context.typing_context
        operator = typing_context.resolve_value_type(op)
        # Numba's own asks the operator itself: what `remembering_types` knows is found out anew, a tenth of the time
        found = typing_context.resolve_function_type(operator, typed.args, {})
        result = self.context.get_function(operator, found)(self.builder, values)
        return self.context.cast(self.builder, result, typed.return_type, resty)


class _PartLibrary(JITCodeLibrary):
    """The code of a function that is linked into its callers, in the language of LLVM."""

    def _optimize_functions(self, ll_module):
        make = self._codegen._function_pass_manager
        if "llvm_module" in signature(make).parameters:
            # older versions of Numba make the passes once for a module themselves
            super()._optimize_functions(ll_module)
            return
        ll_module.data_layout = self._codegen._data_layout
        passes, *builder = _passes(make())
        for function in ll_module.functions:
            # six of seven are declarations, and Numba makes new passes for each
            if not function.is_declaration:
                passes.run(function, *builder)

    def _optimize_final_module(self):
        # What Numba does first, to have small functions inlined. All the rest can wait for the whole: it would be done
        # again for every caller.
        self._run_passes(loop_vectorize=False, slp_vectorize=False, opt=0, cost="cheap")

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def _run_passes(self, **options):
        passes, *builder = _passes(self._codegen._module_pass_manager(**options))
        passes.run(self._final_module, *builder)

    def object_code(self):
        """Optimise all that is linked together; returns the module of LLVM and the object file made of it."""
        self._ensure_finalized()
        self._run_passes()
        return self._final_module, self._codegen._tm.emit_object(self._final_module)


def _passes(made):
    # older versions of Numba return the passes alone
    return made if isinstance(made, tuple) else (made,)


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
        # Numba knows a function by the object that Python would call; nobody calls this one
        stand_in = [].append
        state.targetctx.insert_user_function(stand_in, state.cr.fndesc, [state.library])
        state.cr = state.cr._replace(cfunc=stand_in)
        return True


class KernelCompiler(Compiler):
    """Numba's own compiler, but for the last pass, which writes the language of LLVM, and for passes without work."""

    def define_pipelines(self):
        """Return Numba's passes for the function that is compiled."""
        return [self._changed(each) for each in super().define_pipelines()]

    def _changed(self, passes):
        # array expressions would be rewritten as loops into new memory, which no kernel may have
        idle = [NopythonRewrites]
        if not any(isinstance(each, CodeType) for each in self.state.func_id.code.co_consts):
            idle.append(InlineClosureLikes)
        found = PassManager(passes.pipeline_name)
        for each, description in passes.passes:
            if each not in idle:
                found.add_pass(_Lowering if each is NativeLowering else each, description)
        found.finalize()
        return found


class KernelDispatcher(CPUDispatcher):
    """Numba's function, but that nothing measures how long it takes to compile.

    While Numba's own is compiled, it hears of every call of LLVM and keeps it; of those in a function that it calls,
    too, and half a dozen of them are half compiled at a time. Without that, and with the passes of LLVM made once for a
    module, a compilation of 3.8 s took 3.4 s.

    Parameters
    ----------
    py_func : function
    options : dict
        Of Numba.
    """

    def __init__(self, py_func, options):
        super().__init__(py_func, targetoptions={"nopython": True, **options}, pipeline_class=KernelCompiler)

    def compile(self, sig):
        """Compile for a signature, or the types of the arguments, unless that is done; returns the entry point."""
        with global_compiler_lock, self._compiling_counter:
            argument_types, return_type = normalize_signature(sig)
            found = self.overloads.get(tuple(argument_types))
            if found is None:
                found = self._compiler.compile(argument_types, return_type)
                self.add_overload(found)
            return found.entry_point
