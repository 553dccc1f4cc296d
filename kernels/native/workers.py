"""The threads that kernels run in."""

import threading
from concurrent.futures import Future, ThreadPoolExecutor

_chosen = threading.local()
_usual = 1


def use(threads):
    """Let kernels that this Python thread calls run in so many threads, itself among them."""
    _chosen.threads = threads


def use_usually(threads):
    """Let kernels run in so many threads where a Python thread has chosen none."""
    global _usual
    _usual = threads


def used():
    """Return how many threads the kernels use that this Python thread calls: chosen, or usual."""
    return getattr(_chosen, "threads", 0) or _usual


def run(work, most):
    """Call `work` in as many threads as were chosen, `most` at most, at once; returns when all have returned.

    The threads are made anew each time: those of a pool would be missing in a process that was forked.
    """
    others = min(used(), most) - 1
    if others < 1:
        work()
        return
    with ThreadPoolExecutor(others) as pool:
        started: list[Future[None]] = []
        for _ in range(others):
            try:
                started.append(pool.submit(work))
            except RuntimeError:
                # the system has no more threads: those that there are do all the work
                break
        work()
        for each in started:
            each.result()
