"""The entry point of the module of a page that computes a user's system."""

from kernels.system.integrate import entry_point, program_of

#: Cells that are treated at a time: all that the page asks for.
_CHUNK = 2**31 - 1


def entries_and_sizes(name):
    """Return what `kernels.native.wasm.module` makes a module of: entry points, and the sizes that a page has to know.

    Parameters
    ----------
    name : str
        The program, as `kernels.system.integrate` names it.
    """
    integrate = entry_point(*program_of(name))
    shapes = [each.shape for each in integrate.memory()]
    return {"integrate": integrate}, {"memory": {"integrate": shapes}, "chunk": _CHUNK}
