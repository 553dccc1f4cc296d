"""SIGINT becomes a request to stop, and the stop an interrupt that says what is kept; others stay as they are."""

import os
import signal

import pytest

from sweep.errors import StoppedError
from sweep.runs.executor import interruptible


def test_an_interrupt_is_a_request_to_stop():
    """The work goes on to the end of its block; the KeyboardInterrupt has the words of what stopped it."""

    def work():
        with interruptible() as stopping:
            assert not stopping()
            os.kill(os.getpid(), signal.SIGINT)
            assert stopping()
            raise StoppedError("3 blocks are kept")

    with pytest.raises(
        KeyboardInterrupt, match=r"^3 blocks are kept\. To go on, give the same call again\.$"
    ):
        work()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_stop_without_an_interrupt_is_none():
    """An executor that ends early is no key that somebody has pressed."""
    with pytest.raises(StoppedError, match="no block was finished"), interruptible():
        raise StoppedError("no block was finished")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_second_interrupt_does_not_wait():
    """It raises where it arrives."""
    reached = []

    def work():
        with interruptible():
            for number in range(2):
                os.kill(os.getpid(), signal.SIGINT)
                reached.append(number)

    with pytest.raises(KeyboardInterrupt):
        work()
    assert reached == [0]


def test_a_caller_that_says_itself_when_to_stop_keeps_its_signals():
    """Its function is used as it is, and Python's own handler stays."""

    def mine():
        return True

    with interruptible(mine) as stopping:
        assert stopping is mine
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_that_nothing_heeds_is_not_lost():
    """Work that ends without asking is followed by the interrupt."""
    with pytest.raises(KeyboardInterrupt, match="all was done"), interruptible():
        os.kill(os.getpid(), signal.SIGINT)
