"""What a run will take, before it is begun: `plan`."""

from pathlib import Path
from typing import Annotated

import typer

from sweep.commands.arguments import BlockCells, Spec, Threads, Words


def plan(
    spec: Spec,
    words: Words = None,
    *,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="OUT.nc", help="Where the file will be.")
    ] = Path("atlas.nc"),
    threads: Threads = None,
    block_cells: BlockCells = None,
    calibrate: Annotated[
        bool, typer.Option("--calibrate/--no-calibrate", help="Measure how fast cells are computed.")
    ] = True,
) -> None:
    """Say what a run takes: cells, blocks, time, memory, disk. Nothing is written; 1 if it does not fit the disk."""
    from sweep.engine import estimate
    from sweep.errors import RequestError
    from sweep.files.paths import check_target
    from sweep.request.spec import SweepSpec

    request = SweepSpec.from_words(spec, words or [])
    # that the file is there already matters to the run only
    check_target(output, True)
    rate, used, there = None, 1, 1
    if calibrate:
        from sweep.engine.calibrate import cells_per_second, least_cells
        from sweep.engine.runner import available_threads, usable_threads

        used, there = usable_threads(threads), available_threads()

        rate = cells_per_second(request, threads)
        block_cells = block_cells or estimate.block_cells(rate, least_cells(threads))
    print("\n".join(estimate.describe(request, output, rate, block_cells, used, there)))
    try:
        estimate.check_room(output, estimate.run_bytes(request))
    except RequestError as problem:
        print(f"does not fit: {problem}")
        raise typer.Exit(1) from None
