"""The sweeps of a batch: one for each spec file, or one for each table ``[[sweep]]`` of a file."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from sweep.errors import RequestError, shown
from sweep.model import registry
from sweep.request.spec import SweepSpec
from sweep.request.substitutes import changed
from sweep.request.words import find_spec_file, read_file

#: What the name of a sweep may be: that of its files.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,99}")

#: The tables of a file with several sweeps.
_TABLES = "sweep"


@dataclass(frozen=True)
class Sweep:
    """One sweep of a batch.

    Parameters
    ----------
    name : str
        That of its atlas, without ``.nc``.
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
        If there is no sweep, a name cannot be that of a file, or two sweeps have one name. A spec that is wrong is no
        error here: the others can be computed.
    """
    sweeps = [each for file in files for each in _in_file(file)]
    if not sweeps:
        raise RequestError(
            "A batch needs sweeps; none was given.",
            hint="Name spec files, as in: batch sweeps/*.toml -o tonight/.",
        )
    known: dict[str, Sweep] = {}
    for each in sweeps:
        if not _NAME.fullmatch(each.name):
            raise RequestError(
                f"The name of a sweep becomes that of a file: letters, digits and . _ + - of ASCII, at most 100; got "
                f"{shown(each.name) or 'none'}.",
                hint='Write name = "hoop" in its table, or rename the file.',
                where=each.source,
            )
        # file systems may not tell upper and lower case apart
        other = known.setdefault(each.name.lower(), each)
        if other is not each:
            raise RequestError(
                f"Two sweeps have the name {each.name}, and would have one file; the other is in {other.source}.",
                hint="Give one of them another name.",
                where=each.source,
            )
    return sweeps


def _in_file(given: str | Path) -> Iterator[Sweep]:
    name, file = Path(given).stem, str(given)
    try:
        words = read_file(find_spec_file(given))
    except RequestError as error:
        yield Sweep(name, file, problem=str(error))
        return
    tables = words.pop(_TABLES, None)
    if tables is None:
        yield _read(Sweep(name, file), words, {})
    elif isinstance(tables, list) and tables and all(isinstance(each, dict) for each in tables):
        for number, table in enumerate(tables, 1):
            own = {str(key): value for key, value in table.items() if key != "name"}
            name = table.get("name", "")
            yield _read(Sweep(name if isinstance(name, str) else "", file, number), words, own)
    else:
        yield Sweep(name, file, problem=f"{file}: {_TABLES} must be tables, each written [[{_TABLES}]].")


def _read(sweep: Sweep, words: Mapping[str, Any], own: Mapping[str, Any]) -> Sweep:
    """Return a sweep with the spec that the words of its file and its own ones make, or with why they make none."""
    try:
        model = registry.named(str({**words, **own}.get("model", registry.DEFAULT)))
        return replace(sweep, spec=SweepSpec(**changed(words, own, model)))
    except RequestError as error:
        where = f"{sweep.source}: {error.where}" if error.where else sweep.source
        return replace(sweep, problem=str(error.at(where)))
