"""Compute atlases: `run`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import Spec, Words
from sweep.commands.stopping import stoppable


def run(
    spec: Spec,
    words: Words = None,
    *,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.nc", help="The netCDF file to write.")
    ],
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace OUT.nc if it exists.")] = False,
    threads: Annotated[int | None, typer.Option(help="Threads; all that may be used, if not given.")] = None,
) -> None:
    """Compute an atlas and write it to one netCDF file.

    eulerdisk run rolling roll_rate=0.5:6:400 tilt=0.01deg:20deg:300:log -o rolling.nc
    """
    from sweep.spec import SweepSpec

    request = SweepSpec.from_words(spec, words or [])
    from sweep.progress import reporting
    from sweep.store import run_to_file

    command = shlex.join(["eulerdisk", *sys.argv[1:]])
    with stoppable(output) as check, reporting() as progress:

        def after_block(done: int, size: int) -> None:
            check()
            progress(done, size)

        run_to_file(
            request, output, overwrite=overwrite, threads=threads, command=command, progress=after_block
        )
    print(f"eulerdisk: {output}: {request.size} cells", file=sys.stderr)
