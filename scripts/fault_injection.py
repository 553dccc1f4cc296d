"""Kill runs at random moments, damage their journals, compute a large atlas, and print the figures.

Exit status 1 if a file differs from that of an undisturbed run, if a reader of the final name ever saw anything but a
missing or a complete file, or if a damaged block was not noticed.
"""

import argparse
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

# Loaded before the first fork, so that a run is killed while it works, but without the kernels, whose threads do not
# survive a fork.
import netCDF4  # noqa: F401 - only to be loaded
import numba  # noqa: F401 - likewise
import xarray  # noqa: F401 - likewise
from journal_cost import large

import sweep
from sweep.errors import StoppedError
from sweep.runs.folder import directory_of
from sweep.runs.journal import BLOCK, BLOCKS, DAMAGED, Journal
from sweep.runs.run import run_to_file

#: A second of work in small blocks, with falls, bounded cells and refinements.
SPEC = sweep.SweepSpec.preset("rolling").replace(roll_rate="0.5:4:60", tilt="0.01deg:60deg:60:log")

#: Cells per block: many small blocks, a few, and a number that does not divide the cells.
BLOCK_CELLS = (40, 333, 1800)


def main() -> None:
    """Run the requested parts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--moments", type=int, default=50, help="kills per threads and block size (default 50)"
    )
    parser.add_argument("--damages", type=int, default=300, help="number of damaged blocks (default 300)")
    parser.add_argument(
        "--cells", type=int, default=10**8, help="cells of the large atlas, 0 for none (default 1e8)"
    )
    parser.add_argument(
        "--pairs",
        type=int,
        default=1,
        help="number of large atlases with a journal, and of ones without (default 1)",
    )
    parser.add_argument("--only-large", action="store_true", help="skip kills, crashes and damages")
    parser.add_argument("--every", type=int, default=1, help="crash before every n-th step (default 1)")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    os.environ["SOURCE_DATE_EPOCH"] = "1700000000"
    dice = random.Random(options.seed)
    with tempfile.TemporaryDirectory(prefix="eulerdisk-soak-", dir=".") as name:
        folder = Path(name)
        wrong = 0 if options.only_large else inject_faults(folder, options, dice)
        if options.cells:
            large(folder, options.cells, options.pairs)
    if wrong:
        sys.exit(f"scripts/soak: something was wrong {wrong} times")


def inject_faults(folder: Path, options: argparse.Namespace, dice: random.Random) -> int:
    """Kill, crash and damage runs; return the number of errors."""
    whole, took = run_undisturbed(folder / "whole.nc")
    print(f"undisturbed run: {SPEC.size} cells, {took[0]:.2f} s, {len(whole)} bytes", flush=True)
    wrong = 0
    for threads in (1, 2):
        for block_cells in BLOCK_CELLS:
            wrong += kill_runs(folder, whole, took, threads, block_cells, options.moments, dice)
    wrong += crash_runs(folder, whole, options.every)
    return wrong + damage_blocks(folder, whole, options.damages, dice)


def child(work: Callable[[], object]) -> int:
    """Do the work in a child process, forked before any kernel ran here, and return the child's process number."""
    number = os.fork()
    if number == 0:
        try:
            work()
            os._exit(0)
        except BaseException as problem:
            if not isinstance(problem, StoppedError):
                print(repr(problem), file=sys.stderr, flush=True)
            os._exit(9)
    return number


def run_undisturbed(path: Path) -> tuple[bytes, tuple[float, float]]:
    """Return the bytes of the file of an undisturbed run, and its seconds in total and from the first block on."""
    took = (0.0, 0.0)
    for _ in range(2):  # the first may have to compile the kernels
        began, working = time.monotonic(), 0.0
        runner, ended, status = child(lambda: run_to_file(SPEC, path, overwrite=True, block_cells=180)), 0, 0
        while not ended:
            if not working and blocks(path):
                working = time.monotonic()
            ended, status = os.waitpid(runner, os.WNOHANG)
            time.sleep(0.001)
        took = (time.monotonic() - began, time.monotonic() - working)
        if status:
            sys.exit("scripts/soak: the undisturbed run failed")
    return path.read_bytes(), took


def kill_runs(
    folder: Path,
    whole: bytes,
    took: tuple[float, float],
    threads: int,
    block_cells: int,
    moments: int,
    dice: random.Random,
) -> int:
    """Kill runs at random moments, `moments` times in total; return the number of errors."""
    wrong = met = finished = seen = kept = 0
    path = folder / "killed.nc"

    def work() -> None:
        run_to_file(SPEC, path, threads=threads, block_cells=block_cells)

    while met < moments:
        path.unlink(missing_ok=True)
        # one kill, or several in a row: a run may be killed while it resumes after an earlier kill
        for _ in range(dice.randint(1, 3)):
            before = blocks(path)
            runner, ended, begun = child(work), 0, time.monotonic()
            # three of four moments are counted from the first new block, the others from the start
            working, share = dice.random() < 0.75, dice.uniform(0.0, 1.1)
            while not ended and time.monotonic() < begun + share * took[working]:
                if working and blocks(path) == before:
                    begun = time.monotonic()
                wrong += not is_absent_or(path, whole)
                seen += 1
                time.sleep(0.001)
                ended, status = os.waitpid(runner, os.WNOHANG)
            if ended:
                wrong += status != 0
                break
            os.kill(runner, signal.SIGKILL)
            os.waitpid(runner, 0)
            met += 1
            kept += blocks(path)
            if is_done(path):
                break
        if not is_done(path):
            _, status = os.waitpid(child(work), 0)
            wrong += status != 0
        finished += 1
        wrong += not path.exists() or path.read_bytes() != whole
        left = [each.name for each in folder.iterdir() if each.name not in ("killed.nc", "whole.nc")]
        wrong += len(left)
    print(
        f"killed: {threads} threads, blocks of {block_cells}: "
        f"{met} kills, {kept / max(met, 1):.1f} blocks kept at each, "
        f"{finished} files, {seen} checks of the final name, {wrong} wrong",
        flush=True,
    )
    path.unlink(missing_ok=True)
    return wrong


def is_absent_or(path: Path, whole: bytes) -> bool:
    """Return whether a reader finds no file or the complete one."""
    try:
        return path.read_bytes() == whole
    except FileNotFoundError:
        return True


def blocks(path: Path) -> int:
    """Return the number of stored blocks of a run."""
    try:
        return sum(name.endswith(BLOCK) for name in os.listdir(directory_of(path) / BLOCKS))
    except FileNotFoundError:
        return 0


def is_done(path: Path) -> bool:
    """Return whether the run is complete; remove a folder that was emptied but not yet removed."""
    folder = directory_of(path)
    if path.exists() and folder.exists() and not list(folder.iterdir()):
        folder.rmdir()
    return path.exists() and not folder.exists()


def crash_runs(folder: Path, whole: bytes, every: int) -> int:
    """Kill a run before every step that it takes on the disk; return the number of errors."""
    path, wrong, crashed, at, status = folder / "crashed.nc", 0, 0, 1, -1

    def counting(real: Callable[..., object], steps: list[int]) -> Callable[..., object]:
        def step(*arguments: object, **options: object) -> object:
            steps[0] += 1
            if steps[0] == at:
                os.kill(os.getpid(), signal.SIGKILL)
            return real(*arguments, **options)

        return step

    def work() -> None:
        steps = [0]
        for name in ("mkdir", "open", "fsync", "replace", "unlink", "rmdir"):
            setattr(os, name, counting(getattr(os, name), steps))
        run_to_file(SPEC, path, block_cells=1800)

    while status:
        path.unlink(missing_ok=True)
        _, status = os.waitpid(child(work), 0)
        crashed += status == signal.SIGKILL
        wrong += status not in (0, signal.SIGKILL)
        wrong += not is_absent_or(path, whole)
        if not is_done(path):
            _, again = os.waitpid(child(lambda: run_to_file(SPEC, path)), 0)
            wrong += again != 0
        wrong += not is_done(path) or path.read_bytes() != whole
        at += every
    path.unlink()
    print(f"crashed: before {crashed} of {at - every} steps on the disk, {wrong} wrong", flush=True)
    return wrong


def damage_blocks(folder: Path, whole: bytes, count: int, dice: random.Random) -> int:
    """Damage blocks in every way; return how many damages were not noticed, or spoilt the file."""
    path, caught = folder / "damaged.nc", 0

    def stopped() -> None:
        looks = iter(range(100))
        run_to_file(SPEC, path, block_cells=180, stopping=lambda: next(looks) >= 12)

    os.waitpid(child(stopped), 0)
    journal = Journal.at(directory_of(path))
    held = [paths[0] for paths in journal.held().values()]
    for _ in range(count):
        victim = dice.choice(held)
        good = victim.read_bytes()
        victim.write_bytes(damage(good, dice))
        missing, _ = journal.verify([int(victim.name[:6])])
        caught += len(missing)
        for each in (journal.folder / BLOCKS).glob(f"*{DAMAGED}"):
            each.unlink()
        victim.write_bytes(good)
    for victim in held[::2]:
        victim.write_bytes(damage(victim.read_bytes(), dice))
    os.waitpid(child(lambda: run_to_file(SPEC, path)), 0)
    same = path.exists() and path.read_bytes() == whole
    print(
        f"damaged: {caught} of {count} caught; file unchanged after {len(held[::2])} blocks were repaired: {same}"
    )
    return count - caught + (not same)


def damage(good: bytes, dice: random.Random) -> bytes:
    """Return the content cut off, with a tail of zeros, or with one bit flipped."""
    place = dice.randrange(len(good))
    kind = dice.choice(("cut", "zeros", "bit"))
    if kind == "cut":
        return good[:place]
    if kind == "zeros":
        # a power failure leaves this if the last pages were not written
        place = min(place, len(good.rstrip(b"\0")) - 1)
        return good[:place] + bytes(len(good) - place)
    return good[:place] + bytes([good[place] ^ 1 << dice.randrange(8)]) + good[place + 1 :]


if __name__ == "__main__":
    main()
