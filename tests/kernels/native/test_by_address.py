"""An entry point that compiled code calls by its address gets what it was given, and nothing else."""

import numpy as np
import pytest
from numba.core.errors import TypingError

from kernels.native.by_address import NOWHERE, address_of, caller_of
from kernels.native.entry import entry


@entry(factor="int64", shift="float64", given="float64[:, ::1]", found="float64[:, ::1], written")
def scaled(factor, shift, given, found):
    """Scale and shift numbers."""
    for i in range(given.shape[0]):
        for j in range(given.shape[1]):
            found[i, j] = factor * given[i, j] + shift


call = caller_of(scaled)


@entry(address="int64", given="float64[:, ::1]", found="float64[:, ::1], written")
def twice(address, given, found):
    """Call the other entry point two times, if there is one."""
    if address != 0:
        call(address, 3, 0.5, given, found)
        call(address, 2, 0.25, found, found)


@entry(address="int64", given="float64[:, ::1]")
def wrong(address, given):
    """Call the other entry point with too little."""
    call(address, 3, 0.5, given)


def test_the_function_at_the_address_is_called():
    """Numbers and arrays of both calls arrive."""
    given = np.arange(6.0).reshape(2, 3)
    found = np.zeros_like(given)
    twice(address_of(scaled), given, found)
    np.testing.assert_array_equal(found, 2 * (3 * given + 0.5) + 0.25)


def test_no_address_is_called_where_there_is_none():
    """NOWHERE is an address that compiled code can tell from all others."""
    given = np.ones((2, 2))
    found = np.zeros_like(given)
    twice(NOWHERE, given, found)
    assert not found.any()


def test_other_arguments_are_refused_when_the_caller_is_compiled():
    """A call with arguments of other types would read other memory."""
    with pytest.raises(TypingError, match="scaled takes"):
        wrong(address_of(scaled), np.ones((2, 2)))
