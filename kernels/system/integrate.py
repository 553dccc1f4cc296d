"""The entry point of a system: many cells, each integrated four times until it ends.

It takes `(starts, settings, measures, counts)`:

Parameters
----------
starts : float64[states + parameters, n]
settings : float64[3]
    Duration, longest step (0: no limit), tolerance: size of the last terms of a series relative to the first terms.
measures : float64[4 rows, n], written
    For each leg, the largest tolerance first: final states, final time, greatest values, greatest magnitudes of the
    states at the ends of steps, and the numbers of each moment (`kernels.system.moments`). The integrals follow the
    states; `starts` has no rows for them, because they begin at 0. For a failed leg, the final time is the time until
    which it was followed, and all other values are NaN.
counts : int32[6, n], written
    The endings of the legs; the total number of steps; the number of steps not proved to be free of events.

Notes
-----
Never raises. The bits of a cell depend only on the cell and the settings.
"""

import hashlib
import json

from kernels.lanes.binding import bind
from kernels.lanes.interface import LaneModel
from kernels.system import lanes, moments
from kernels.system.source import functions_of

#: Arguments of `numbers_of` -> its result, because both entry points of a system share their functions.
_made = {}


def entry_point(program, rates, extremes, events, endings, integrals, watched, legs=lanes.LEGS):
    """Return the entry point of a system (`kernels.native.entry.ParallelEntry`), named after its code.

    Parameters
    ----------
    program : tuple
    rates, extremes, events : tuple of int
        See `kernels.system.source.functions_of`.
    endings : tuple of int
        The number of the ending of each of `events`.
    integrals : tuple of int
        The instructions of expressions that are integrated over time.
    watched : tuple of tuple of int
        The moments: the kind, whether every comparison has to be true, the instruction of the value, and those of the
        expressions.
    legs : tuple of float
        As `kernels.system.lanes.LEGS`; the benchmark uses legs with a single tolerance.
    """
    layout, made, numbers, name, copies = numbers_of(
        program, rates, extremes, events, endings, integrals, watched, legs
    )
    return bind(
        LaneModel(
            name=f"system_{name}", layout=layout, prepared_settings=lanes.prepared_settings,
            read_start=lanes.read_start, fill_idle=lanes.fill_idle, prepare=lanes.prepare,
            needs_integration=lanes.needs_integration, set_off=lanes.set_off, advance=made["advance"], land=lanes.land,
            finish_leg=lanes.finish_leg, go_on=lanes.go_on, flags=numbers,
        ),
        copies,
    )  # fmt: skip


def numbers_of(*given):
    """Return the parts of all entry points of a system; the arguments are those of `entry_point`.

    Returns
    -------
    layout : kernels.system.source.Layout
    made : dict
        The functions generated from its right-hand side.
    numbers : dict
        Values that replace names in all other functions.
    name : str
    copies : dict
        The other functions, as `kernels.lanes.binding.rebound_for` keeps them, shared by both entry points.
    """
    if given not in _made:
        _made[given] = _make_numbers(*given)
    return _made[given]


def _make_numbers(program, rates, extremes, events, endings, integrals, watched, legs):
    rates = (*rates, *integrals)
    layout, made, text = functions_of(program, rates, extremes, events, len(integrals), watched)
    before = len(rates) + len(extremes) + len(events)
    # the series of the value of each moment, and behind the last one
    series = [before + sum(len(each) - 2 for each in watched[:m]) for m in range(len(watched) + 1)]
    numbers = {
        "STATES": len(rates), "INTEGRALS": len(integrals), "EXTREMES": len(extremes), "EVENTS": len(events),
        "EVENT_ENDINGS": endings or (0,), "SERIES": series[-1],
        "ROWS": 2 * len(rates) + 1 + len(extremes) + len(watched) * moments.NUMBERS,
        "MOMENTS": len(watched), "MOMENT_KINDS": tuple(each[0] for each in watched) or (0,),
        "MOMENT_EVERY": tuple(each[1] for each in watched) or (0,), "MOMENT_SERIES": tuple(series),
        "MOMENT_SIZES": tuple(len(each) - 3 for each in watched) or (0,),
        "LEGS": legs,
        **{name: made[name] for name in ("coefficients", "constants", "safe_step")},
        **{name: at for name, at in vars(layout).items() if hasattr(lanes, name)},
    }  # fmt: skip
    name = hashlib.sha256(repr((text, endings, watched, legs)).encode()).hexdigest()[:24]
    return layout, made, numbers, name, {}


def __getattr__(name):
    """Make the entry point whose name is a program in JSON: the arguments of `entry_point` except `legs`."""
    if not name.startswith("["):
        # raises AttributeError, as in any module
        return getattr(None, name)
    made = globals()[name] = entry_point(*program_of(name))
    return made


def program_of(name):
    """Return the arguments of `entry_point` except `legs`, decoded from its name."""
    return tuple(map(_as_tuple, json.loads(name)))


def _as_tuple(value):
    return tuple(map(_as_tuple, value)) if isinstance(value, list) else value
