"""Tables of starts: the columns of a CSV file, a mapping or a data frame.

The canonical text of a request contains the names of the columns, the number of starts and a SHA-256 of the values. The
values themselves are in memory, in the folder of a run, or in the file of an atlas: a table read from a canonical text
has no values until `filled` adds them.
"""

import csv
import hashlib
import io
import re
from array import array
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, are, counted, shown
from sweep.model.description import Model
from sweep.model.quantity import Array, Input, Quantity
from sweep.request.sources import Range, Values
from sweep.request.spec_file import read_regular
from sweep.request.suggestions import unknown_word
from sweep.request.units import factor_to_si
from sweep.request.values import in_unit, rule_in

#: Largest number of rows, and of bytes of a CSV file.
_MOST_ROWS, _MOST_BYTES = 10_000_000, 2**30

#: The head of a column: a name, and a unit in brackets or after a blank.
_HEAD = re.compile(r"\s*([^\s\[(]+)\s*(?:\[([^\]]*)\]|\(([^)]*)\)|([^\[\](]*))\s*")


@dataclass(frozen=True)
class StartTable:
    """A table of starts.

    Parameters
    ----------
    names : tuple of str
        The parameters with a column, in the order of the model.
    numbers : Range or Values
        The numbers of the starts.
    sha256 : str
        The SHA-256 of the values: little-endian doubles, one parameter after the other.
    columns : mapping of str to array, shape (n,), optional
        The values, in SI. Comparisons of tables ignore them.
    """

    names: tuple[str, ...]
    numbers: Range | Values
    sha256: str
    columns: Mapping[str, Array] | None = field(default=None, compare=False, repr=False)

    @classmethod
    def of(cls, columns: Mapping[str, Array], numbers: Range | Values | None = None) -> Self:
        """Return the table of some values [SI], numbered from 0 by default."""
        held = {name: np.ascontiguousarray(values, np.float64) + 0.0 for name, values in columns.items()}
        for values in held.values():
            values.setflags(write=False)
        count = next(iter(held.values())).size
        every = Range(0.0, count - 1.0, count)
        return cls(tuple(held), numbers or every, _digest(held.values()), held)

    def __len__(self) -> int:
        """Return the number of starts."""
        return len(self.numbers)

    def __str__(self) -> str:
        """Return the description of the table for use in messages."""
        return f"{counted(len(self), 'start')} of {', '.join(self.names)} (SHA-256 {self.sha256[:12]})"

    def values(self, name: str) -> Array:
        """Return the values of a parameter, shape (n,).

        Raises
        ------
        RequestError
            If the table has no values, because it was read from a canonical text.
        """
        if self.columns is None:
            raise RequestError(
                f"The values of these starts are missing: {self}. A spec contains only their SHA-256.",
                hint="Take the spec from the atlas (dataset.eulerdisk.spec), or give the table again.",
                where="starts",
            )
        return self.columns[name]

    def filled(self, columns: Mapping[str, npt.ArrayLike]) -> Self:
        """Return this table with its values.

        Raises
        ------
        RequestError
            If they are not the values of this table.
        """
        given = {name: np.asarray(columns[name], np.float64) for name in self.names}
        found = type(self).of(given, self.numbers)
        if found.sha256 == self.sha256 and all(values.shape == (len(self),) for values in given.values()):
            return found
        raise RequestError(
            f"The values of {', '.join(self.names)} are not the original ones: their SHA-256 begins with "
            f"{found.sha256[:12]}, not with {self.sha256[:12]}.",
            hint="Take an undamaged copy, or run again with the table.",
            where="starts",
        )

    def part(self, numbers: Range | Values) -> Self:
        """Return the part of the table with some start numbers; the starts keep their numbers.

        Raises
        ------
        RequestError
            If the table has no start with one of the numbers.
        """
        wanted, there = numbers.array(), self.numbers.array()
        places = np.minimum(np.searchsorted(there, wanted), there.size - 1)
        if (missing := wanted[there[places] != wanted]).size:
            raise RequestError(
                f"There is no start {missing[0]:g}: the table has {self}, numbered from {there[0]:g} to {there[-1]:g}.",
                hint="Choose numbers of its starts, or leave start out for all starts.",
                where="start",
            )
        return type(self).of({name: self.values(name)[places] for name in self.names}, numbers)

    def to_bytes(self) -> bytes:
        """Return the bytes of the values, from which the SHA-256 is computed."""
        return b"".join(self.values(name).astype("<f8").tobytes() for name in self.names)

    def from_bytes(self, content: bytes) -> Self:
        """Return this table with its values from `to_bytes`; raise RequestError if they are other values."""
        numbers = np.frombuffer(content[: len(content) // 8 * 8], "<f8")
        if len(content) != 8 * len(self.names) * len(self):
            numbers = np.zeros(len(self.names) * len(self))
        return self.filled(dict(zip(self.names, numbers.reshape(len(self.names), -1), strict=True)))

    def to_json(self) -> dict[str, object]:
        """Return the table in plain types, without values, for a canonical text."""
        every = self.numbers == Range(0.0, len(self) - 1.0, len(self))
        numbers = {} if every else {"numbers": vars(self.numbers)}
        return {"names": list(self.names), "starts": len(self), "sha256": self.sha256, **numbers}

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Self:
        """Return the table from `to_json`, without values; raise ValueError if the content is not a table."""
        names, count, digest = (content.get(key) for key in ("names", "starts", "sha256"))
        if not (isinstance(names, list) and names and all(isinstance(name, str) for name in names)):
            raise ValueError(f"the names of a table's columns are a list of texts; got {shown(names)}")
        if type(count) is not int or not 1 <= count <= _MOST_ROWS:
            raise ValueError(f"a table has 1 to {_MOST_ROWS} starts; got {shown(count)}")
        if not isinstance(digest, str) or not re.fullmatch("[0-9a-f]{64}", digest):
            raise ValueError(f"sha256 is 64 hexadecimal digits; got {shown(digest)}")
        held = content.get("numbers")
        numbers: Range | Values = Range(0.0, count - 1.0, count)
        if held is not None:
            numbers = Range(**held) if "count" in held else Values(**held)
        if len(numbers) != count:
            raise ValueError(f"{counted(count, 'start')} {are(count, 'has', 'have')} {len(numbers)} numbers")
        return cls(tuple(names), numbers, digest)


@dataclass(frozen=True)
class Column:
    """A parameter's column of a table; without the table if it was read from a canonical text."""

    name: str
    table: StartTable | None = None

    def __str__(self) -> str:
        """Return the description of the column in messages."""
        return f"a column of {self.table}"

    def in_words(self, quantity: Quantity) -> str:
        """Return the range of the values in words, in the quantity's display unit."""
        low, high = (quantity.spell(float(each), 6) for each in self.ends())
        return f"from a table, {low} to {high}"

    def ends(self) -> Array:
        """Return the smallest and the largest value, shape (2,); NaN if the table has no values."""
        if self.table is None or self.table.columns is None:
            return np.full(2, np.nan)
        values = self.table.values(self.name)
        return np.array([values.min(), values.max()])

    def at(self, places: npt.NDArray[np.integer]) -> Array:
        """Return the values in some rows of the table, shape of `places`."""
        assert self.table is not None
        found: Array = self.table.values(self.name)[places]
        return found


def _digest(columns: Iterable[Array]) -> str:
    digest = hashlib.sha256()
    for values in columns:
        digest.update(values.astype("<f8").tobytes())
    return digest.hexdigest()


@dataclass(frozen=True)
class GivenTable:
    """Columns as given, before they are matched with the parameters of a model.

    Parameters
    ----------
    heads : tuple of str
    columns : tuple of array, shape (n,)
    place : str
        Name of the table in messages.
    lines : sequence of int, optional
        The line number of each row in the file.
    """

    heads: tuple[str, ...]
    columns: tuple[Array, ...]
    place: str = "starts"
    lines: Sequence[int] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the columns, without their units."""
        found = (_HEAD.fullmatch(head) for head in self.heads)
        return tuple(each[1] for each in found if each)

    def of(self, model: Model) -> StartTable:
        """Return the table of starts for a model.

        Raises
        ------
        RequestError
            If a column is not a parameter, or a value is not finite or not allowed.
        """
        heads = [self._read_head(text, model) for text in self.heads]
        names = [head.quantity.name for head in heads]
        if double := [name for name in names if names.count(name) > 1]:
            raise RequestError(
                f"Each parameter has only one column; {double[0]} has {names.count(double[0])}.",
                hint="Remove all of them except one.",
                where=self.place,
            )
        if not heads:
            raise RequestError(
                "A table of starts has at least one column; got none.",
                "Add a column with a parameter.",
                self.place,
            )
        if not 1 <= self.columns[0].size <= _MOST_ROWS:
            raise RequestError(
                f"A table has 1 to {_MOST_ROWS} starts; got {self.columns[0].size}.",
                "Change the number of rows.",
                self.place,
            )
        held = {}
        for head, given in zip(heads, self.columns, strict=True):
            quantity, values = head.quantity, given * head.factor
            finite = np.isfinite(values)
            good = finite & quantity.allows(np.where(finite, values, 0.0))
            if not good.all():
                first = int(np.argmin(good))
                what = f"a finite number; got {given[first]:g}"
                if finite[first]:
                    got = in_unit(float(values[first]), quantity, head.unit)
                    what = f"possible, {rule_in(quantity, head.unit)}; got {got}"
                place = f"{head.text}, start {first}"
                if self.lines is not None:
                    place = f"line {self.lines[first]}, column {head.text}"
                raise _bad_value(f"{self.place}: {place}", what)
            held[quantity.name] = values
        return StartTable.of({name: held[name] for name in model.parameters if name in held})

    def _read_head(self, text: str, model: Model) -> "_Head":
        found = _HEAD.fullmatch(text)
        name = found[1] if found else text.strip()
        if found is None or name not in model.parameters:
            try:
                unknown_word(name, tuple(model.parameters), model)
            except RequestError as error:
                raise RequestError(
                    f"{shown(text)!r} is not a column of a table of starts. A column has the name of a parameter, with "
                    f"its unit in brackets if it is not in SI, as in tilt [deg]; parameters are "
                    f"{', '.join(model.parameters)}.",
                    error.hint,
                    self.place,
                ) from None
        quantity = model.parameters[name]
        unit = next((part.strip() for part in found.groups()[1:] if part), "")
        unit = "" if unit in ("1", "-") and quantity.units == "1" else unit
        try:
            return _Head(quantity, factor_to_si(unit, quantity), text.strip(), unit)
        except RequestError as error:
            raise error.at(f"{self.place}: column {shown(text)}") from None


class _Head(NamedTuple):
    """A column: its parameter, the factor to SI, and its name in messages."""

    quantity: Input
    factor: float
    text: str
    unit: str


def _bad_value(place: str, what: str) -> RequestError:
    return RequestError(
        f"The value must be {what}.",
        hint="Correct it. The head of a column gives its unit, as in tilt [deg]; without a unit it is in SI.",
        where=place,
    )


def read_table(raw: object) -> GivenTable | StartTable | None:
    """Return the given table of starts; None if none was given.

    Parameters
    ----------
    raw : StartTable, str, Path, or mapping of str to array
        A CSV file, or columns of equal length; a pandas.DataFrame is also a mapping. Columns have the names of
        parameters, with a unit in brackets (``tilt [deg]``) if they are not in SI. An xarray.DataArray may have its
        unit in the attribute ``units``.

    Raises
    ------
    RequestError
        If the file cannot be read, or the columns are not numeric or not equally long.
    """
    if isinstance(raw, StartTable | GivenTable):
        return raw
    # arrays and data frames have no truth value
    if raw is None or (isinstance(raw, str) and not raw.strip()):
        return None
    if isinstance(raw, str | Path):
        return _read_csv(Path(raw))
    if not isinstance(raw, type) and hasattr(raw, "keys") and hasattr(raw, "__getitem__"):
        return _read_columns(raw)
    raise RequestError(
        f"starts is a CSV file, or columns in a mapping of names to arrays; got {shown(raw)}.",
        hint='Write starts="table.csv", or starts={"tilt": [0.01, 0.02]}.',
        where="starts",
    )


def table_for(words: Mapping[str, Any], model: Model) -> dict[str, Any]:
    """Return words in which the table of starts, if given, is matched with a model."""
    table = words.get("starts")
    return {**words, "starts": table.of(model)} if isinstance(table, GivenTable) else {**words}


def _read_columns(raw: Any) -> GivenTable:
    heads, columns = list[str](), list[Array]()
    for name in raw.keys():  # noqa: SIM118 - for data frames and datasets alike
        units = getattr(raw[name], "attrs", {}).get("units")
        bare = isinstance(units, str) and str(name).isidentifier()
        heads.append(f"{name} [{units}]" if bare else str(name))
        try:
            values = np.asarray(raw[name])
        except ValueError:
            values = np.asarray("rows of unlike length")
        if masked := np.count_nonzero(raw[name].mask) if isinstance(raw[name], np.ma.MaskedArray) else 0:
            raise _bad_value(f"starts: {name}", f"present in every start; got {masked} masked values")
        if values.ndim != 1 or values.dtype.kind not in "fiu":
            raise _bad_value(
                f"starts: {name}", f"a column of numbers; got {values.dtype} of shape {values.shape}"
            )
        columns.append(values.astype(np.float64))
    if len({values.size for values in columns}) > 1:
        listed = ", ".join(f"{head} {values.size}" for head, values in zip(heads, columns, strict=True))
        raise RequestError(
            f"Columns must be equally long; got {listed}.", "Give every start all values.", "starts"
        )
    return GivenTable(tuple(heads), tuple(columns))


def _read_csv(path: Path) -> GivenTable:
    # the numbers of all rows, and the line number of each row
    heads, numbers, lines, separator = list[str](), array("d"), array("q"), ","
    try:
        text = io.StringIO(read_regular(path, _MOST_BYTES).decode("utf-8-sig"), newline="")
        for line, row in enumerate(text, 1):
            if not row.strip() or row.startswith("#"):
                continue
            if not heads:
                separator = next((each for each in ",;\t" if each in row), ",")
            cells = next(csv.reader([row], delimiter=separator, strict=True))
            if not heads:
                heads = cells
                continue
            numbers.extend(_numbers_of(cells, heads, f"{path}: line {line}"))
            lines.append(line)
    except (csv.Error, UnicodeDecodeError) as problem:
        raise RequestError(
            f"The table of starts is not a CSV file in UTF-8: {problem}.",
            hint="Write one line for each start, with commas between the numbers.",
            where=str(path),
        ) from problem
    except (OSError, ValueError) as problem:
        # a name with a NUL is a ValueError
        reason = getattr(problem, "strerror", None) or str(problem)
        raise RequestError(
            f"The table of starts cannot be read: {reason}.",
            hint="Check the path: a table is a CSV file whose first line names the columns.",
            where=str(path),
        ) from problem
    columns = np.frombuffer(numbers).reshape(-1, len(heads)).T if numbers else np.empty((len(heads), 0))
    return GivenTable(tuple(heads), tuple(columns), str(path), lines)


def _numbers_of(row: list[str], heads: list[str], place: str) -> list[float]:
    """Return the numbers of a row, or refuse its first cell that is not a number."""
    if len(row) != len(heads):
        raise RequestError(
            f"Every line must have {counted(len(heads), 'cell')}, like the first; got {len(row)}.",
            hint="Add the missing cells, or remove the extra ones.",
            where=place,
        )
    found = []
    for cell, head in zip(row, heads, strict=True):
        try:
            # float() also accepts digits of other scripts and underscores, which are refused here
            found.append(float(cell if cell.isascii() and "_" not in cell else ""))
        except ValueError:
            what = f"a number; got {shown(cell) or 'nothing'}"
            raise _bad_value(f"{place}, column {head.strip()}", what) from None
    return found
