"""The sweeps of a batch: one for each spec file, or one for each table ``[[sweep]]`` of a file."""

import os
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sweep.errors import RequestError, shown
from sweep.request.spec import SweepSpec
from sweep.request.spec_file import SWEEP_TABLES, find_spec_file, read_file
from sweep.request.substitutes import changed
from sweep.request.system_model import with_system
from sweep.request.words import given_in, model_for, with_table

#: Allowed names of a sweep, which are also names of its files.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}")

#: The name of the tables in a file with several sweeps.
_TABLES = SWEEP_TABLES[0]


@dataclass(frozen=True)
class Sweep:
    """One sweep of a batch.

    Parameters
    ----------
    name : str
        The name of its atlas without ``.nc``; empty if the name is not allowed or another sweep has it.
    file : str
        Its preset or file.
    table : int
        Index of its table in the file, from 1; 0 if the file has no tables.
    spec : SweepSpec or None
    problem : str
        Why there is no spec, in a sentence; empty if there is one.
    """

    name: str
    file: str
    table: int = 0
    spec: SweepSpec | None = None
    problem: str = ""

    @property
    def source(self) -> str:
        """Its file and table, for messages."""
        return f"{self.file}, [[{_TABLES}]] {self.table}" if self.table else self.file

    @property
    def label(self) -> str:
        """Its name in reports: its own name, or its source if it has none."""
        return self.name or self.source


def read_sweeps(files: Sequence[str | Path]) -> list[Sweep]:
    """Return the sweeps in files, in their order.

    Parameters
    ----------
    files : sequence of str or Path
        Presets or TOML files. A file with tables ``[[sweep]]`` has one sweep for each table; the words above the first
        table apply to all, and each table has a ``name``.

    Raises
    ------
    RequestError
        If there is no sweep, or a word ``NAME=VALUE`` is given. A wrong spec or name raises no error: it is recorded as
        the problem of that sweep, and the others can be computed.
    """
    if not files:
        raise RequestError(
            "A batch needs sweeps; none was given.",
            hint="Name spec files, for example: batch sweeps/*.toml -o tonight/.",
        )
    for file in files:
        if "=" in str(file) and Path(file).suffix != ".toml" and not os.path.exists(file):
            raise RequestError(
                f"A batch takes spec files, not words NAME=VALUE; got {shown(str(file))}.",
                hint="Write the word into the spec file, or compute this one sweep with eulerdisk run.",
            )
    known: dict[str, Sweep] = {}
    return [_check_name(sweep, known) for file in files for sweep in _in_file(file)]


def _check_name(sweep: Sweep, known: dict[str, Sweep]) -> Sweep:
    """Return a sweep if its name is allowed and new; otherwise the sweep without a name, and with the problem."""
    if not _NAME.fullmatch(sweep.name):
        problem = RequestError(
            f"The name of a sweep is also a file name: at most 100 ASCII letters, digits and . _ + -; got "
            f"{shown(sweep.name) or 'none'}.",
            hint='Write name = "hoop" in its table.' if sweep.table else "Rename the file.",
            where=sweep.source,
        )
        return replace(sweep, name="", spec=None, problem=sweep.problem or str(problem))
    # some file systems do not distinguish upper and lower case
    other = known.setdefault(sweep.name.lower(), sweep)
    if other is sweep:
        return sweep
    problem = RequestError(
        f"Two sweeps have the name {sweep.name} and would have the same file; the other is in {other.source}.",
        hint="Give one of them another name.",
        where=sweep.source,
    )
    return replace(sweep, name="", spec=None, problem=sweep.problem or str(problem))


def _in_file(given: str | Path) -> Iterator[Sweep]:
    name, file = Path(given).stem, str(given)
    try:
        path = find_spec_file(given)
        words = read_file(path)
    except RequestError as error:
        yield Sweep(name, file, problem=str(_no_file(file) or error))
        return
    misspelt = [name for name in SWEEP_TABLES[1:] if isinstance(words.get(name), list)]
    tables = words.pop(_TABLES, None)
    if misspelt:
        problem = f"{file}: the tables of sweeps must be [[{_TABLES}]]; got [[{misspelt[0]}]]."
        yield Sweep(name, file, problem=problem)
    elif tables is None:
        yield _read(Sweep(name, file), path, words, {})
    elif isinstance(tables, list) and tables and all(isinstance(table, dict) for table in tables):
        for number, table in enumerate(tables, 1):
            own = {str(key): value for key, value in table.items() if key != "name"}
            name = table.get("name", "")
            yield _read(Sweep(name if isinstance(name, str) else "", file, number), path, words, own)
    else:
        yield Sweep(
            name, file, problem=f"{file}: {_TABLES} must be tables, each with the head [[{_TABLES}]]."
        )


def _no_file(file: str) -> RequestError | None:
    """Return the error for a folder, or for a pattern that matched no file; None for other names."""
    if os.path.isdir(file):
        return RequestError(
            "This is a folder; a batch needs the files in it.",
            hint=f"Write {shlex.quote(file.rstrip('/'))}/*.toml.",
            where=file,
        )
    if any(wildcard in file for wildcard in "*?["):
        return RequestError(
            "There is no such file: no name matches this pattern.",
            hint="Check the pattern; the names of spec files end in .toml.",
            where=file,
        )
    return None


def _read(sweep: Sweep, path: Path, words: Mapping[str, Any], own: Mapping[str, Any]) -> Sweep:
    """Return a sweep with the spec from the words of its file and its own table, or with the problem of the words."""
    try:
        own = with_system(with_table(own, path.parent), path.parent)
        words = with_system(words, path.parent)
        words = words if "starts" in own else with_table(words, path.parent)
        model = model_for({**words, **own}.get("model"), (*given_in(words), *given_in(own)))
        return replace(sweep, spec=SweepSpec(**changed(words, own, model)))
    except RequestError as error:
        where = f"{sweep.source}: {error.where}" if error.where else sweep.source
        return replace(sweep, problem=str(error.at(where)))
