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

#: Possible names of a sweep, which are those of its files.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}")

#: The tables of a file with several sweeps.
_TABLES = SWEEP_TABLES[0]


@dataclass(frozen=True)
class Sweep:
    """One sweep of a batch.

    Parameters
    ----------
    name : str
        That of its atlas, without ``.nc``; empty if it has none that can be that of a file, or another sweep has it.
    file : str
        The preset or the file that it stands in.
    table : int
        Which table of the file it is, from 1; 0 if it is all of it.
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
        """Where it stands, for messages."""
        return f"{self.file}, [[{_TABLES}]] {self.table}" if self.table else self.file

    @property
    def label(self) -> str:
        """Its name in reports: its name, or its place if it has none."""
        return self.name or self.source


def read_sweeps(files: Sequence[str | Path]) -> list[Sweep]:
    """Return the sweeps in files, in their order.

    Parameters
    ----------
    files : sequence of str or Path
        Presets or TOML files. A file with tables ``[[sweep]]`` holds one sweep for each of them; the words above the
        first table hold for all, and each table has a ``name``.

    Raises
    ------
    RequestError
        If there is no sweep, or a word ``NAME=VALUE`` is given. A spec or a name that is wrong is no error here: it is
        the problem of that sweep, and the others can be computed.
    """
    if not files:
        raise RequestError(
            "A batch needs sweeps; none was given.",
            hint="Name spec files, as in: batch sweeps/*.toml -o tonight/.",
        )
    for file in files:
        if "=" in str(file) and Path(file).suffix != ".toml" and not os.path.exists(file):
            raise RequestError(
                f"A batch takes spec files and no words NAME=VALUE; got {shown(str(file))}.",
                hint="Write the word into the spec file, or compute this one sweep with eulerdisk run.",
            )
    known: dict[str, Sweep] = {}
    return [_named(each, known) for file in files for each in _in_file(file)]


def _named(sweep: Sweep, known: dict[str, Sweep]) -> Sweep:
    """Return a sweep that keeps its name if no file of another has it; else with no name, and with the reason."""
    if not _NAME.fullmatch(sweep.name):
        problem = RequestError(
            f"The name of a sweep becomes that of a file: letters, digits and . _ + - of ASCII, at most 100; got "
            f"{shown(sweep.name) or 'none'}.",
            hint='Write name = "hoop" in its table.' if sweep.table else "Rename the file.",
            where=sweep.source,
        )
        return replace(sweep, name="", spec=None, problem=sweep.problem or str(problem))
    # file systems may not tell upper and lower case apart
    other = known.setdefault(sweep.name.lower(), sweep)
    if other is sweep:
        return sweep
    problem = RequestError(
        f"Two sweeps have the name {sweep.name}, and would have one file; the other is in {other.source}.",
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
    misspelt = [each for each in SWEEP_TABLES[1:] if isinstance(words.get(each), list)]
    tables = words.pop(_TABLES, None)
    if misspelt:
        problem = f"{file}: tables of sweeps are written [[{_TABLES}]]; got [[{misspelt[0]}]]."
        yield Sweep(name, file, problem=problem)
    elif tables is None:
        yield _read(Sweep(name, file), path, words, {})
    elif isinstance(tables, list) and tables and all(isinstance(each, dict) for each in tables):
        for number, table in enumerate(tables, 1):
            own = {str(key): value for key, value in table.items() if key != "name"}
            name = table.get("name", "")
            yield _read(Sweep(name if isinstance(name, str) else "", file, number), path, words, own)
    else:
        yield Sweep(name, file, problem=f"{file}: {_TABLES} must be tables, each written [[{_TABLES}]].")


def _no_file(file: str) -> RequestError | None:
    """Return what is wrong with a name that is that of a folder, or a pattern that the shell found no file for."""
    if os.path.isdir(file):
        return RequestError(
            "This is a folder; a batch takes the files in it.",
            hint=f"Write {shlex.quote(file.rstrip('/'))}/*.toml.",
            where=file,
        )
    if any(each in file for each in "*?["):
        return RequestError(
            "There is no such file: no name fits this pattern.",
            hint="Check the pattern; the names of spec files end in .toml.",
            where=file,
        )
    return None


def _read(sweep: Sweep, path: Path, words: Mapping[str, Any], own: Mapping[str, Any]) -> Sweep:
    """Return a sweep with the spec that the words of its file and its own ones make, or with why they make none."""
    try:
        own = with_system(with_table(own, path.parent), path.parent)
        words = with_system(words, path.parent)
        words = words if "starts" in own else with_table(words, path.parent)
        model = model_for({**words, **own}.get("model"), (*given_in(words), *given_in(own)))
        return replace(sweep, spec=SweepSpec(**changed(words, own, model)))
    except RequestError as error:
        where = f"{sweep.source}: {error.where}" if error.where else sweep.source
        return replace(sweep, problem=str(error.at(where)))
