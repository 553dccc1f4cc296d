"""Time and memory of a large atlas, and the share of the journal in the time; `scripts/soak` prints the figures."""

import os
import resource
import struct
import time
import traceback
from pathlib import Path
from typing import Any
from unittest import mock

import sweep
from sweep.runs.journal import Journal
from sweep.runs.run import run_to_file


def large(folder: Path, cells: int, pairs: int) -> None:
    """Compute an atlas of many cells with a short time horizon, with and without a journal; print the cost of each.

    The cost of the journal is the difference between runs with and without it, in wall time and in processor time
    (including system time). Other processes disturb the two runs differently, so the processor time inside
    `Journal.keep` is printed too.
    """
    count = round(cells**0.5)
    spec = sweep.SweepSpec.preset("rolling").replace(
        roll_rate=f"0.5:6:{count}", tilt=f"0.01deg:20deg:{count}:log", duration=0.05
    )
    path = folder / "large.nc"

    def work(answer: int, journaled: bool) -> None:
        spent, keep = [0.0], Journal.keep

        def timed(*arguments: Any) -> None:
            began = time.thread_time()
            if journaled:
                keep(*arguments)
            spent[0] += time.thread_time() - began

        began = time.monotonic()
        with mock.patch.object(Journal, "keep", timed):
            run_to_file(spec, path, overwrite=True)
        took, used = time.monotonic() - began, resource.getrusage(resource.RUSAGE_SELF)
        processor, memory = used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / 1e9
        os.write(answer, struct.pack("4d", took, processor, spent[0], memory))

    def measure(journaled: bool) -> tuple[float, ...]:
        reading, writing = os.pipe()
        number = os.fork()
        if number == 0:
            # in a child process, whose peak memory is that of this run
            try:
                work(writing, journaled)
                os._exit(0)
            except BaseException:
                traceback.print_exc()
                os._exit(1)
        os.waitpid(number, 0)
        os.close(writing)
        os.sync()  # write one run's remaining data first, so that it does not slow down the next run
        with os.fdopen(reading, "rb") as answer:
            return struct.unpack("4d", answer.read())

    print(f"large: {spec.size} cells; the disk takes {disk_rate(folder) / 1e6:.0f} MB/s", flush=True)
    for pair in range(pairs):
        # alternate the order, so that neither profits from the caches of the other
        found = {journaled: measure(journaled) for journaled in ((True, False), (False, True))[pair % 2]}
        (took, used, kept, memory), (bare_took, bare_used, *_) = found[True], found[False]
        print(
            f"large: {took:.0f} s ({spec.size / took:.3g} cells/s), {memory:.2f} GB resident at most, "
            f"file {path.stat().st_size / 1e9:.2f} GB; without a journal {bare_took:.0f} s: it is "
            f"{100 * (took - bare_took) / took:.1f} % of the time, {100 * (used - bare_used) / used:.1f} % of "
            f"{used:.0f} s of processor time; keeping blocks takes {100 * kept / used:.1f} % of it",
            flush=True,
        )


def disk_rate(folder: Path, size: int = 2**28) -> float:
    """Return the write rate of the disk [bytes/s], including fsync."""
    path, data = folder / "rate", os.urandom(2**22)
    began = time.monotonic()
    with open(path, "wb") as file:
        for _ in range(size // len(data)):
            file.write(data)
        os.fsync(file.fileno())
    took = time.monotonic() - began
    path.unlink()
    return size / took
