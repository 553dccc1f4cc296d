"""Execution of a batch: each sweep is computed, verified and compared; a failure in one sweep does not stop others."""

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
        COMPUTED; KEPT: it existed already, made from this spec by this code; REFUSED: the request was wrong;
        FAILED: the atlas could not be made.
    failures : Failures or None
        The cells that could not be computed.
    findings : Findings or None
        The audit, if requested.
    comparison : Comparison or None
        The comparison with the trusted atlas, if requested.
    problems : dict of str to str
        Step (``run``, ``verify``, ``compare``) -> its problem.
    seconds : dict of str to float
        Step -> its time.
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
        An existing folder for the atlases.
    verify : bool
        Whether to verify every atlas.
    reference : Path, optional
        A folder of trusted atlases with the same names.
    overwrite : bool
        Whether to replace an atlas that was made from another spec or by other code.
    threads : int, optional
        Number of threads; all if not given.
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
    """Carry out sweeps one after the other, and yield the outcome of each.

    Parameters
    ----------
    sweeps : sequence of Sweep
    options : Options
    show, say, stopping
        As in `sweep.runs.run.run_to_file`.

    Raises
    ------
    StoppedError
        If `stopping` returned true. Finished atlases and blocks are kept; the same call continues.
    """
    for number, sweep in enumerate(sweeps):
        if stopping():
            raise StoppedError(f"{counted(number, 'sweep', len(sweeps))} {are(number)} finished")
        show(Status("compiling the kernels", 0, 0, None))
        outcome = Outcome(sweep, options.folder / f"{sweep.name}.nc")
        if sweep.spec is None:
            outcome.state, outcome.problems["run"] = REFUSED, sweep.problem
            yield outcome
            continue
        with _step(outcome, "run", say):
            _compute(outcome, sweep.spec, options, show, say, stopping)
        if options.verify and outcome.state != FAILED:
            with _step(outcome, "verify", say):
                _verify(outcome, _show_step("verify", show))
        if options.reference is not None and outcome.state != FAILED:
            with _step(outcome, "compare", say):
                _compare(outcome, options.reference / outcome.path.name, _show_step("compare", show))
        yield outcome


def _compute(
    outcome: Outcome, spec: SweepSpec, options: Options, show: Show, say: Say, stopping: Stopping
) -> None:
    other = _other_maker(outcome.path, spec)
    if other == "":
        outcome.failures, outcome.state = Failures.in_file(outcome.path, spec), KEPT
    elif other and not options.overwrite:
        raise RequestError(
            f"This atlas exists already and was made {other}; it was not replaced.",
            hint="To replace it, add --overwrite; to keep it, name another folder.",
            where=str(outcome.path),
        )
    else:
        for warning in one_sided(spec):
            say(f"warning: {warning}")
        outcome.failures = run_to_file(
            spec,
            outcome.path,
            overwrite=options.overwrite,
            threads=options.threads,
            command=_command(outcome.sweep, outcome.path),
            progress=show,
            say=say,
            stopping=stopping,
        )
        outcome.state = COMPUTED
    if 100.0 * outcome.failures.total > options.max_failed * spec.size:
        outcome.problems["run"] = "; ".join(line.strip() for line in outcome.failures.describe())


def _verify(outcome: Outcome, show: Show) -> None:
    with opened(outcome.path, indexed=False) as atlas:
        outcome.findings = audit = findings_of(atlas, show=show)
    if not audit.passed:
        disagree = are(audit.disagreeing, "disagrees", "disagree")
        wrong = (
            f"; wrong: {', '.join(statement.name for statement in audit.wrong[:6])}" if audit.wrong else ""
        )
        outcome.problems["verify"] = (
            f"{counted(audit.disagreeing, 'cell')} {disagree} with the reference of the model, "
            f"{audit.missing} {are(audit.missing, 'lacks', 'lack')} a value{wrong}, "
            f"{audit.compared} could be compared. "
            f"For details, run {shlex.join(['eulerdisk', 'verify', str(outcome.path)])}"
        )


def _compare(outcome: Outcome, trusted: Path, show: Show) -> None:
    if not os.path.lexists(trusted):
        raise RequestError(
            "The trusted atlas of this sweep is missing.",
            hint="Verify the new atlas with eulerdisk verify, then make it the trusted one: "
            f"{shlex.join(['cp', str(outcome.path), str(trusted)])}",
            where=str(trusted),
        )
    with opened(outcome.path, indexed=False) as new, opened(trusted, indexed=False) as reference:
        try:
            outcome.comparison = compare(new, reference, progress=show)
        except OtherGridError as error:
            # a batch compares whole atlases
            hint = (
                "Undo the change of the spec, or replace the trusted atlas with a verified one of this spec."
            )
            raise RequestError(error.message, hint, str(trusted)) from None
    if not outcome.comparison.same:
        worst = next(finding for finding in outcome.comparison.findings if finding.different)
        command = shlex.join(["eulerdisk", "compare", str(outcome.path), str(trusted)])
        outcome.problems["compare"] = (
            f"{in_one_line(outcome.comparison)}: {what(worst)}. For details, run {command}"
        )


def in_one_line(comparison: Comparison) -> str:
    """Return the outcome of a comparison in a few words."""
    names = [finding.name for finding in comparison.findings if finding.different]
    more = f" and {len(names) - 1} more" if len(names) > 1 else ""
    return f"DIFFERENT in {names[0]}{more}" if names else comparison.outcome


def _show_step(step: str, show: Show) -> Show:
    """Show that a step begins, which clears the time of the step before; return a function that shows its status."""
    show(Status(step, 0, 0, None))
    return lambda status: show(replace(status, stage=f"{step}: {status.stage}"))


@contextmanager
def _step(outcome: Outcome, step: str, say: Say) -> Iterator[None]:
    """Time a step, and record its error, so that the other sweeps continue."""
    began = time.monotonic()
    try:
        yield
    except StoppedError:
        raise
    except RequestError as error:
        outcome.problems[step] = str(error)
    except MemoryError:
        outcome.problems[step] = "The memory of this process is not enough. Use more memory."
    # a defect in one sweep, or an error of the system, should not waste a whole night
    except Exception as problem:
        for line in traceback.format_exc().rstrip("\n").split("\n"):
            say(line)
        outcome.problems[step] = (
            f"This is a defect of eulerdisk, or an error of the system: {type(problem).__name__}: {problem}."
        )
    finally:
        outcome.seconds[step] = time.monotonic() - began


def _command(sweep: Sweep, path: Path) -> str:
    """Return the command that makes this atlas, for its history."""
    words = (
        ["batch", sweep.file, "-o", str(path.parent)] if sweep.table else ["run", sweep.file, "-o", str(path)]
    )
    return shlex.join(["eulerdisk", *words])


def _other_maker(path: Path, spec: SweepSpec) -> str | None:
    """Return what differs from this spec and code in the origin of an existing atlas; empty if nothing seems to.

    None if there is no atlas.
    """
    if not path.is_file():
        return None
    try:
        with opened(path, indexed=False) as atlas:
            attributes = atlas.attrs
    except RequestError:
        # not an atlas, or a damaged one: `run_to_file` refuses or replaces it
        return None
    makers = []
    if attributes.get("sweep_fingerprint") != spec.fingerprint():
        makers.append("from another spec")
    if attributes.get("kernel_hash") != arithmetic_hash(spec):
        makers.append("by other code")
    return " and ".join(makers)
