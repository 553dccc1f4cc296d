"""What a page has to know to call the entry points of its module."""

#: Cells that are treated at a time: all that the page asks for.
_CHUNK = 2**31 - 1


def sizes_of(entries):
    """Return the sizes that a page has to know: a dict that JSON can hold.

    Parameters
    ----------
    entries : mapping of str to kernels.native.entry.Entry

    Returns
    -------
    dict
        ``memory``, the shapes of the arrays that each parallel entry point is called with last; ``chunk``, cells that
        it treats at a time.
    """
    parallel = {name: entry.memory() for name, entry in entries.items() if hasattr(entry, "memory")}
    shapes = {name: [each.shape for each in arrays] for name, arrays in parallel.items()}
    return {"memory": shapes, "chunk": _CHUNK}
