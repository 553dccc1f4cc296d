"""The cells of a window as a file: netCDF, an atlas like any other, or a table."""

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from sweep.atomic import scratch_folder
from sweep.engine.compute import compute
from sweep.engine.grid import blocks, starts_of
from sweep.explorer.commands import window_commands, window_spec
from sweep.explorer.fields import read_choice
from sweep.explorer.turns import FILES, KERNELS, turn
from sweep.explorer.view import View
from sweep.request.spec import SweepSpec

#: Cells of a file at most: a table of them has 200 MB.
MOST_CELLS = 1_000_000

#: Format -> name of the file.
FORMATS = {"csv": "window.csv", "netcdf": "window.nc"}

#: Cells that are computed before it is asked whether anybody still waits.
_PIECE = 16384


def window_file(view: View, fields: Mapping[str, Any], check: Callable[[], None]) -> tuple[str, BinaryIO]:
    """Compute the cells of a window, and return a name and an open file with them, which has none on the disk.

    Parameters
    ----------
    view : View
    fields : mapping
        ``width`` and ``height`` in pixels, and the ``format``, ``csv`` or ``netcdf``.
    check : callable
        Called between pieces of work: raises where the file is no longer wanted.

    Raises
    ------
    RequestError
        If there are too many pixels, or cells of the view cannot be computed.
    """
    kind = read_choice(fields, "format", tuple(FORMATS))
    view.live  # noqa: B018 - without an exact reduction cells would be integrated in time
    spec = window_spec(view, fields, MOST_CELLS)
    command = window_commands(view, fields)["command"]
    with turn(FILES, check):
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
        # the folder and its names go, the file is there as long as it is open
        return path.open("rb")
