"""The entry points of the module of a page that computes a user's system: many cells, and the samples of one."""

from kernels.page.sizes import sizes_of
from kernels.system import integrate, path
from kernels.system.integrate import program_of


def entries_and_sizes(name):
    """Return what `kernels.native.wasm.module` makes a module of: entry points, and the sizes that a page has to know.

    Parameters
    ----------
    name : str
        The program, as `kernels.system.integrate` names it.
    """
    program = program_of(name)
    entries = {"integrate": integrate.entry_point(*program), "follow": path.entry_point(*program)}
    return entries, sizes_of(entries)
