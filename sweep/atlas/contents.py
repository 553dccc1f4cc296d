"""What a reader of an atlas needs of it: an `xarray.Dataset` has it, and so has an open file without xarray.

Loading xarray takes three times as long as loading numpy and netCDF4 together. Checks, reports and figures are written
against these two protocols, so that a command that only looks into a file need not wait for it.
"""

from collections.abc import Mapping
from typing import Any, Protocol

import numpy.typing as npt


class Variable(Protocol):
    """Values on named dimensions, missing ones NaN; ``variable[key]`` reads a part of them."""

    @property
    def dims(self) -> tuple[Any, ...]:
        """Names of the dimensions."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each dimension."""

    @property
    def dtype(self) -> Any:
        """Type of the values."""

    @property
    def attrs(self) -> Mapping[Any, Any]:
        """The attributes, without those of `encoding`."""

    @property
    def encoding(self) -> Mapping[Any, Any]:
        """How the values are stored: ``_FillValue``, ``scale_factor`` and the like."""

    @property
    def values(self) -> npt.NDArray[Any]:
        """All values, read when they are first asked for."""

    def __getitem__(self, key: Any, /) -> Any: ...


class Atlas(Protocol):
    """Variables by their names, and global attributes."""

    @property
    def attrs(self) -> Mapping[Any, Any]:
        """The global attributes."""

    @property
    def encoding(self) -> Mapping[Any, Any]:
        """``source`` is the file, if there is one."""

    @property
    def sizes(self) -> Mapping[Any, int]:
        """Number of values along each dimension."""

    @property
    def variables(self) -> Mapping[Any, Variable]:
        """All variables, coordinates included."""

    def __contains__(self, name: object, /) -> bool: ...

    def __getitem__(self, name: str, /) -> Variable: ...
