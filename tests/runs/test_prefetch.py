"""A generator that runs ahead in a thread: same items, exceptions in place, clean on early exit."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from sweep.runs.executor import prefetch


def test_the_items_in_order_from_one_other_thread():
    """Every item comes once, in order; one thread, not the consumer's, makes them all."""
    threads = set()

    def items():
        for i in range(100):
            threads.add(threading.current_thread())
            yield i

    with prefetch(items()) as taken:
        assert list(taken) == list(range(100))
    assert len(threads) == 1
    assert threading.current_thread() not in threads


def test_both_sides_work_at_the_same_time():
    """While the consumer works on an item, at most two further ones are made, which bounds the memory."""
    made = []

    def items():
        for i in range(10):
            made.append(i)
            yield i

    with prefetch(items()) as taken:
        assert next(taken) == 0
        deadline = time.monotonic() + 10
        while len(made) < 3 and time.monotonic() < deadline:
            time.sleep(0.001)
        time.sleep(0.05)
        assert made == [0, 1, 2]


@pytest.mark.parametrize("problem", [ValueError("a defect"), KeyboardInterrupt(), StopIteration()])
def test_an_exception_arrives_where_its_item_would_be_taken(problem):
    """Earlier items are delivered; then the consumer gets the exception, and nothing hangs."""

    def items():
        yield 1
        yield 2
        raise problem

    taken = []
    # A generator cannot raise StopIteration: Python turns it into a RuntimeError.
    expected = RuntimeError if isinstance(problem, StopIteration) else type(problem)
    with pytest.raises(expected), prefetch(items()) as ahead:
        taken.extend(iter(lambda: next(ahead), None))
    assert len(taken) <= 2


@pytest.mark.parametrize("problem", [ValueError("a defect"), KeyboardInterrupt()])
def test_leaving_early_closes_the_generator(monkeypatch, problem):
    """The consumer's exception propagates; the current item is finished, no other is begun, the thread ends."""
    begun, finished, closed, threads = [], [], [], []
    # Item 1 is in progress from when the consumer leaves until the waiting items are canceled.
    in_the_making, cancelled = threading.Event(), threading.Event()

    class Pool(ThreadPoolExecutor):
        def shutdown(self, **how):
            super().shutdown(**{**how, "wait": False})
            cancelled.set()
            super().shutdown()

    def items():
        threads.append(threading.current_thread())
        try:
            for i in range(1000):
                begun.append(i)
                if i == 1:
                    in_the_making.set()
                    assert cancelled.wait(60)
                finished.append(i)
                yield i
        finally:
            closed.append(True)

    def consume():
        with prefetch(items()) as taken:
            next(taken)
            assert in_the_making.wait(60)
            raise problem

    monkeypatch.setattr("sweep.runs.executor.ThreadPoolExecutor", Pool)
    with pytest.raises(type(problem)):
        consume()
    assert closed == [True]
    assert begun == finished == [0, 1]
    assert not any(each.is_alive() for each in threads)
