"""The blocks of a run on the workers of a dask scheduler; they write into the run's folder, which all of them see."""

import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sweep.engine.runner import available_threads, compute, use_threads
from sweep.errors import FailedBlocksError, RequestError
from sweep.runs.claims import check_same
from sweep.runs.driving import Driver, Kept, Say, Stopping, unheard
from sweep.runs.journal import Journal

#: Seconds within which a scheduler answers.
_PATIENCE = 10

#: Only one thread of a process may be inside the kernels.
_KERNELS = threading.Lock()


def on_cluster(address: str, say: Say = unheard) -> Driver:
    """Return the driver that has blocks computed by the workers of a dask scheduler.

    Parameters
    ----------
    address : str
        For instance ``tcp://host:8786``.
    say : callable
        Called with a sentence if there is nobody who would compute.

    Raises
    ------
    RequestError
        If dask is not installed.
    """
    try:
        import distributed  # noqa: F401 - only to see that it is there
    except ImportError as problem:
        raise RequestError(
            "dask is not installed",
            "--dask needs the package distributed",
            str(problem),
            "pip install 'eulerdisk[dask]', here and on the workers",
            "--dask",
        ) from problem

    def drive(book: Journal, numbers: Sequence[int], stopping: Stopping) -> Iterator[Kept]:
        if numbers:
            client = _connected(address)
            try:
                if not client.scheduler_info()["workers"]:
                    say(f"no worker is there yet; start some with `dask worker {address}`")
                yield from _computed(client, book, numbers, stopping)
            finally:
                client.close()

    return drive


def compute_block(folder: str, fingerprint: str, number: int) -> int:
    """Compute one block and keep it; this is what a worker does.

    Parameters
    ----------
    folder : str
        The run's folder, as the worker sees it.
    fingerprint : str
        That of the run's manifest.
    number : int

    Returns
    -------
    int
        The number.

    Raises
    ------
    RequestError
        If the folder is not that of this run, or this program computes other bits than the one that began it.
    OSError
        If the file system refuses.
    """
    book = Journal.at(Path(folder))
    check_same(book, book.manifest.spec)
    if book.manifest.fingerprint != fingerprint:
        raise RequestError("another run", "workers see the folder of the run", folder, "share the folder")
    with _KERNELS:
        use_threads(_threads())
        columns = compute(book.manifest.spec, book.spans[number])
    book.keep(number, columns)
    return number


def _threads() -> int:
    import numba
    from distributed import get_worker

    # as many as dask lets this worker have, so that several of them share a machine
    return min(int(get_worker().state.nthreads), available_threads(), int(numba.config.NUMBA_NUM_THREADS))


def _connected(address: str) -> Any:
    from distributed import Client
    from distributed.comm import parse_address, parse_host_port

    try:
        scheme, place = parse_address(address)
        if scheme in ("tcp", "tls"):
            # a client that is given less than host and port does not come into being, and takes 20 s to go
            parse_host_port(place)
        return Client(address, timeout=_PATIENCE, set_as_default=False, name="eulerdisk")
    except (OSError, ValueError, TimeoutError) as problem:
        raise RequestError(
            "no dask scheduler answers",
            "--dask takes the address of a running scheduler",
            f"{address}: {problem}",
            "start one with `dask scheduler`, and workers with `dask worker ADDRESS`",
            "--dask",
        ) from problem


def _computed(client: Any, book: Journal, numbers: Sequence[int], stopping: Stopping) -> Iterator[Kept]:
    from distributed import as_completed

    futures = client.map(
        compute_block,
        [str(book.folder.resolve())] * len(numbers),
        [book.manifest.fingerprint] * len(numbers),
        numbers,
        pure=False,
        retries=2,
    )
    asked = dict(zip((future.key for future in futures), numbers, strict=True))
    waiting, failed = as_completed(futures, loop=client.loop), dict[int, BaseException]()
    while waiting.count() and not stopping():
        for future in waiting.next_batch(block=False):
            if future.status in ("pending", "lost"):
                # its worker died with the result between the two: dask computes it again
                waiting.add(future)
                continue
            if future.status == "cancelled":
                # not by us: that comes after this loop
                raise FailedBlocksError(
                    "the dask scheduler has gone",
                    "scheduler and workers stay until the run is done",
                    f"{len(asked)} of {len(numbers)} blocks were still asked for",
                    "start them again, and run the same command again; finished blocks are kept",
                    str(book.folder),
                )
            number = asked.pop(future.key)
            if future.status == "finished":
                yield number, None
            else:
                failed[number] = future.exception()
            future.release()
        time.sleep(0.05)
    if asked:
        # what the workers have begun they finish and keep
        client.cancel([future for future in futures if future.key in asked])
    elif failed:
        raise FailedBlocksError(
            "the workers could not compute all blocks",
            "a block is computed after three attempts at most",
            f"{len(failed)} of {len(numbers)} blocks: {', '.join(map(str, sorted(failed)[:10]))}; "
            f"{next(iter(failed.values()))!r}",
            "mend the cause and run the same command again; finished blocks are kept",
            str(book.folder),
        )
