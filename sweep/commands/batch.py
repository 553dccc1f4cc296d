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
    from sweep.batch.night import Outcome
    from sweep.batch.sweeps import Sweep


def batch(
    specs: Annotated[
        list[str],
        typer.Argument(
            metavar="SPEC...", help="Presets or .toml files; a file may hold several tables [[sweep]]."
        ),
    ],
    *,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="The folder for the atlases, NAME.nc each.")
    ],
    verify: Annotated[
        bool, typer.Option("--verify", help="Verify every atlas against the exact reduction.")
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
    from sweep.batch.sweeps import read_sweeps

    sweeps = read_sweeps(specs)
    _check_folders(output, reference)
    _check_threads(threads)
    if junit is not None:
        _check_report(junit, sweeps, output, reference)
    refused = [each for each in sweeps if each.spec is None]
    for each in refused:
        say(f"left out: {each.problem}")
    nothing = len(refused) == len(sweeps)
    if nothing and not as_json and junit is None:
        raise typer.Exit(2)
    if not nothing or (junit is not None and _is_in(junit, output)):
        _make_folder(output)
    outcomes = _carry_out(sweeps, output, verify, reference, overwrite, threads, max_failed, junit, quiet)
    if as_json or not nothing:
        _report(outcomes, max_failed, as_json)
    if not all(each.is_fine(max_failed) for each in outcomes):
        raise typer.Exit(2 if nothing else 1)


def _check_threads(threads: int | None) -> None:
    from sweep.engine.compute import usable_threads

    usable_threads(threads)


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


def _carry_out(
    sweeps: "list[Sweep]",
    output: Path,
    verify: bool,
    reference: Path | None,
    overwrite: bool,
    threads: int | None,
    most: float,
    junit: Path | None,
    quiet: bool,
) -> "list[Outcome]":
    from sweep.batch.night import FAILED, REFUSED, Wishes, carry_out
    from sweep.batch.report import problems_of

    wishes = Wishes(output, verify, reference, overwrite, threads)
    outcomes: list[Outcome] = []
    # a server that reads the file alone does not take an older one for that of a batch that was killed
    _write_junit(junit, [], most, sweeps)
    try:
        with stoppable() as stopping, showing(quiet=quiet) as progress:
            for found in carry_out(sweeps, wishes, show=progress, say=say, stopping=stopping):
                outcomes.append(found)
                if quiet or found.state == REFUSED:
                    continue
                wrong = problems_of(found, most) if found.state != FAILED else {}
                but = f", NOT as it should be ({' and '.join(wrong)})" if wrong else ""
                say(
                    f"{found.sweep.label}: {found.state}{but}, {counted(len(outcomes), 'sweep', len(sweeps))} done"
                )
    finally:
        _write_junit(junit, outcomes, most, sweeps[len(outcomes) :])
    return outcomes


def _write_junit(path: Path | None, outcomes: "list[Outcome]", most: float, waiting: "list[Sweep]") -> None:
    if path is None:
        return
    from sweep.batch.report import to_junit
    from sweep.files.publish import published

    with published(path) as unfinished:
        unfinished.write_text(to_junit(outcomes, most, waiting), encoding="utf-8")


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


def _report(outcomes: "list[Outcome]", most: float, as_json: bool) -> None:
    import json

    from sweep.batch.report import in_words, to_json

    show(
        json.dumps(to_json(outcomes, most), indent=1, allow_nan=False)
        if as_json
        else in_words(outcomes, most)
    )
