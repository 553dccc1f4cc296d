"""A run in parts, for the array jobs of a batch system: `prepare`, `block`, `assemble`."""

import re
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import BlockCells, MaxFailed, Overwrite, Spec, Threads, Words
from sweep.commands.outcome import conclude
from sweep.commands.stopping import stoppable
from sweep.errors import RequestError


def prepare(
    spec: Spec,
    words: Words = None,
    *,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.nc", help="The netCDF file of the end.")
    ],
    overwrite: Overwrite = False,
    block_cells: BlockCells = None,
) -> None:
    """Make the folder OUT.nc.run of a run without computing a cell, and print its name.

    Then: eulerdisk block --run OUT.nc.run --part I/N for every I from 1 to N, and eulerdisk assemble OUT.nc.run.
    """
    from sweep.request.spec import SweepSpec

    request = SweepSpec.from_words(spec, words or [])
    from sweep.runs import array_jobs

    command = shlex.join(["eulerdisk", "run", spec, *(words or [])])
    journal = array_jobs.prepare(
        request, output, overwrite=overwrite, block_cells=block_cells, command=command
    )
    print(journal.folder)
    print(f"eulerdisk: {request.size} cells in {len(journal.spans)} blocks", file=sys.stderr)


def block(
    *,
    folder: Annotated[Path, typer.Option("--run", metavar="DIR", help="The folder of the run.")],
    part: Annotated[str, typer.Option(metavar="I/N", help="Which part, from 1/N to N/N.")],
    threads: Threads = None,
) -> None:
    """Compute one part of a prepared run: every N-th block, those that are there already excepted."""
    found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", part)
    number, count = map(int, found.groups()) if found else (0, 0)
    if not 1 <= number <= count:
        raise RequestError("not a part", "I/N with 1 <= I <= N", part, "--part 1/10, for instance", "--part")
    from sweep.commands.progress import reporting, say
    from sweep.runs import array_jobs

    with stoppable() as stopping, reporting() as progress:
        kept, computed = array_jobs.compute_part(
            folder, number, count, threads=threads, progress=progress, say=say, stopping=stopping
        )
    print(f"eulerdisk: part {part}: {kept} blocks were there, {computed} computed", file=sys.stderr)


def assemble(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the run.")],
    *,
    overwrite: Overwrite = False,
    max_failed: MaxFailed = 1.0,
) -> None:
    """Make the file of a run whose blocks are all there, and remove its folder."""
    from sweep.runs import array_jobs

    spec, path, failures = array_jobs.assemble(folder, overwrite=overwrite)
    conclude(failures, spec, path, max_failed)
