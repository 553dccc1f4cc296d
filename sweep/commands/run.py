"""The commands that compute atlases: `run`; `prepare`, `block` and `assemble` for array jobs; `plan`."""

import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweep.commands.arguments import (
    BlockCells,
    MaxFailed,
    OptionalSpec,
    Output,
    Overwrite,
    Quiet,
    Spec,
    Starts,
    Threads,
    Words,
    read_request,
    with_starts,
)
from sweep.commands.terminal import say, show, stoppable
from sweep.errors import RequestError, are, counted
from sweep.progress.display import showing

if TYPE_CHECKING:
    from sweep.request.spec import SweepSpec
    from sweep.runs.run import Failures


def run(
    spec: OptionalSpec = None,
    words: Words = None,
    *,
    source: Annotated[
        Path | None,
        typer.Option("--from", metavar="ATLAS.nc", help="Repeat the run of this atlas, instead of a SPEC."),
    ] = None,
    starts: Starts = None,
    output: Output,
    overwrite: Overwrite = False,
    threads: Threads = None,
    block_cells: BlockCells = None,
    max_failed: MaxFailed = 1.0,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Compute on the workers of a dask scheduler, e.g. tcp://host:8786."
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compute an atlas and write it to one netCDF file; the same command continues an interrupted run.

    eulerdisk run rolling roll_rate=0.5:6:400 tilt=0.01deg:20deg:300:log -o rolling.nc

    eulerdisk run --from rolling.nc -o again.nc

    eulerdisk run rolling roll_rate=uniform:2:4 tilt=normal:1deg:0.2deg samples=1e6 -o random.nc

    Rates can be given in units of sqrt(gravity/radius): scaled_roll_rate=0.5:0.7:400, scaled_precession_rate=0.9,
    scaled_tilt_rate=0.01. The presets use these units: with radius=12mm they cover the boundary of a coin. The speed of
    the contact point can replace roll_rate: speed=15cm/s.
    """
    from sweep.files.paths import check_atlas_name

    words = with_starts(words, starts)
    check_atlas_name(output)
    request = read_request(spec, words, source)
    from sweep.runs.run import run_to_file

    executor = None
    if dask is not None:
        from sweep.runs.dask_executor import on_cluster

        executor = on_cluster(dask, say)
    # The history contains only what decides the atlas, and its path: other options do not change the file's bytes.
    origin = [] if source is None else ["--from", str(source)]
    first = [] if spec is None else [spec]
    command = shlex.join(["eulerdisk", "run", *origin, *first, *words, "-o", str(output)])
    with stoppable() as stopping, showing(quiet=quiet) as progress:
        _warn(request)
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
    _conclude(failures, output, max_failed, quiet)


def prepare(
    spec: Spec,
    words: Words = None,
    *,
    starts: Starts = None,
    output: Output,
    overwrite: Overwrite = False,
    block_cells: BlockCells = None,
) -> None:
    """Create the folder OUT.nc.run of a run, without computing a cell, and print its name.

    Next, run eulerdisk block --run OUT.nc.run --part I/N for every I from 1 to N, then eulerdisk assemble OUT.nc.run.
    """
    from sweep.files.paths import check_atlas_name

    words = with_starts(words, starts)
    check_atlas_name(output)
    request = read_request(spec, words, None)
    from sweep.runs import array_jobs

    command = shlex.join(["eulerdisk", "run", spec, *words, "-o", str(output)])
    journal = array_jobs.prepare(
        request, output, overwrite=overwrite, block_cells=block_cells, command=command
    )
    show(str(journal.folder))
    say(f"{counted(request.size, 'cell')} in {counted(len(journal.spans), 'block')}")
    _warn(request)


def block(
    *,
    folder: Annotated[Path, typer.Option("--run", metavar="DIR", help="The folder of the run.")],
    part: Annotated[str, typer.Option(metavar="I/N", help="The part to compute, from 1/N to N/N.")],
    threads: Threads = None,
    quiet: Quiet = False,
) -> None:
    """Compute one part of a prepared run: every N-th block, except those already computed."""
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", part, re.ASCII)
    number, count = map(int, match.groups()) if match else (0, 0)
    if not 1 <= number <= count:
        raise RequestError(
            f"A part is I/N with 1 <= I <= N; got {part}.", "Write --part 1/10, for instance.", "--part"
        )
    from sweep.runs import array_jobs

    with stoppable() as stopping, showing(quiet=quiet) as progress:
        kept, computed = array_jobs.compute_part(
            folder, number, count, threads=threads, progress=progress, say=say, stopping=stopping
        )
    if not quiet:
        already = f"{counted(kept, 'block')} {are(kept, 'was', 'were')} already computed"
        say(f"part {part}: {already}, {computed} computed now")


def assemble(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the run.")],
    *,
    overwrite: Overwrite = False,
    threads: Threads = None,
    max_failed: MaxFailed = 1.0,
    quiet: Quiet = False,
) -> None:
    """Write the atlas of a run whose blocks are all computed, and remove the folder of the run."""
    from sweep.runs import array_jobs

    with showing(quiet=quiet) as progress:
        path, failures = array_jobs.assemble(folder, overwrite=overwrite, threads=threads, progress=progress)
    _conclude(failures, path, max_failed, quiet)


def plan(
    spec: Spec,
    words: Words = None,
    *,
    starts: Starts = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.nc", help="The file that the run will write.")
    ] = Path("atlas.nc"),
    threads: Threads = None,
    block_cells: BlockCells = None,
    calibrate: Annotated[
        bool, typer.Option("--calibrate/--no-calibrate", help="Measure the speed of this machine.")
    ] = True,
) -> None:
    """Estimate the cost of a run: cells, blocks, time, memory and disk space. Nothing is written.

    Exit status 1 if the run does not fit on the disk.
    """
    from sweep.files.paths import check_atlas_name, check_target
    from sweep.files.publish import check_room
    from sweep.runs.forecast import Forecast, describe, file_bytes, journal_bytes, least_cells, suitable_block

    check_atlas_name(output)
    request = read_request(spec, with_starts(words, starts), None)
    # only the run itself needs --overwrite: the estimate is the same if the file exists
    check_target(output, True)
    forecast, used, available = None, 1, 1
    if calibrate:
        from sweep import platforms
        from sweep.engine.compute import usable_threads

        used, available = usable_threads(threads), platforms.available_threads()
        forecast = Forecast.measured(request, threads)
        block_cells = block_cells or suitable_block(forecast.rate, least_cells(threads))
    show("\n".join(describe(request, output, forecast, block_cells, used, available)))
    _warn(request)
    try:
        if forecast is None:
            bound = journal_bytes(request, request.size) + file_bytes(request)
            check_room(output, bound)
        else:
            check_room(output, forecast.journal_bytes(request) + forecast.file_bytes(request))
    except RequestError as problem:
        show(f"does not fit: {problem}")
        raise typer.Exit(1) from None


def _warn(request: "SweepSpec") -> None:
    """Warn if theory predicts no boundary in any row of a grid: usually the range belongs to another disk."""
    from sweep.atlas.outlook import one_sided

    for warning in one_sided(request):
        say(f"warning: {warning}")


def _conclude(failures: "Failures", output: Path, most: float, quiet: bool) -> None:
    """Report the file, unless `quiet`, and the cells that failed; exit with 1 if more than `most` percent failed."""
    cells = failures.spec.size
    if not quiet:
        say(f"{output}: {counted(cells, 'cell')}")
    for line in failures.warnings():
        say(f"warning: {line}")
    if failures.total:
        for line in failures.describe():
            say(line)
    if 100.0 * failures.total > most * cells:
        say(f"more than --max-failed {most:g} % failed; the file is complete, and marks these cells")
        raise typer.Exit(1)
