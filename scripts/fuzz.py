"""Feed damaged and foreign files, spec files and words to every command that reads, and judge how each case ends.

A case is one command line. It ends well if it has a documented exit status, takes at most 10 s and 1 GB of resident
memory, and reports a refusal in one printable line, without a traceback, a hang or the end of its process. Many cases
run in one process, which is replaced if a case ended it. Exit status 1 if a case did not end well.
"""

import argparse
import collections
import json
import os
import random
import re
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from damage import damage_file
from odd_words import spec_file, words

from sweep.errors import printable

#: Processor time [s] and resident memory [bytes] that a case may take, and wall time [s] after which it hangs; the
#: latter is longer because the machine may have other work.
MOST_SECONDS, MOST_BYTES, PATIENCE = 10.0, 10**9, 60.0

#: Memory [bytes] from which on a process is replaced, so that the remains of its cases do not count for the next one.
_WORN = 6 * 10**8

#: Largest number of printed cases that end badly in the same way.
_MOST_PRINTED = 3

#: Allowed exit statuses of a case: done, a check that failed, a refused request, a file system that refuses.
_STATUSES = (0, 1, 2, 3)

#: Name -> the command that is run on each file.
READING = {
    "info": "info {}",
    "boundary": "boundary {}",
    "criterion": "boundary {} --criterion departure:1deg -o OUT/boundary.nc --overwrite",
    "own": "boundary {} --criterion not(tilt_max<1.5*tilt)or(nutation_period>3s) --refine 0.1",
    "refine": "boundary {} --refine 0.01",
    "plot": "plot {} -o OUT/map.png",
    "friction": "plot {} WHOLE --friction 0.5 -o OUT/map.svg",
    "regimes": "plot {} --regimes -o OUT/regimes.png",
    "verify": "verify {} --write OUT/audit.nc --overwrite",
    "compare": "compare {} WHOLE",
    "reference": "compare WHOLE {} --json --junit OUT/out.xml",
    "common": "compare {} WHOLE --common",
    "explain": "explain {} tilt=2deg roll_rate=2.5 --plot OUT/cell.png",
    "csv": "export {} --to csv -o OUT/out.csv --overwrite",
    "parquet": "export {} --to parquet -o OUT/out.parquet --overwrite",
    "zarr": "export {} --to zarr -o OUT/out.zarr --overwrite",
    "run": "run --from {} -o OUT/again.nc --overwrite",
}

#: Intact atlases, of which damaged ones are made, and their words.
WHOLE = {
    "rolling.nc": "rolling roll_rate=2:3:8 tilt=0.1deg:5deg:6:log contact=yes",
    "curves.nc": "rolling roll_rate=2:4:7 tilt=1deg,2deg,4deg boundary=refined:1e-3 title='a < b'",
    "circling.nc": "circling precession_rate=0.5:4:6 tilt=5deg,10deg method=exact",
    "own.nc": "rolling roll_rate=2:4:7 tilt=1deg,2deg criterion=peak_tilt>3*tilt",
    "line.nc": "spinning precession_rate=1:6:9 tilt_rate=0.01",
    "random.nc": "rolling roll_rate=uniform:2:3 tilt=normal:1deg:0.5deg samples=48 contact=yes",
    "steady.nc": "rolling tilt=10deg tilt_rate=0.01 alpha=0.5,1 precession_rate=0.5:2:4 roll_rate=steady",
}

_CONTROL = re.compile(r"[^\n\x20-\x7e\xa0-\U0010ffff]|[\u202a-\u202e\u2066-\u2069]")


@dataclass(frozen=True)
class End:
    """The end of a case: status, outputs, processor time [s], largest resident memory; `fault` is set after a crash."""

    status: object
    out: str
    err: str
    seconds: float
    resident: int
    fault: str = ""


def faults(end: End) -> list[str]:
    """Return the faults in how a case ended, as text; empty if it ended well."""
    if end.fault:
        return [end.fault]
    found = []
    if end.status not in _STATUSES:
        last = end.err.strip().rpartition("\n")[2]
        found.append(f"status {end.status}: {last[:300]}")
    if end.seconds > MOST_SECONDS:
        found.append(f"{end.seconds:.0f} s")
    if end.resident > MOST_BYTES:
        found.append(f"{end.resident / 1e9:.1f} GB")
    if _CONTROL.search(end.out + end.err):
        found.append("control characters")
    if "Traceback" in end.out + end.err or "Warning" in end.err or "HDF5-DIAG" in end.err:
        found.append(f"text for developers: {end.err.strip()[-300:]}")
    if end.status == 2 and not (end.err.startswith(("eulerdisk: ", "Usage: ")) and len(end.err) < 10_000):
        found.append(f"no message of at most 10 kB: {end.err[:200]!r}")
    if len(end.out) > 10**6:
        found.append("a megabyte of output")
    return found


class Worker:
    """A process that runs command lines one after the other; it is replaced after a crash or a hang."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._process: subprocess.Popen[bytes] | None = None

    def run(self, line: list[str], patience: float = PATIENCE) -> End:
        """Run one command line; stop it if it takes longer than `patience` or more than twice the allowed memory."""
        if self._process is not None and _resident_memory(self._process.pid) > _WORN:
            self.close()
        process = self._process or self._start()
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(json.dumps(line).encode() + b"\n")
        process.stdin.flush()
        began = time.monotonic()
        fault = ""
        while not fault:
            if select.select([process.stdout], [], [], 0.05)[0]:
                answer = process.stdout.readline()
                if answer:
                    return End(**json.loads(answer))
                fault = f"the process ended with {process.wait()}: {self._last_words()}"
            elif time.monotonic() - began > patience:
                fault = f"it hung for more than {patience:.0f} s"
            elif _resident_memory(process.pid) > 2 * MOST_BYTES:
                fault = "more than 2 GB of resident memory"
        self.close()
        return End(None, "", "", time.monotonic() - began, 0, fault)

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None

    def _last_words(self) -> str:
        return (self._folder / "err").read_text(encoding="utf-8", errors="replace").strip()[-300:]

    def _start(self) -> subprocess.Popen[bytes]:
        self._process = subprocess.Popen(
            [sys.executable, __file__, "--worker", str(self._folder)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=self._folder,
        )
        # wait until imports and kernels are loaded before the first case is timed
        assert self._process.stdout is not None
        self._process.stdout.readline()
        return self._process


def _resident_memory(process: int) -> int:
    try:
        status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    except OSError:
        return 0
    found = re.search(r"VmRSS:\s+(\d+)", status)
    return int(found[1]) * 1024 if found else 0


def work(folder: Path) -> None:
    """Run the command lines from standard input, and answer on standard output; runs in the process of a `Worker`."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    from sweep import cli

    for warm in (["verify", "rolling.nc"], ["plot", "rolling.nc", "--regimes", "-o", "OUT/warm.png"]):
        _run_line(cli.main, warm, folder)
    print("ready", file=answers, flush=True)
    for line in sys.stdin:
        print(json.dumps(_run_line(cli.main, json.loads(line), folder)), file=answers, flush=True)


def _run_line(main: object, line: list[str], folder: Path) -> dict[str, object]:
    import traceback

    # C libraries write to the file descriptors, bypassing sys.stdout
    handles = [os.open(folder / name, os.O_RDWR | os.O_CREAT | os.O_TRUNC) for name in ("out", "err")]
    for number, handle in enumerate(handles, 1):
        os.dup2(handle, number)
    sys.argv = ["eulerdisk", *line]
    _reset_peak()
    began = _processor_time()
    status: object = 0
    try:
        main()  # type: ignore[operator]
    except SystemExit as end:
        status = end.code or 0
    except BaseException:
        status = "exception"
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    seconds = _processor_time() - began
    texts = [_text(handle) for handle in handles]
    return {"status": status, "out": texts[0], "err": texts[1], "seconds": seconds, "resident": _peak()}


def _processor_time() -> float:
    """Return the processor time [s] of this process and its finished children."""
    return sum(os.times()[:4])


def _text(handle: int) -> str:
    os.lseek(handle, 0, os.SEEK_SET)
    with os.fdopen(handle, "rb") as file:
        return file.read(10**7).decode("utf-8", "replace")


def _reset_peak() -> None:
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    except OSError:
        # the peak then includes all earlier cases, which is too strict
        return


def _peak() -> int:
    """Return the largest resident memory since `_reset_peak` [bytes]; 0 on systems without /proc."""
    try:
        found = re.search(r"VmHWM:\s+(\d+)", Path("/proc/self/status").read_text(encoding="ascii"))
    except OSError:
        return 0
    return int(found[1]) * 1024 if found else 0


def cases(folder: Path, options: argparse.Namespace) -> Iterator[tuple[str, list[str]]]:
    """Yield each case: its description, and its command line."""
    wholes = [folder / name for name in WHOLE]
    for number in range(options.first, options.first + options.count):
        dice = random.Random(f"{options.seed} file {number}")
        path = folder / f"case-{number}.nc"
        how = damage_file(path, wholes, dice)
        for name in options.commands:
            line = READING[name].format(path.name).replace("WHOLE", dice.choice(wholes).name)
            yield f"file {number} ({how})", line.split()
        if not options.keep:
            _remove(path)
    for number in range(options.first, options.first + options.words):
        dice = random.Random(f"{options.seed} words {number}")
        yield f"words {number}", words(dice)
        path = folder / f"spec-{number}.toml"
        yield f"spec file {number} ({spec_file(path, dice)})", ["plan", path.name, "--no-calibrate"]
        if not options.keep:
            _remove(path)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        path.rmdir()
    else:
        path.unlink(missing_ok=True)


def prepare_atlases(folder: Path) -> None:
    """Compute the intact atlases in a folder."""
    import shlex

    import sweep

    (folder / "OUT").mkdir()
    for name, line in WHOLE.items():
        preset, *changes = shlex.split(line)
        sweep.run_to_file(sweep.SweepSpec.from_words(preset, changes), folder / name)


def main() -> None:
    """Run the requested cases, and print what went wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="number of damaged files (default 1000)")
    parser.add_argument(
        "--words", type=int, default=1000, help="number of requests, and of spec files (default 1000)"
    )
    parser.add_argument("--quick", action="store_true", help="a tenth of both")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first file; with --count 1 to repeat one file"
    )
    parser.add_argument(
        "--commands",
        nargs="+",
        default=list(READING),
        choices=READING,
        help="commands that are run on each file",
    )
    parser.add_argument("--keep", type=Path, help="work in this new folder, and keep the files")
    parser.add_argument("--worker", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.quick:
        options.count, options.words = options.count // 10, options.words // 10
    if options.worker:
        work(options.worker)
        return
    with tempfile.TemporaryDirectory(prefix="eulerdisk-fuzz-") as name:
        folder = options.keep or Path(name)
        folder.mkdir(exist_ok=True)
        prepare_atlases(folder)
        wrong = fuzz(folder, options)
    if wrong:
        sys.exit(f"scripts/fuzz: {wrong} cases did not end well")


def fuzz(folder: Path, options: argparse.Namespace) -> int:
    """Run the cases, print those that did not end well and a summary, and return the number of bad ones."""
    worker, wrong, began = Worker(folder), 0, time.monotonic()
    statuses: collections.Counter[str] = collections.Counter()
    alike: collections.Counter[str] = collections.Counter()
    slowest, largest = 0.0, 0
    for what, line in cases(folder, options):
        end = worker.run(line)
        statuses[str(end.status)] += 1
        slowest, largest = max(slowest, end.seconds), max(largest, end.resident)
        found = faults(end)
        wrong += bool(found)
        for fault in found:
            alike[kind := re.sub(r"\d+|case-\S+", "", fault)[:60]] += 1
            if alike[kind] <= _MOST_PRINTED:
                print(f"{what}: eulerdisk {printable(' '.join(line))[:200]}\n    {fault}", flush=True)
    worker.close()
    for kind, count in alike.most_common():
        print(f"{count:>5} x {kind}")
    counts = ", ".join(f"{count} with {status}" for status, count in sorted(statuses.items()))
    print(
        f"{sum(statuses.values())} cases in {time.monotonic() - began:.0f} s: {counts}; slowest {slowest:.1f} s, "
        f"largest {largest / 1e6:.0f} MB"
    )
    return wrong


if __name__ == "__main__":
    main()
