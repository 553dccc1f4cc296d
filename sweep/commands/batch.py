"""Compute and check many sweeps in one command: `batch`."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweep.commands.arguments import MaxFailed, Quiet, Threads
from sweep.commands.terminal import say, show, stoppable
from sweep.errors import RequestError, counted
from sweep.progress.display import showing

if TYPE_CHECKING:
    from sweep.batch.sweeps import Sweep


def batch(
    specs: Annotated[
        list[str],
        typer.Argument(
            metavar="SPEC...",
            help="Presets, .toml or .py files; a .toml file may hold several tables [[sweep]].",
        ),
    ],
    *,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="The folder for the atlases, NAME.nc each.")
    ],
    verify: Annotated[
        bool, typer.Option("--verify", help="Verify every atlas against the reference of its model.")
    ] = False,
    reference: Annotated[
        Path | None,
        typer.Option(
            "--reference", metavar="DIR", help="Compare each with the trusted atlas of its name there."
        ),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace atlases that another spec or other code has made.")
    ] = False,
    threads: Threads = None,
    max_failed: MaxFailed = 1.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of the table.")] = False,
    junit: Annotated[
        Path | None, typer.Option(metavar="OUT.xml", help="Write JUnit XML too, for a CI server.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compute many sweeps, check each, and print a table: for a night on a workstation, or a regression check in CI.

    eulerdisk batch sweeps/*.toml -o tonight/ --verify --reference trusted/

    What fails in one sweep stops no other. The same command goes on where it was cut off: atlases that are finished
    are kept. Exit status: 0 all is as it should be, 1 something is not, 2 nothing could be begun.
    """
    import json

    from sweep.batch.execution import FAILED, REFUSED, Options, Outcome, carry_out
    from sweep.batch.report import in_words, to_json, to_junit
    from sweep.batch.sweeps import read_sweeps
    from sweep.engine.compute import usable_threads
    from sweep.files.publish import published

    sweeps = read_sweeps(specs)
    _check_folders(output, reference)
    usable_threads(threads)
    if junit is not None:
        _check_report(junit, sweeps, output, reference)
    for each in sweeps:
        if each.spec is None:
            say(f"left out: {each.problem}")
    nothing = all(each.spec is None for each in sweeps)
    if nothing and not as_json and junit is None:
        raise typer.Exit(2)
    if not nothing or (junit is not None and _is_in(junit, output)):
        _make_folder(output)
    outcomes: list[Outcome] = []

    def write_junit() -> None:
        if junit is not None:
            with published(junit) as unfinished:
                unfinished.write_text(to_junit(outcomes, sweeps[len(outcomes) :]), encoding="utf-8")

    options = Options(output, verify, reference, overwrite, threads, max_failed)
    # a server that reads the file alone does not take an older one for that of a batch that was killed
    write_junit()
    try:
        with stoppable() as stopping, showing(quiet=quiet) as progress:
            for found in carry_out(sweeps, options, show=progress, say=say, stopping=stopping):
                outcomes.append(found)
                if quiet or found.state == REFUSED:
                    continue
                wrong = found.problems if found.state != FAILED else {}
                but = f", NOT as it should be ({' and '.join(wrong)})" if wrong else ""
                done = counted(len(outcomes), "sweep", len(sweeps))
                say(f"{found.sweep.label}: {found.state}{but}, {done} done")
    finally:
        write_junit()
    if as_json:
        show(json.dumps(to_json(outcomes), indent=1, allow_nan=False))
    elif not nothing:
        show(in_words(outcomes))
    if any(each.problems for each in outcomes):
        raise typer.Exit(2 if nothing else 1)


def _check_report(junit: Path, sweeps: "list[Sweep]", output: Path, reference: Path | None) -> None:
    """Refuse a report that cannot be written, or would replace what is read or made."""
    from sweep.files.paths import check_target

    folders = [output, *([] if reference is None else [reference])]
    atlases = [folder / f"{each.name}.nc" for folder in folders for each in sweeps]
    held = [*(Path(each.file) for each in sweeps), *atlases]
    if os.path.realpath(junit) in [os.path.realpath(each) for each in held]:
        raise RequestError(
            "The report must be another file: this would replace a spec or an atlas of the batch.",
            "Write --junit report.xml.",
            f"--junit {junit}",
        )
    # the batch makes its folder
    if os.path.isdir(output) or not _is_in(junit, output):
        check_target(junit, True)


def _is_in(path: Path, folder: Path) -> bool:
    return os.path.realpath(path.parent) == os.path.realpath(folder)


def _make_folder(output: Path) -> None:
    try:
        output.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as problem:
        raise RequestError(
            f"The folder for the atlases cannot be made: {getattr(problem, 'strerror', None) or problem}.",
            "Give another name or folder.",
            f"-o {output}",
        ) from problem


def _check_folders(output: Path, reference: Path | None) -> None:
    if os.path.exists(output) and not os.path.isdir(output):
        raise RequestError(
            "The atlases of a batch go into a folder; this is a file.", "Name a folder.", f"-o {output}"
        )
    if reference is None:
        return
    if not os.path.isdir(reference):
        raise RequestError(
            "The trusted atlases lie in a folder; there is none of this name.",
            "Check the path, or leave it out.",
            f"--reference {reference}",
        )
    if os.path.exists(output) and os.path.samefile(output, reference):
        raise RequestError(
            "The trusted atlases lie where the new ones are to be written: they would be compared with themselves.",
            "Name another folder for one of them.",
            f"--reference {reference}",
        )
