"""A run in parts: prepared, computed by the jobs of an array, assembled; every part of it can be done again."""

import shlex
from pathlib import Path

from sweep.engine import estimate
from sweep.engine.ahead import ahead
from sweep.engine.runner import usable_threads
from sweep.errors import RequestError, StoppedError
from sweep.files.publish import refusals
from sweep.files.store import check_target
from sweep.request.spec import SweepSpec
from sweep.runs import journal
from sweep.runs.assembly import publish_atlas
from sweep.runs.claims import begun, check_same, claimed, final
from sweep.runs.driving import Progress, Say, Stopping, here, unheard
from sweep.runs.failures import Failures
from sweep.runs.journal import Journal
from sweep.runs.locks import locked


def prepare(
    spec: SweepSpec,
    path: str | Path,
    *,
    overwrite: bool = False,
    block_cells: int | None = None,
    command: str = "sweep.prepare",
) -> Journal:
    """Make the folder of a run, without computing a cell; what is left is `compute_part` and `assemble`.

    Raises
    ------
    RequestError
        As in `run_to_file`.
    """
    path = final(path)
    with claimed(path, overwrite) as folder:
        check_target(path, overwrite)
        book = begun(spec, path, folder, block_cells, None, command)
    return book


def compute_part(
    folder: str | Path,
    part: int,
    parts: int,
    *,
    threads: int | None = None,
    progress: Progress = unheard,
    say: Say = unheard,
    stopping: Stopping = lambda: False,
) -> tuple[int, int]:
    """Compute every `parts`-th block of a prepared run, from the `part`-th on (1 to `parts`); one job of an array.

    Returns
    -------
    (kept, computed) : int
        Blocks of this part that were there, and that were computed now.

    Raises
    ------
    RequestError
        If there is no such run, this program computes other bits, or the run is being written by `run_to_file`.
    StorageError, StoppedError
        As in `run_to_file`.
    """
    folder = Path(folder)
    usable_threads(threads)
    book = Journal.at(folder)
    check_same(book, book.manifest.spec)
    mine = range(part - 1, len(book.spans), parts)
    with locked(folder, shared=True), refusals(folder, kept=book.kept):
        sound, damaged = book.verify(mine)
        for each in damaged:
            say(f"damaged, set aside and computed again: {each}")
        missing = [number for number in mine if number not in sound]
        for done, _ in enumerate(here(threads)(book, missing, stopping), 1):
            progress(len(sound) + done, len(mine))
        if not book.held().keys() >= set(mine):
            raise StoppedError(str(folder), len(book.held()), len(book.spans))
    return len(sound), len(missing)


def assemble(folder: str | Path, *, overwrite: bool = False) -> tuple[SweepSpec, Path, Failures]:
    """Make the file of a run whose blocks are all there, and remove its folder.

    Returns
    -------
    (spec, path, failures) : SweepSpec, Path, Failures
        What was computed, the file, and the cells that could not be computed.

    Raises
    ------
    RequestError
        If blocks are missing or damaged, or the file exists.
    StorageError
        If the file system refuses.
    """
    # "." has no name
    folder = Path(folder) if Path(folder).name else Path(folder).resolve()
    Journal.at(folder)
    if not folder.name.removesuffix(journal.SUFFIX) or not folder.name.endswith(journal.SUFFIX):
        raise RequestError(
            "no name for the file",
            f"the folder of OUT.nc is called OUT.nc{journal.SUFFIX}",
            folder.name,
            f"rename it: `mv {shlex.quote(folder.name)} OUT.nc{journal.SUFFIX}`",
            str(folder),
        )
    path = folder.with_name(folder.name.removesuffix(journal.SUFFIX))
    with claimed(path, overwrite):
        check_target(path, overwrite)
        book = Journal.at(folder)
        check_same(book, book.manifest.spec)
        sound, damaged = book.verify()
        missing = book.missing(sound)
        if missing:
            raise RequestError(
                "blocks are missing",
                "an atlas is assembled from all of its blocks",
                "; ".join(
                    [
                        f"{len(missing)} of {len(book.spans)} missing, the first is {missing[0]}",
                        *(f"damaged and set aside: {each}" for each in damaged[:10]),
                    ]
                ),
                "run the parts again that have not ended well; what is there is kept",
                str(folder),
            )
        with (
            refusals(path, lambda: estimate.file_bytes(book.manifest.spec), book.kept),
            ahead(book.blocks()) as blocks,
        ):
            return book.manifest.spec, path, publish_atlas(book, path, blocks)
