"""The entry points of the page module for a user's system: many cells, and the samples of one cell."""

from kernels.page.sizes import sizes_of
from kernels.system import integrate, path
from kernels.system.integrate import program_of


def entries_and_sizes(name):
    """Return the entry points for `kernels.native.wasm.module`, and the sizes that a page needs.

    Parameters
    ----------
    name : str
        The program, in the form used by `kernels.system.integrate` as a name.
    """
    program = program_of(name)
    entries = {"integrate": integrate.entry_point(*program), "follow": path.entry_point(*program)}
    return entries, sizes_of(entries)
