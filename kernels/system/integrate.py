"""The entry point of a system: many cells, each integrated four times until it ends.

It takes `(starts, settings, measures, counts)`:

Parameters
----------
starts : float64[states + parameters, n]
settings : float64[3]
    Duration, longest step (0: none), tolerance: how small the last terms of a series are beside the first.
measures : float64[4 (2 states + 1 + extremes), n], written
    Of each leg, that with the largest tolerance first: the states at its end, its end, the greatest values, the
    greatest magnitudes of the states at the ends of steps. Of one that could not be followed the end is the time until
    which it was, and all others are NaN.
counts : int32[6, n], written
    The endings of the legs; the steps of all together; those of them that were not proved free of an event.

Notes
-----
Never raises. A cell's bits depend on the cell and the settings alone.
"""

import hashlib
import json

from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.system import lanes
from kernels.system.source import functions_of

#: Arguments of `numbers_of` -> what it returned: both entry points of a system share their functions.
_made = {}


def entry_point(program, rates, extremes, events, endings, legs=lanes.LEGS):
    """Return the entry point of a system (`kernels.native.entry.ParallelEntry`), named after its code.

    Parameters
    ----------
    program : tuple
    rates, extremes, events : tuple of int
        See `kernels.system.source.functions_of`.
    endings : tuple of int
        The number of the ending of each of `events`.
    legs : tuple of float
        As `kernels.system.lanes.LEGS`; the benchmark times legs of one tolerance.
    """
    layout, made, numbers, name, copies = numbers_of(program, rates, extremes, events, endings, legs)
    return bind(
        LaneModel(
            name=f"system_{name}", layout=layout, prepared_settings=lanes.prepared_settings,
            read_start=lanes.read_start, fill_idle=lanes.fill_idle, prepare=lanes.prepare,
            needs_integration=lanes.needs_integration, set_off=lanes.set_off, advance=made["advance"], land=lanes.land,
            finish_leg=lanes.finish_leg, go_on=lanes.go_on, flags=numbers,
        ),
        copies,
    )  # fmt: skip


def numbers_of(program, rates, extremes, events, endings, legs):
    """Return what all entry points of a system are made of.

    Returns
    -------
    layout : kernels.system.source.Layout
    made : dict
        The functions that are made of its right-hand side.
    numbers : dict
        What takes the place of names in all others.
    name : str
    copies : dict
        The others, as `kernels.lanes.binding.rebound_for` keeps them: both entry points call the same.
    """
    given = program, rates, extremes, events, endings, legs
    if given not in _made:
        _made[given] = _make_numbers(*given)
    return _made[given]


def _make_numbers(program, rates, extremes, events, endings, legs):
    layout, made, text = functions_of(program, rates, extremes, events)
    numbers = {
        "STATES": len(rates), "EXTREMES": len(extremes), "EVENTS": len(events), "EVENT_ENDINGS": endings or (0,),
        "LEGS": legs,
        **{name: made[name] for name in ("coefficients", "constants", "safe_step")},
        **{name: at for name, at in vars(layout).items() if hasattr(lanes, name)},
    }  # fmt: skip
    name = hashlib.sha256(repr((text, endings, legs)).encode()).hexdigest()[:24]
    return layout, made, numbers, name, {}


def __getattr__(name):
    """Make the entry point whose name is a program in JSON: instructions, rates, extremes, events, their endings."""
    if not name.startswith("["):
        # an AttributeError, as for any module
        return getattr(None, name)
    made = globals()[name] = entry_point(*program_of(name))
    return made


def program_of(name):
    """Return the first five arguments of `entry_point`, of which a name is made."""
    instructions, *numbers = json.loads(name)
    return tuple(map(tuple, instructions)), *map(tuple, numbers)
