"""Sizes that a page needs to call the entry points of its module."""

#: Number of cells that are processed at a time: all cells of a call.
_CHUNK = 2**31 - 1


def sizes_of(entries):
    """Return the sizes that a page needs, as a dict that can be written as JSON.

    Parameters
    ----------
    entries : mapping of str to kernels.native.entry.Entry

    Returns
    -------
    dict
        ``memory``, the shapes of the last arrays in the call of each parallel entry point; ``chunk``, the number of
        cells that it processes at a time.
    """
    parallel = {name: entry.memory() for name, entry in entries.items() if hasattr(entry, "memory")}
    shapes = {name: [each.shape for each in arrays] for name, arrays in parallel.items()}
    return {"memory": shapes, "chunk": _CHUNK}
