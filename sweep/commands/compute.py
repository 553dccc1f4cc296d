"""Compute atlases: `run`."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import OptionalSpec, Words
from sweep.commands.requests import read_request
from sweep.commands.stopping import stoppable


def run(
    spec: OptionalSpec = None,
    words: Words = None,
    *,
    source: Annotated[
        Path | None,
        typer.Option("--from", metavar="ATLAS.nc", help="Repeat the run of an atlas, instead of a SPEC."),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.nc", help="The netCDF file to write.")
    ],
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace OUT.nc if it exists.")] = False,
    threads: Annotated[int | None, typer.Option(help="Threads; all that may be used, if not given.")] = None,
) -> None:
    """Compute an atlas and write it to one netCDF file.

    eulerdisk run rolling roll_rate=0.5:6:400 tilt=0.01deg:20deg:300:log -o rolling.nc

    eulerdisk run --from rolling.nc -o again.nc
    """
    request = read_request(spec, words or [], source)
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
