"""The executor that uses the workers of a dask scheduler, which write to the shared folder of the run."""

import contextlib
import logging
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sweep.engine.compute import measure_block, usable_threads, use_threads
from sweep.errors import FailedBlocksError, RequestError, are, counted
from sweep.runs.executor import Executor, FinishedBlock, Say, Stopping, no_op
from sweep.runs.journal import Journal
from sweep.runs.run_directory import check_same_run

#: Seconds to wait for the answer of a scheduler.
_TIMEOUT = 10

#: Held while a block is computed: the kernels use all threads of the worker, so only one block may run at a time.
_KERNELS = threading.Lock()


def on_cluster(address: str, say: Say = no_op) -> Executor:
    """Return the executor that uses the workers of the dask scheduler at an address such as ``tcp://host:8786``."""
    try:
        import distributed  # noqa: F401 - only to see that it is installed
    except ImportError as problem:
        raise RequestError(
            f"The package distributed is needed for this, but cannot be imported: {problem}.",
            hint="Run `pip install distributed` here and on the workers.",
            where="--dask",
        ) from problem

    def execute(journal: Journal, numbers: Sequence[int], stopping: Stopping) -> Iterator[FinishedBlock]:
        if numbers:
            with _connection(address, journal) as client:
                if not client.scheduler_info()["workers"]:
                    say(f"the scheduler has no workers yet; start some with `dask worker {address}`")
                yield from _compute_blocks(client, journal, numbers, stopping)

    return execute


def compute_block(folder: str, fingerprint: str, number: int) -> None:
    """Compute one block and keep it in the journal; runs on a worker.

    `folder` is the path of the run's folder on the worker, `fingerprint` the fingerprint of the run's manifest. Raises
    a RequestError if the folder has another run, or if this program computes other bits than the one that began it.
    """
    from distributed import get_worker

    journal = Journal.at(Path(folder))
    check_same_run(journal, journal.spec)
    if journal.manifest.fingerprint != fingerprint:
        raise RequestError(
            "On this worker the folder has another run than on the machine that started it.",
            hint="Share the folder of the output: all machines must see it at the same path.",
            where=folder,
        )
    # as many as dask gives this worker, so that several workers can share a machine
    threads = min(int(get_worker().state.nthreads), usable_threads(None))
    with _KERNELS:
        use_threads(threads)
        measured = measure_block(journal.spec, journal.spans[number])
    journal.keep(number, measured)


@contextlib.contextmanager
def _connection(address: str, journal: Journal) -> Iterator[Any]:
    """Yield a client of the scheduler at an address; raise a FailedBlocksError if the scheduler is lost.

    The logs of dask about a lost scheduler, several tracebacks, are suppressed.
    """
    import asyncio
    import concurrent.futures

    client = None
    with _without_logs("distributed"):
        try:
            client = _connect(address)
            yield client
        except (asyncio.CancelledError, concurrent.futures.CancelledError, OSError) as problem:
            # an error of the connection is an OSError of dask; other OSErrors come from writing the file
            own = not isinstance(problem, OSError) or isinstance(problem, TimeoutError)
            if own or type(problem).__module__.startswith("distributed"):
                raise _lost(journal) from problem
            raise
        finally:
            if client is not None:
                with contextlib.suppress(OSError, concurrent.futures.CancelledError):
                    client.close()


@contextlib.contextmanager
def _without_logs(package: str) -> Iterator[None]:
    """Silence the loggers of a package."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] == package]
    before = {name: logging.getLogger(name).disabled for name in names}
    try:
        for name in names:
            logging.getLogger(name).disabled = True
        yield
    finally:
        for name, disabled in before.items():
            logging.getLogger(name).disabled = disabled


def _lost(journal: Journal) -> FailedBlocksError:
    missing = len(journal.spans) - len(journal.held())
    return FailedBlocksError(
        f"The dask scheduler ended before the run: {counted(missing, 'block', len(journal.spans))} "
        f"{are(missing, 'was', 'were')} not computed yet.",
        hint="Start scheduler and workers again, and run the same command again; finished blocks are kept.",
        where=str(journal.folder),
    )


def _connect(address: str) -> Any:
    from distributed import Client
    from distributed.comm import parse_address, parse_host_port

    try:
        scheme, place = parse_address(address)
        if scheme in ("tcp", "tls"):
            # without host and port a client fails to start, and then takes 20 s to close
            parse_host_port(place)
        return Client(address, timeout=_TIMEOUT, set_as_default=False, name="eulerdisk")
    except (OSError, ValueError, TimeoutError) as problem:
        raise RequestError(
            f"No running dask scheduler answers at the address {address}: {problem}.",
            hint="Start one with `dask scheduler`, and workers with `dask worker ADDRESS`.",
            where="--dask",
        ) from problem


def _compute_blocks(
    client: Any, journal: Journal, numbers: Sequence[int], stopping: Stopping
) -> Iterator[FinishedBlock]:
    from distributed import as_completed

    futures = client.map(
        compute_block,
        [str(journal.folder.resolve())] * len(numbers),
        [journal.manifest.fingerprint] * len(numbers),
        numbers,
        pure=False,
        retries=2,
    )
    numbers_left = dict(zip((future.key for future in futures), numbers, strict=True))
    waiting, failed = as_completed(futures, loop=client.loop), dict[int, BaseException]()
    while waiting.count() and not stopping():
        for future in waiting.next_batch(block=False):
            if future.status in ("pending", "lost"):
                # its worker died after it finished the block and before its status was read: dask computes it again
                waiting.add(future)
                continue
            if future.status == "cancelled":
                # the scheduler has ended: this process cancels tasks only after the loop
                raise _lost(journal)
            number = numbers_left.pop(future.key)
            if future.status == "finished":
                yield number, None
            else:
                failed[number] = future.exception()
            future.release()
        time.sleep(0.05)
    if numbers_left:
        # blocks that workers have begun are finished and kept
        client.cancel([future for future in futures if future.key in numbers_left])
    elif failed:
        first = ", ".join(map(str, sorted(failed)[:10]))
        raise FailedBlocksError(
            f"The workers could not compute {counted(len(failed), 'block', len(numbers))} ({first}) in three attempts "
            f"each; one of the errors is {next(iter(failed.values()))!r}.",
            hint="Remove the cause and run the same command again; finished blocks are kept.",
            where=str(journal.folder),
        )
