"""Compute and check many sweeps in one command: `batch`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sweep.commands.arguments import MaxFailed, Quiet, Threads
from sweep.commands.terminal import say, show, showing, stoppable
from sweep.errors import RequestError

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
    if junit is not None:
        from sweep.files.paths import check_target

        check_target(junit, True)
    refused = [each for each in sweeps if each.spec is None]
    for each in refused:
        say(f"{each.name} is left out: {each.problem}")
    if len(refused) == len(sweeps):
        raise typer.Exit(2)
    outcomes = _carry_out(sweeps, output, verify, reference, overwrite, threads, quiet)
    _report(outcomes, max_failed, as_json, junit)
    if not all(each.is_fine(max_failed) for each in outcomes):
        raise typer.Exit(1)


def _carry_out(
    sweeps: "list[Sweep]",
    output: Path,
    verify: bool,
    reference: Path | None,
    overwrite: bool,
    threads: int | None,
    quiet: bool,
) -> "list[Outcome]":
    from sweep.batch.night import Wishes, carry_out
    from sweep.engine.compute import usable_threads

    usable_threads(threads)
    output.mkdir(parents=True, exist_ok=True)
    wishes = Wishes(output, verify, reference, overwrite, threads)

    outcomes: list[Outcome] = []
    with stoppable() as stopping, showing(quiet=quiet) as progress:
        for found in carry_out(sweeps, wishes, show=progress, say=say, stopping=stopping):
            outcomes.append(found)
            if not quiet:
                say(f"{found.sweep.name}: {found.state}, {len(outcomes)} of {len(sweeps)} sweeps done")
    return outcomes


def _check_folders(output: Path, reference: Path | None) -> None:
    if output.exists() and not output.is_dir():
        raise RequestError(
            "The atlases of a batch go into a folder; this is a file.", "Name a folder.", f"-o {output}"
        )
    if reference is None:
        return
    if not reference.is_dir():
        raise RequestError(
            "The trusted atlases lie in a folder; there is none of this name.",
            "Check the path, or leave it out.",
            f"--reference {reference}",
        )
    if output.exists() and output.samefile(reference):
        raise RequestError(
            "The trusted atlases lie where the new ones are to be written: they would be compared with themselves.",
            "Name another folder for one of them.",
            f"--reference {reference}",
        )


def _report(outcomes: "list[Outcome]", most: float, as_json: bool, junit: Path | None) -> None:
    import json

    from sweep.batch.report import in_words, to_json, to_junit
    from sweep.files.publish import published

    if junit is not None:
        with published(junit) as unfinished:
            unfinished.write_text(to_junit(outcomes, most), encoding="utf-8")
    show(
        json.dumps(to_json(outcomes, most), indent=1, allow_nan=False)
        if as_json
        else in_words(outcomes, most)
    )
