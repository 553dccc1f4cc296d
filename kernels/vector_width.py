"""How wide the vectors of compiled loops are: chosen for these kernels alone, and measured where it is in doubt.

For most Intel processors with AVX-512 LLVM prefers vectors of half their width, because the early ones ran slower for a
while after a wide instruction; on later ones loops over lanes lose a third of their speed by it. The preference can be
changed for a single function, with an attribute of LLVM; Numba's settings would change it for whatever a program
compiles. The width changes no bit of a result: lanes never exchange a number.
"""

from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering, NativeParforLowering
from numba.parfors.parfor_lowering import ParforLower

_preferred = 0


def prefer(bits):
    """Let kernels that are compiled from now on prefer vectors of so many bits; 0 leaves the choice to LLVM."""
    global _preferred
    _preferred = bits


def _mark(function):
    if _preferred:
        # llvmlite knows attributes without a value only, and its own `add` refuses others
        set.add(function.attributes, f'"prefer-vector-width"="{_preferred}"')


class _Lower(Lower):
    def setup_function(self, fndesc):
        super().setup_function(fndesc)
        _mark(self.function)


class _ParforLower(ParforLower):
    def setup_function(self, fndesc):
        super().setup_function(fndesc)
        _mark(self.function)


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    _name = "lowering_with_preferred_width"

    @property
    def lowering_class(self):
        return _Lower


@register_pass(mutates_CFG=True, analysis_only=False)
class _ParforLowering(NativeParforLowering):
    _name = "parfor_lowering_with_preferred_width"

    @property
    def lowering_class(self):
        return _ParforLower


class PreferredWidth(Compiler):
    """Numba's own compiler, whose functions prefer vectors of the width that `prefer` was given."""

    def define_pipelines(self):
        """Return Numba's passes; those that write the language of LLVM are replaced."""
        replaced = {NativeLowering: _Lowering, NativeParforLowering: _ParforLowering}
        return [_with(replaced, each) for each in super().define_pipelines()]


def _with(replaced, passes):
    found = PassManager(passes.pipeline_name)
    for each, description in passes.passes:
        found.add_pass(replaced.get(each, each), description)
    found.finalize()
    return found
