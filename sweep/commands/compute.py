"""Compute atlases: `run`."""

import shlex
from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import BlockCells, MaxFailed, OptionalSpec, Overwrite, Threads, Words
from sweep.commands.outcome import conclude
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
    overwrite: Overwrite = False,
    threads: Threads = None,
    block_cells: BlockCells = None,
    max_failed: MaxFailed = 1.0,
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Compute on the workers of a dask scheduler, tcp://host:8786."),
    ] = None,
) -> None:
    """Compute an atlas and write it to one netCDF file; the same command goes on where an earlier one ended.

    eulerdisk run rolling roll_rate=0.5:6:400 tilt=0.01deg:20deg:300:log -o rolling.nc

    eulerdisk run --from rolling.nc -o again.nc
    """
    request = read_request(spec, words or [], source)
    from sweep.commands.progress import reporting, say
    from sweep.runs.run import run_to_file

    executor = None
    if dask is not None:
        from sweep.runs.dask_executor import on_cluster

        executor = on_cluster(dask, say)
    # what makes this atlas; how, and under which name, is not for its history: its bytes do not depend on that
    origin = ["--from", str(source)] if spec is None else [spec]
    command = shlex.join(["eulerdisk", "run", *origin, *(words or [])])
    with stoppable() as stopping, reporting() as progress:
        failures = run_to_file(
            request,
            output,
            overwrite=overwrite,
            threads=threads,
            block_cells=block_cells,
            command=command,
            progress=progress,
            say=say,
            stopping=stopping,
            executor=executor,
        )
    conclude(failures, request, output, max_failed)
