"""The command that computes and checks many sweeps: `batch`."""

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
            help="Presets, .toml or .py files; a .toml file can contain several tables [[sweep]].",
        ),
    ],
    *,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="The folder for the atlases, each NAME.nc.")
    ],
    verify: Annotated[
        bool, typer.Option("--verify", help="Verify every atlas against the reference of its model.")
    ] = False,
    reference: Annotated[
        Path | None,
        typer.Option(
            "--reference",
            metavar="DIR",
            help="Compare each atlas with the trusted one of the same name in DIR.",
        ),
    ] = None,
    overwrite: Annotated[
        bool,
        typer.Option(
            "--overwrite", help="Replace atlases that were made from another spec or by other code."
        ),
    ] = False,
    threads: Threads = None,
    max_failed: MaxFailed = 1.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of the table.")] = False,
    junit: Annotated[
        Path | None, typer.Option(metavar="OUT.xml", help="Also write JUnit XML, for a CI server.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compute many sweeps, check each, and print a table: for a night on a workstation, or a regression check in CI.

    eulerdisk batch sweeps/*.toml -o tonight/ --verify --reference trusted/

    A sweep that fails does not stop the others. After an interruption, the same command continues and keeps finished
    atlases. Exit status: 0 all sweeps passed, 1 some failed, 2 nothing could be started.
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
    for sweep in sweeps:
        if sweep.spec is None:
            say(f"left out: {sweep.problem}")
    nothing = all(sweep.spec is None for sweep in sweeps)
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
    # a CI server must not take an older file for the report of a batch that was killed
    write_junit()
    try:
        with stoppable() as stopping, showing(quiet=quiet) as progress:
            for outcome in carry_out(sweeps, options, show=progress, say=say, stopping=stopping):
                outcomes.append(outcome)
                if quiet or outcome.state == REFUSED:
                    continue
                wrong = outcome.problems if outcome.state != FAILED else {}
                failure = f", FAILED a check ({' and '.join(wrong)})" if wrong else ""
                done = counted(len(outcomes), "sweep", len(sweeps))
                say(f"{outcome.sweep.label}: {outcome.state}{failure}, {done} done")
    finally:
        write_junit()
    if as_json:
        show(json.dumps(to_json(outcomes), indent=1, allow_nan=False))
    elif not nothing:
        show(in_words(outcomes))
    if any(outcome.problems for outcome in outcomes):
        raise typer.Exit(2 if nothing else 1)


def _check_report(junit: Path, sweeps: "list[Sweep]", output: Path, reference: Path | None) -> None:
    """Refuse a report that cannot be written, or would replace an input or an atlas."""
    from sweep.files.paths import check_target

    folders = [output, *([] if reference is None else [reference])]
    atlases = [folder / f"{sweep.name}.nc" for folder in folders for sweep in sweeps]
    files = [*(Path(sweep.file) for sweep in sweeps), *atlases]
    if os.path.realpath(junit) in [os.path.realpath(file) for file in files]:
        raise RequestError(
            "The report would replace a spec or an atlas of the batch.",
            "Write --junit report.xml.",
            f"--junit {junit}",
        )
    # the batch creates its own folder
    if os.path.isdir(output) or not _is_in(junit, output):
        check_target(junit, True)


def _is_in(path: Path, folder: Path) -> bool:
    return os.path.realpath(path.parent) == os.path.realpath(folder)


def _make_folder(output: Path) -> None:
    try:
        output.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as problem:
        raise RequestError(
            f"Cannot create the folder for the atlases: {getattr(problem, 'strerror', None) or problem}.",
            "Give another name or folder.",
            f"-o {output}",
        ) from problem


def _check_folders(output: Path, reference: Path | None) -> None:
    if os.path.exists(output) and not os.path.isdir(output):
        raise RequestError(
            "A batch writes its atlases to a folder; this is a file.", "Name a folder.", f"-o {output}"
        )
    if reference is None:
        return
    if not os.path.isdir(reference):
        raise RequestError(
            "The folder of the trusted atlases does not exist.",
            "Check the path, or leave it out.",
            f"--reference {reference}",
        )
    if os.path.exists(output) and os.path.samefile(output, reference):
        raise RequestError(
            "The folder of the trusted atlases is the output folder: atlases would be compared with themselves.",
            "Name another folder for one of the two.",
            f"--reference {reference}",
        )
