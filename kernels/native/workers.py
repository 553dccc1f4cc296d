"""The threads in which kernels run."""

import threading
from concurrent.futures import Future, ThreadPoolExecutor

_chosen = threading.local()
_usual = 1


def use(threads):
    """Set the number of threads for kernels that this Python thread calls, including this thread."""
    _chosen.threads = threads


def use_usually(threads):
    """Set the default number of threads, for Python threads that have not set their own."""
    global _usual
    _usual = threads


def used():
    """Return the number of threads for kernels that this Python thread calls."""
    return getattr(_chosen, "threads", 0) or _usual


def run(work, most):
    """Call `work` in the chosen number of threads at once, at most `most`; return when all calls have returned.

    New threads are started each time, because the threads of a pool would be missing in a forked process.
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
                # the system has no more threads: the existing ones do all the work
                break
        work()
        for each in started:
            each.result()
