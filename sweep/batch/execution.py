"""A batch from its sweeps to its outcomes: each is computed, verified and compared; one that fails stops no other."""

import os
import shlex
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from sweep.atlas.outlook import one_sided
from sweep.batch.sweeps import Sweep
from sweep.checks.alignment import OtherGridError
from sweep.checks.compare import Comparison, compare
from sweep.checks.comparison_report import what
from sweep.checks.findings import Findings
from sweep.checks.verify import findings_of
from sweep.engine.compute import arithmetic_hash
from sweep.errors import RequestError, StoppedError, are, counted
from sweep.files.reading import opened
from sweep.progress.timetable import Show, Status
from sweep.request.spec import SweepSpec
from sweep.runs.executor import Say, Stopping, no_op
from sweep.runs.run import Failures, run_to_file

#: Outcomes for the atlas of a sweep.
COMPUTED, KEPT, REFUSED, FAILED = "computed", "kept", "refused", "failed"


@dataclass
class Outcome:
    """The outcome of one sweep.

    Attributes
    ----------
    sweep : Sweep
    path : Path
        Its atlas.
    state : str
        COMPUTED; KEPT: it was there already, made from this spec by this code; REFUSED: the request was wrong;
        FAILED: the atlas could not be made.
    failures : Failures or None
        The cells that could not be computed.
    findings : Findings or None
        The audit, if it was asked for.
    comparison : Comparison or None
        With the trusted atlas, if it was asked for.
    problems : dict of str to str
        Step (``run``, ``verify``, ``compare``) -> what is not as it should be.
    seconds : dict of str to float
        Step -> how long it took.
    """

    sweep: Sweep
    path: Path
    state: str = FAILED
    failures: Failures | None = None
    findings: Findings | None = None
    comparison: Comparison | None = None
    problems: dict[str, str] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Options:
    """The options of every sweep.

    Parameters
    ----------
    folder : Path
        Where the atlases are written; it exists.
    verify : bool
        Whether every atlas is verified.
    reference : Path, optional
        A folder of trusted atlases with the same names.
    overwrite : bool
        Whether an atlas that another spec or other code has made is replaced.
    threads : int, optional
        Threads to use; all if not given.
    max_failed : float
        Per cent of the cells of a sweep that may be unresolved or invalid.
    """

    folder: Path
    verify: bool = False
    reference: Path | None = None
    overwrite: bool = False
    threads: int | None = None
    max_failed: float = 1.0


def carry_out(
    sweeps: Sequence[Sweep],
    options: Options,
    *,
    show: Show = no_op,
    say: Say = no_op,
    stopping: Stopping = lambda: False,
) -> Iterator[Outcome]:
    """Carry out sweeps one after the other, and yield what became of each.

    Parameters
    ----------
    sweeps : sequence of Sweep
    options : Options
    show, say, stopping
        As in `sweep.runs.run.run_to_file`.

    Raises
    ------
    StoppedError
        If `stopping` returned true. Finished atlases and blocks are kept, and the same call goes on.
    """
    for number, sweep in enumerate(sweeps):
        if stopping():
            raise StoppedError(f"{counted(number, 'sweep', len(sweeps))} {are(number)} finished")
        show(Status("compiling the kernels", 0, 0, None))
        found = Outcome(sweep, options.folder / f"{sweep.name}.nc")
        if sweep.spec is None:
            found.state, found.problems["run"] = REFUSED, sweep.problem
            yield found
            continue
        with _step(found, "run", say):
            _compute(found, sweep.spec, options, show, say, stopping)
        if options.verify and found.state != FAILED:
            with _step(found, "verify", say):
                _verify(found, _of_step("verify", show))
        if options.reference is not None and found.state != FAILED:
            with _step(found, "compare", say):
                _compare(found, options.reference / found.path.name, _of_step("compare", show))
        yield found


def _compute(
    found: Outcome, spec: SweepSpec, options: Options, show: Show, say: Say, stopping: Stopping
) -> None:
    other = _other_maker(found.path, spec)
    if other == "":
        found.failures, found.state = Failures.in_file(found.path, spec), KEPT
    elif other and not options.overwrite:
        raise RequestError(
            f"Nothing is written, because the atlas that is there was made {other}; what is finished is not replaced "
            "by accident.",
            hint="To replace it, add --overwrite; to keep it, name another folder.",
            where=str(found.path),
        )
    else:
        for warning in one_sided(spec):
            say(f"warning: {warning}")
        found.failures = run_to_file(
            spec,
            found.path,
            overwrite=options.overwrite,
            threads=options.threads,
            command=_command(found.sweep, found.path),
            progress=show,
            say=say,
            stopping=stopping,
        )
        found.state = COMPUTED
    if 100.0 * found.failures.total > options.max_failed * spec.size:
        found.problems["run"] = "; ".join(line.strip() for line in found.failures.describe())


def _verify(found: Outcome, show: Show) -> None:
    with opened(found.path, indexed=False) as atlas:
        found.findings = audit = findings_of(atlas, show=show)
    if not audit.passed:
        disagree = are(audit.disagreeing, "disagrees", "disagree")
        wrong = f"; wrong: {', '.join(each.name for each in audit.wrong[:6])}" if audit.wrong else ""
        found.problems["verify"] = (
            f"{counted(audit.disagreeing, 'cell')} {disagree} with the reference of the model, "
            f"{audit.missing} {are(audit.missing, 'lacks', 'lack')} a value{wrong}, "
            f"{audit.compared} could be compared. "
            f"More is said by: {shlex.join(['eulerdisk', 'verify', str(found.path)])}"
        )


def _compare(found: Outcome, trusted: Path, show: Show) -> None:
    if not os.path.lexists(trusted):
        raise RequestError(
            "There is no such file: the trusted atlas of this sweep is missing.",
            hint="When eulerdisk verify has found the new one right, make it the trusted one: "
            f"{shlex.join(['cp', str(found.path), str(trusted)])}",
            where=str(trusted),
        )
    with opened(found.path, indexed=False) as new, opened(trusted, indexed=False) as reference:
        try:
            found.comparison = compare(new, reference, progress=show)
        except OtherGridError as error:
            # a batch compares whole atlases
            hint = "Take back the change of the spec, or replace the trusted atlas by a verified one of this spec."
            raise RequestError(error.message, hint, str(trusted)) from None
    if not found.comparison.same:
        worst = next(each for each in found.comparison.findings if each.different)
        command = shlex.join(["eulerdisk", "compare", str(found.path), str(trusted)])
        found.problems["compare"] = (
            f"{in_one_line(found.comparison)}: {what(worst)}. More is said by: {command}"
        )


def in_one_line(comparison: Comparison) -> str:
    """Return the outcome of a comparison in some words."""
    names = [each.name for each in comparison.findings if each.different]
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return f"DIFFERENT in {names[0]}{more}" if names else comparison.outcome


def _of_step(step: str, show: Show) -> Show:
    """Return what shows how far a step is; each begins anew, so that no time of the step before is shown for it."""
    show(Status(step, 0, 0, None))
    return lambda status: show(replace(status, stage=f"{step}: {status.stage}"))


@contextmanager
def _step(found: Outcome, step: str, say: Say) -> Iterator[None]:
    """Time a step, and keep why it could not be done: the other sweeps go on."""
    began = time.monotonic()
    try:
        yield
    except StoppedError:
        raise
    except RequestError as error:
        found.problems[step] = str(error)
    except MemoryError:
        found.problems[step] = "The memory that this process may use is not enough. Use more memory."
    # a defect in one sweep, or an error of the system, is no reason to lose a night
    except Exception as problem:
        for line in traceback.format_exc().rstrip("\n").split("\n"):
            say(line)
        found.problems[step] = (
            f"This is a defect of eulerdisk, or the system refuses: {type(problem).__name__}: {problem}."
        )
    finally:
        found.seconds[step] = time.monotonic() - began


def _command(sweep: Sweep, path: Path) -> str:
    """Return the command that makes this atlas, for its history."""
    words = (
        ["batch", sweep.file, "-o", str(path.parent)] if sweep.table else ["run", sweep.file, "-o", str(path)]
    )
    return shlex.join(["eulerdisk", *words])


def _other_maker(path: Path, spec: SweepSpec) -> str | None:
    """Return what else made the atlas in a file: empty if a run of a spec would make the same one now.

    As far as can be told; None if there is no atlas.
    """
    if not path.is_file():
        return None
    try:
        with opened(path, indexed=False) as held:
            attributes = held.attrs
    except RequestError:
        # not an atlas, or a damaged one: `run_to_file` says that it is in the way, or replaces it
        return None
    makers = []
    if attributes.get("sweep_fingerprint") != spec.fingerprint():
        makers.append("from another spec")
    if attributes.get("kernel_hash") != arithmetic_hash(spec):
        makers.append("by other code")
    return " and ".join(makers)
