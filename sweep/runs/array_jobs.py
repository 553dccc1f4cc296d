"""Runs as arrays of jobs: prepare a run, compute its blocks in parts, assemble the file; every step can be repeated."""

import shlex
from pathlib import Path

from sweep.engine.compute import usable_threads
from sweep.errors import RequestError, are, counted
from sweep.files.paths import check_target
from sweep.files.publish import refusals
from sweep.progress.timetable import Show
from sweep.request.spec import SweepSpec
from sweep.runs.executor import Say, Stopping, local, no_op
from sweep.runs.folder import SUFFIX, locked, resolved
from sweep.runs.forecast import READING, file_bytes, of_journal, of_part
from sweep.runs.journal import Journal
from sweep.runs.run import Failures, publish_from_journal, reported, verified
from sweep.runs.run_directory import begin_or_resume, check_same_run, claimed


def prepare(
    spec: SweepSpec,
    path: str | Path,
    *,
    overwrite: bool = False,
    block_cells: int | None = None,
    command: str = "sweep.runs.array_jobs.prepare",
) -> Journal:
    """Make the folder of a run without computing a cell; `compute_part` and `assemble` do the rest.

    Parameters and errors are as in `run_to_file`.
    """
    path = resolved(path)
    with claimed(path, overwrite) as folder:
        check_target(path, overwrite)
        return begin_or_resume(spec, path, folder, block_cells, None, command)


def compute_part(
    folder: str | Path,
    part: int,
    parts: int,
    *,
    threads: int | None = None,
    progress: Show = no_op,
    say: Say = no_op,
    stopping: Stopping = lambda: False,
) -> tuple[int, int]:
    """Compute every `parts`-th block of a prepared run, starting at the `part`-th (1 to `parts`); one job of an array.

    Returns how many blocks of this part were finished before, and how many were computed now. Errors are as in
    `run_to_file`. Jobs of one array may run at the same time, but not together with `run_to_file`.
    """
    folder = Path(folder)
    usable_threads(threads)
    journal = Journal.at(folder)
    check_same_run(journal, journal.spec)
    mine = range(part - 1, len(journal.spans), parts)
    with locked(folder, shared=True), refusals(folder, kept=journal.kept):
        cells = journal.cells(mine)
        timetable = of_part(cells, progress)
        missing = verified(journal, mine, timetable, say)
        for _ in reported(journal, local(threads)(journal, missing, stopping), missing, timetable, cells):
            pass
    return len(mine) - len(missing), len(missing)


def assemble(
    folder: str | Path, *, overwrite: bool = False, threads: int | None = None, progress: Show = no_op
) -> tuple[Path, Failures]:
    """Make the file of a run whose blocks are all finished, and remove its folder.

    `threads` and `progress` are as in `run_to_file`. Returns the file, and the cells that could not be computed. Raises
    a RequestError if blocks are missing or damaged; other errors are as in `run_to_file`.
    """
    # the path "." has no name
    folder = Path(folder) if Path(folder).name else Path(folder).resolve()
    Journal.at(folder)
    if not folder.name.removesuffix(SUFFIX) or not folder.name.endswith(SUFFIX):
        raise RequestError(
            f"The folder of a run must be called OUT.nc{SUFFIX}, because it gives the file its name; got "
            f"{folder.name}.",
            hint=f"Rename it: `mv {shlex.quote(folder.name)} OUT.nc{SUFFIX}`.",
            where=str(folder),
        )
    path = folder.with_name(folder.name.removesuffix(SUFFIX))
    with claimed(path, overwrite):
        check_target(path, overwrite)
        journal = Journal.at(folder)
        check_same_run(journal, journal.spec)
        timetable = of_journal(journal.spec, usable_threads(threads), progress)
        timetable.begin(READING)
        missing, damaged = journal.verify(range(len(journal.spans)), timetable.report)
        if missing:
            set_aside = f" Damaged and set aside: {'; '.join(damaged[:10])}." if damaged else ""
            raise RequestError(
                f"An atlas needs all of its blocks; {counted(len(missing), 'block', len(journal.spans))} "
                f"{are(len(missing))} missing, the first is block {missing[0]}.{set_aside}",
                hint="Run the parts that failed again; finished blocks are kept.",
                where=str(folder),
            )
        with refusals(path, lambda: file_bytes(journal.spec), journal.kept):
            return path, publish_from_journal(journal, path, timetable, threads)
