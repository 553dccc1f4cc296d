"""Commands, Python code and files for users: to recompute a window or a motion, and the cells of a window."""

import contextlib
import shlex
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from sweep.atomic import scratch_folder
from sweep.engine.compute import compute
from sweep.engine.grid import blocks, starts_of
from sweep.errors import RequestError
from sweep.explorer.fields import read_choice, read_count, read_number, read_object
from sweep.explorer.point import place
from sweep.explorer.system import is_system
from sweep.explorer.view import Side, View
from sweep.explorer.waiting import KERNELS
from sweep.explorer.window import MOST_PIXELS
from sweep.model.bodies.model import BODIES
from sweep.request.sources import Range, Values
from sweep.request.spec import SweepSpec
from sweep.request.spec_file import presets

#: Largest number of cells in a file: as a table, they take 200 MB.
MOST_CELLS = 1_000_000

#: Format -> file name.
FORMATS = {"csv": "window.csv", "netcdf": "window.nc"}

#: Number of cells that are computed before checking whether the client still waits.
_PIECE = 16384


def window_commands(view: View, fields: Mapping[str, Any]) -> dict[str, str]:
    """Return a command and Python code that compute the cells of a window.

    Parameters
    ----------
    view : View
    fields : mapping
        ``width`` and ``height`` in pixels.

    Returns
    -------
    dict
        ``command`` and ``python``.

    Raises
    ------
    RequestError
    """
    base, held = _base_of(view)
    words = _changes(held, window_spec(view, fields))
    return {
        "command": shlex.join(["eulerdisk", "run", base, *_pairs(words), "-o", "window.nc"]),
        "python": f"import sweep\n\natlas = sweep.run({base!r}, {_arguments(words)})\natlas.eulerdisk.plot()\n",
    }


def motion_commands(view: View, fields: Mapping[str, Any]) -> dict[str, str]:
    """Return a command and Python code that follow the motion of a point.

    Parameters
    ----------
    view : View
    fields : mapping
        ``x`` and ``y``, the values of the two parameters in SI, and optionally ``duration`` and ``losses``.

    Returns
    -------
    dict
        ``command`` and ``python``.

    Raises
    ------
    RequestError
    """
    base, words = (_motion_of_system if is_system(view.spec) else _rolling_motion)(view, fields)
    named = [base] if base else []
    arguments = ", ".join([*map(repr, named), *filter(None, [_arguments(words)])])
    return {
        "command": shlex.join(["eulerdisk", "simulate", *named, *_pairs(words), "-o", "motion.nc"]),
        "python": f"import sweep\n\nmotion = sweep.simulate({arguments})\nmotion.eulerdisk.plot()\n",
    }


def window_spec(view: View, fields: Mapping[str, Any], most: int = MOST_PIXELS) -> SweepSpec:
    """Return the spec whose cells are the pixels of a window: exact cells, or integrated ones without a reduction.

    Raises
    ------
    RequestError
        If there are more than `most` pixels.
    """
    width, height = (read_count(fields, name, most) for name in ("width", "height"))
    if width * height > most:
        raise RequestError(
            f"These are too many cells: width * height can be at most {most} here; got {width} x {height}.",
            hint="Ask for fewer cells, or copy the window as a command.",
            where="width",
        )
    spec = view.live if view.is_live else view.spec
    axes = {side.name: _axis(side, count) for side, count in ((view.x, width), (view.y, height))}
    return spec.replace(**axes, axes=[name for name in spec.axes if name in axes])


def _axis(side: Side, count: int) -> Range | Values:
    """Return the values at the pixels of a side, as single values where a range cannot represent so fine a window."""
    values = side.values(count)
    try:
        return Range(float(values[0]), float(values[-1]), count, side.scale)
    except RequestError:
        return Values(tuple(np.unique(values).tolist()))


def _changes(base: SweepSpec, spec: SweepSpec) -> dict[str, Any]:
    """Return the words that change one spec into another."""
    held = base.words()
    return {name: _plain(value) for name, value in spec.words().items() if held.get(name) != value}


def _base_of(view: View) -> tuple[str, SweepSpec]:
    """Return the first word of a command, and the spec that it names: a preset, or a system's file."""
    model = view.spec.model
    if not model.text:
        base = view.base or _preset_of(view.spec)
        return base, SweepSpec.preset(base)
    with contextlib.suppress(RequestError):
        if (preset := SweepSpec.preset(model.name)).model == model:
            return model.name, preset
    return f"{model.name}.py", SweepSpec(model=model)


def _preset_of(spec: SweepSpec) -> str:
    """Return the model's preset that needs the fewest changes; for the disk, the best-known preset."""
    # lossy bodies have no presets; use those of bodies, because the words of the losses select the model
    known = presets(spec.model) or presets(BODIES)
    return (
        "rolling"
        if "rolling" in known
        else min(known, key=lambda name: len(_changes(SweepSpec.preset(name), spec)))
    )


def _motion_of_system(view: View, fields: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    base, held = _base_of(view)
    start = {
        side.name: float(values[0]) for side, values in zip((view.x, view.y), place(fields), strict=True)
    }
    words = _changes(held, view.spec.replace(**start))
    # a motion has no verdict
    words.pop("criterion", None)
    return base, words


def _rolling_motion(view: View, fields: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    from sweep.explorer.motion import check_start, words_of

    start = {name: float(values[0]) for name, values in view.starts(*place(fields)).items()}
    check_start(view.spec, start)
    words = words_of(view.spec, start, read_object(fields.get("losses") or {}, "losses"))
    if fields.get("duration") is not None:
        words["duration"] = read_number(fields, "duration")
    return "", {name: _plain(value) for name, value in words.items()}


def _plain(value: Any) -> float | str:
    return value if isinstance(value, float) else str(value)


def _pairs(words: Mapping[str, float | str]) -> list[str]:
    return [f"{name}={value}" for name, value in words.items()]


def _arguments(words: Mapping[str, float | str]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in words.items())


def window_file(view: View, fields: Mapping[str, Any], check: Callable[[], None]) -> tuple[str, BinaryIO]:
    """Compute the cells of a window, and return a file name and an open, already deleted file that contains them.

    Parameters
    ----------
    view : View
    fields : mapping
        ``width`` and ``height`` in pixels, and the ``format``, ``csv`` or ``netcdf``.
    check : callable
        Called between pieces of work; raises an error if the file is no longer wanted.

    Raises
    ------
    RequestError
        If there are too many pixels, or the cells of the view cannot be computed.
    """
    kind = read_choice(fields, "format", tuple(FORMATS))
    view.live  # noqa: B018 - without an exact reduction, cells would be integrated in time
    spec = window_spec(view, fields, MOST_CELLS)
    command = window_commands(view, fields)["command"]
    return FORMATS[kind], _file(spec, kind, command, check)


def _file(spec: SweepSpec, kind: str, command: str, check: Callable[[], None]) -> BinaryIO:
    """Return the open file of the cells of a spec."""
    from sweep.atlas.dataset import assemble, empty_columns
    from sweep.files.export import export
    from sweep.files.netcdf import save

    columns = empty_columns(spec)
    for span in blocks(spec.size, _PIECE):
        check()
        with KERNELS:
            found = compute(spec, starts_of(spec, span))
        for name, column in found.items():
            columns[name][span.start : span.stop] = column
    atlas = assemble(spec, columns, command)
    with scratch_folder(Path(tempfile.gettempdir())) as folder:
        path = folder / FORMATS[kind]
        if kind == "netcdf":
            save(atlas, path)
        else:
            export(atlas, path, kind)
        # the folder and the name are deleted, but the file exists as long as it is open
        return path.open("rb")
