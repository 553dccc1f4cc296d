"""An atlas whose values are read by one thread at a time, whatever is done with them between two reads."""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import numpy.typing as npt

from sweep.atlas.contents import Atlas, Variable

#: Returns a context that waits until nobody else reads.
_Turn = Callable[[], AbstractContextManager[None]]


class OneReader:
    """An atlas as `sweep.atlas.contents.Atlas` describes it, each read of which waits for its turn.

    Parameters
    ----------
    atlas : Atlas
    turn : callable
        Returns a context that waits until nobody else reads.
    """

    def __init__(self, atlas: Atlas, turn: _Turn) -> None:
        self._atlas = atlas
        self.attrs, self.encoding, self.sizes = atlas.attrs, atlas.encoding, atlas.sizes
        self.variables: Mapping[Any, Variable] = {
            name: _Variable(variable, turn) for name, variable in atlas.variables.items()
        }

    def __contains__(self, name: object, /) -> bool:
        return name in self.variables

    def __getitem__(self, name: str, /) -> Variable:
        return self.variables[name]


class _Variable:
    """A variable, each read of which waits for its turn."""

    def __init__(self, variable: Variable, turn: _Turn) -> None:
        self._variable, self._turn = variable, turn
        self.dims, self.shape, self.dtype = variable.dims, variable.shape, variable.dtype
        self.attrs, self.encoding = variable.attrs, variable.encoding

    @property
    def values(self) -> npt.NDArray[Any]:
        found: npt.NDArray[Any] = self[...]
        return found

    def __getitem__(self, key: Any, /) -> Any:
        with self._turn():
            # a lazy variable would be read later, by whoever looks at it
            return np.asarray(self._variable[key])
