"""An open netCDF file as xarray would show it, read by netCDF4 alone: a command that looks into it needs no xarray."""

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from sweep.errors import RequestError, shown

#: Attributes that say how values are stored: xarray decodes them too.
_FILLS, _SCALES = ("_FillValue", "missing_value"), ("scale_factor", "add_offset")
_ENCODED = (*_FILLS, *_SCALES, "coordinates")

#: Values over file, in bytes, at most: deflate packs no more than 1032 bytes into one.
_MOST_PACKED = 1032


class FileVariable:
    """A variable of an open file; see `sweep.atlas.contents.Variable`.

    Parameters
    ----------
    stored : netCDF4.Variable
        Of numbers or characters, without automatic masks and scales.

    Raises
    ------
    Errors of netCDF
        If an attribute cannot be read.
    """

    def __init__(self, stored: Any) -> None:
        self._stored = stored
        self._values: npt.NDArray[Any] | None = None
        self.dims: tuple[str, ...] = stored.dimensions
        self.shape: tuple[int, ...] = stored.shape
        self.attrs: dict[str, Any] = {name: stored.getncattr(name) for name in stored.ncattrs()}
        self.encoding = {name: self.attrs.pop(name) for name in _ENCODED if name in self.attrs}
        self._fills = [number for name in _FILLS for number in _numbers(self.encoding, name)]
        self._factor, self._offset = (_numbers(self.encoding, name) for name in _SCALES)
        self.dtype = self._decoded(stored.dtype.newbyteorder("="))

    def _decoded(self, dtype: np.dtype[Any]) -> np.dtype[Any]:
        """Return the type of the values from that in the file: whole numbers that may be missing become floats."""
        if dtype.kind in "iu" and any(name in self.encoding for name in (*_FILLS, *_SCALES)):
            return np.dtype("f4" if dtype.itemsize <= 2 else "f8")
        # xarray writes truths so
        if dtype.kind in "iu" and isinstance(truth := self.attrs.get("dtype"), str) and truth == "bool":
            return np.dtype(bool)
        return dtype

    @property
    def values(self) -> npt.NDArray[Any]:
        """All values; read once."""
        if self._values is None:
            self._values = self[...]
        return self._values

    def __getitem__(self, key: Any) -> npt.NDArray[Any]:
        """Read a part of the values."""
        stored = np.asarray(self._stored[key])
        found = stored.astype(self.dtype)
        if self._fills:
            found[np.isin(stored, self._fills)] = np.nan
        for number in self._factor:
            found *= number
        for number in self._offset:
            found += number
        return found


def _numbers(attributes: Mapping[str, Any], name: str) -> list[Any]:
    """Return the numbers of an attribute; none if there is no such attribute, or if it is text."""
    found = np.atleast_1d(attributes.get(name, []))
    return list(found) if found.dtype.kind in "iuf" else []


class AtlasFile:
    """An open file; see `sweep.atlas.contents.Atlas`. A context manager.

    Parameters
    ----------
    path : Path
        A file that netCDF opens (`sweep.files.trial.check_opens`).

    Attributes
    ----------
    unread : list of str
        Names of the variables that are neither numbers nor characters, which are not among `variables`.

    Raises
    ------
    RequestError
        If a variable has more values than the bytes of the file can hold: a few bytes can declare 2**40 cells, for
        which reading them would ask for memory.
    OSError, RuntimeError and other errors of netCDF
        If the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        import netCDF4

        self.encoding = {"source": str(path.absolute())}
        self.unread: list[str] = []
        self._file = netCDF4.Dataset(path.absolute())
        try:
            self._file.set_auto_maskandscale(False)
            self._file.set_auto_chartostring(False)
            self._check_claims(path)
            self.attrs = {name: self._file.getncattr(name) for name in self._file.ncattrs()}
            self.sizes = {name: len(dimension) for name, dimension in self._file.dimensions.items()}
            self.variables = {
                name: FileVariable(stored)
                for name, stored in self._file.variables.items()
                if name not in self.unread
            }
        except BaseException:
            self._file.close()
            raise

    def _check_claims(self, path: Path) -> None:
        room = path.stat().st_size * _MOST_PACKED + 2**20
        for name, variable in self._file.variables.items():
            kind = variable.datatype
            if not isinstance(kind, np.dtype) or kind.kind not in "iufS":
                self.unread.append(name)
                continue
            room -= math.prod(variable.shape) * kind.itemsize
            if room < 0:
                raise no_atlas(
                    path, f"{shown(name)} has more values than its bytes can hold, of shape {variable.shape}"
                )

    def keep(self, names: Iterable[str]) -> None:
        """Leave out all variables but those named."""
        names = set(names)
        self.variables = {name: found for name, found in self.variables.items() if name in names}

    def close(self) -> None:
        """Close the file; values that have been read stay."""
        self._file.close()

    def __contains__(self, name: object) -> bool:
        return name in self.variables

    def __getitem__(self, name: str) -> FileVariable:
        return self.variables[name]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def no_atlas(path: Path, reason: str) -> RequestError:
    """Return the error of a file that is read and is no atlas."""
    return RequestError(
        f"This file is no stability atlas, or a damaged one: {reason}.",
        hint="Give a file made by eulerdisk run.",
        where=str(path),
    )


class MotionGivenError(RequestError):
    """A file of one motion, given where an atlas is needed."""

    def __init__(self, path: Path) -> None:
        super().__init__(
            "This file holds one motion in time, which eulerdisk simulate has made, and no stability atlas.",
            hint=f"Give a file made by eulerdisk run; eulerdisk info {path.name} tells of the motion.",
            where=str(path),
        )
