"""One compiled entry point for each model, from the shared schedule and the functions of the model.

The schedule calls the functions of a model as globals. For each model it is copied, together with all of its
functions that use such a global, and the globals of the copies are the functions of the model. The name of a copy
contains the name of its model, because Numba names machine code after the function and a counter that differs between
processes.

A variant of a model has `flags`, which replace globals of the model's functions: the compiler removes code that
``if FLAG:`` excludes. So each variant is its own entry point, without unnecessary computations.
"""

from kernels.lanes import interface, schedule

_LAYOUT = ("STEPPING", "RETURNED", "STEPS", "SIZE")
_FUNCTIONS = tuple(
    name for name in interface.LaneModel._fields if name not in ("name", "layout", "further_steps", "flags")
)


def bind(model, made=None):
    """Return the compiled entry point of a model.

    Parameters
    ----------
    model : kernels.lanes.interface.LaneModel
    made : dict, optional, written
        As for `rebound_for`.

    Returns
    -------
    kernels.native.entry.ParallelEntry
        `kernels.lanes.schedule.integrate`, which calls the functions of the model; its attribute `lane_model` is the
        model, for a device.

    Raises
    ------
    ValueError
        If a name among the flags is not used by any function.
    """
    replaced = replacements(model)
    entry = rebound_for(model.name, schedule.integrate, replaced, model.flags or {}, _recompiled, made)
    bound = entry.copied(entry.py_func, copied(model.name, schedule.memory_of_thread, replaced))
    bound.lane_model = model
    return bound


def variant(entry, name, flags, made=None):
    """Return a copy of an entry point with replaced globals; it does not use the schedule.

    Parameters
    ----------
    entry : kernels.native.entry.ParallelEntry
    name : str
        Different for each variant of the entry point.
    flags : dict of str to anything
        As in `kernels.lanes.interface.LaneModel`.
    made : dict, optional, written
        As for `rebound_for`.

    Returns
    -------
    kernels.native.entry.ParallelEntry

    Raises
    ------
    ValueError
        If a name among the flags is not used by any function.
    """
    return rebound_for(name, entry, {}, flags, _recompiled, made)


def replacements(model):
    """Return the values that replace the names of `kernels.lanes.interface` for a model, as a dict."""
    numbers = {name: getattr(model.layout, name) for name in _LAYOUT} | {"FURTHER_STEPS": model.further_steps}
    numbers["TOTAL"] = numbers["STEPPING"] + numbers["SIZE"]
    return numbers | {name: getattr(model, name) for name in _FUNCTIONS}


def rebound_for(name, kernel, replaced, flags, recompiled, made=None):
    """Return a copy of a kernel as by `rebound`, for a model or variant with this name.

    Parameters
    ----------
    name : str
    kernel, replaced, flags
        As for `rebound`.
    recompiled : callable
        Called with the name, a kernel and the replaced globals of its copy; returns the copy.
    made : dict, optional, written
        As for `rebound`. Entry points bound with the same dict share the functions that both call, which are compiled
        only once. Flags of the same name must have the same value in all of them.

    Returns
    -------
    compiled function

    Raises
    ------
    ValueError
        If a name among the flags is not used by any function: it was misspelt, or its global no longer exists.
    """
    made = {} if made is None else made
    copy, used = rebound(kernel, replaced, flags, lambda *given: recompiled(name, *given), made)
    unused = sorted(set(flags) - used)
    if unused:
        raise ValueError(
            f"{name!r} replaces names that none of its functions uses: {', '.join(unused)}. Correct or remove them."
        )
    return copy


def rebound(kernel, replaced, flags, recompiled, made):
    """Return a copy of a kernel, and of the kernels that it calls, with replaced globals.

    Parameters
    ----------
    kernel : compiled function
    replaced : dict
        Name -> its replacement, in functions of `kernels.lanes`.
    flags : mapping
        Name -> its replacement, in all functions.
    recompiled : callable
        Called with a kernel and the replaced globals of its copy; returns the copy.
    made : dict, written
        Plain function -> its copy, and the names among the flags that it and its callees use.

    Returns
    -------
    copy : compiled function
    used : set of str
        The names among the flags that it and its callees use.
    """
    source = plain(kernel)
    if source not in made:
        names = {**flags, **(replaced if source.__module__.startswith("kernels.lanes.") else {})}
        different, used = {}, set()
        for name in source.__code__.co_names:
            given = source.__globals__.get(name)
            found = names.get(name, given)
            if name in flags and name in source.__globals__:
                used.add(name)
            if _is_kernel(found):
                found, more = rebound(found, replaced, flags, recompiled, made)
                used |= more
            if found is not given:
                different[name] = found
        made[source] = recompiled(kernel, different), used
    return made[source]


def plain(kernel):
    """Return the Python function that a kernel was compiled from."""
    return getattr(kernel, "py_func", kernel)


def copied(name, kernel, different):
    """Return a copy of the Python function of a kernel with replaced globals, named after a model too."""
    source = plain(kernel)
    copy = type(source)(source.__code__, source.__globals__ | different, source.__name__, source.__defaults__)
    copy.__doc__ = source.__doc__
    copy.__qualname__ = f"{source.__qualname__}_of_{name}"
    return copy


def _is_kernel(value):
    # the kernels of `kernels.lanes.cuda` are plain functions
    return hasattr(value, "py_func") or (
        isinstance(value, type(plain)) and value.__module__.startswith("kernels.")
    )


def _recompiled(name, kernel, different):
    return kernel.copied(copied(name, kernel, different)) if different else kernel
